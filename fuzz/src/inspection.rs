//! What can be read of an instance of FMI 3.0, and what it does in a state that nobody wrote.

use std::ptr::null_mut;
use std::sync::LazyLock;

use newtons_cradle::fmi3::fmi3Status::{fmi3Error, fmi3OK};
use newtons_cradle::fmi3::*;
use newtons_cradle::variables::{Array, Causality, Type};

use crate::forgery::{Change, forged};
use crate::hybrid::{Call, Phase, Picture, of_type};
use crate::instance3::Host;

/// Everything that has real values.
pub static FLOATS: LazyLock<Vec<Array>> = LazyLock::new(|| of_type(Type::Real));

/// What can be read is finite, and clocks are active in Event Mode only.
pub fn look(host: &Host, picture: &Picture) {
    if !picture.allows(Call::Get) {
        return;
    }
    for array in &*FLOATS {
        let mut values = vec![f64::NAN; array.len(picture.balls)];
        let n = values.len();
        let status = unsafe { fmi3GetFloat64(host.c, &array.reference(), 1, values.as_mut_ptr(), n) };
        assert_eq!(status, fmi3OK, "{array} in {:?}", picture);
        assert!(values.iter().all(|value| value.is_finite()), "{array} = {values:?} in {:?}", picture);
        if array.row.causality == Causality::Independent {
            assert_eq!(values, [picture.time]);
        }
    }
    for clock in of_type(Type::Clock) {
        let mut active = 9;
        assert_eq!(unsafe { fmi3GetClock(host.c, &clock.reference(), 1, &mut active) }, fmi3OK);
        assert!(active == 0 || active == 1 && picture.phase == Phase::Event);
    }
}

/// Goes on from a forged state, if it is accepted and has the same parameters.
pub fn forge(host: &Host, picture: &Picture, changes: &[Change]) {
    let (c, mut state) = (host.c, null_mut());
    let before = parameters(host, picture);
    let bytes = forged(&host.bytes(), changes);
    unsafe {
        let status = fmi3DeserializeFMUState(c, bytes.as_ptr(), bytes.len(), &mut state);
        if status != fmi3OK {
            assert!(status == fmi3Error && state.is_null());
            return;
        }
        assert_eq!(fmi3SetFMUState(c, state), fmi3OK);
        assert_eq!(fmi3FreeFMUState(c, &mut state), fmi3OK);
        let bytes = host.bytes();
        assert_eq!(fmi3DeserializeFMUState(c, bytes.as_ptr(), bytes.len(), &mut state), fmi3OK);
        assert_eq!(fmi3FreeFMUState(c, &mut state), fmi3OK);
        if before.is_none() || parameters(host, picture) != before {
            return;
        }
        // Events there may be, of any number, but an end of them.
        let mut other = [0u8; 5];
        let [again, ended, nominals, values, defined] = &mut other;
        for _ in 0..3 {
            let status = fmi3UpdateDiscreteStates(c, again, ended, nominals, values, defined, &mut 0.0);
            assert!(status <= fmi3Error);
        }
    }
}

/// All real parameters, bit by bit, where they can be read.
fn parameters(host: &Host, picture: &Picture) -> Option<Vec<u64>> {
    let mut bits = Vec::new();
    for array in FLOATS.iter().filter(|array| array.row().is_some_and(|row| row.name.contains('.'))) {
        let mut values = vec![f64::NAN; array.len(picture.balls)];
        let n = values.len();
        if !picture.allows(Call::Get)
            || unsafe { fmi3GetFloat64(host.c, &array.reference(), 1, values.as_mut_ptr(), n) } != fmi3OK
        {
            return None;
        }
        bits.extend(values.into_iter().map(f64::to_bits));
    }
    Some(bits)
}
