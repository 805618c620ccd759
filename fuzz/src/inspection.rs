//! What can be read of an instance of FMI 3.0, and what it does in a state that nobody wrote.

use std::sync::LazyLock;

use cradle_host::fmi3::Host;
use newtons_cradle::fmi3::fmi3Status::{fmi3Error, fmi3OK};
use newtons_cradle::fmi3::*;
use newtons_cradle::variables::{Causality, Type, Variable};

use crate::forgery::{Change, forged};
use crate::hybrid::{Phase, Picture, of_type};

/// All real variables.
pub static FLOATS: LazyLock<Vec<Variable>> = LazyLock::new(|| of_type(Type::Real));

/// What can be read is finite, and clocks are active in Event Mode only.
pub fn look(host: &Host, picture: &Picture) {
    if !picture.may_read() {
        return;
    }
    for array in &*FLOATS {
        let values = host.floats(&array.to_string(), array.len(picture.balls));
        assert!(values.iter().all(|value| value.is_finite()), "{array} = {values:?} in {:?}", picture);
        if array.row.causality == Causality::Independent {
            assert_eq!(values, [picture.time]);
        }
    }
    for clock in of_type(Type::Clock) {
        assert!(!host.is_active(&clock.to_string()) || picture.phase == Phase::Event);
    }
}

/// Goes on from a forged state, if it is accepted and has the same parameters.
pub fn forge(host: &Host, picture: &Picture, changes: &[Change]) {
    let before = parameters(host, picture);
    let status = host.set_bytes(&forged(&host.to_bytes(), changes));
    if status != fmi3OK {
        assert_eq!(status, fmi3Error);
        return;
    }
    assert_eq!(host.set_bytes(&host.to_bytes()), fmi3OK);
    if before.is_some() && parameters(host, picture) == before {
        // Events there may be, of any number, but an end of them.
        (0..3).for_each(|_| assert!(host.update().0 <= fmi3Error));
    }
}

/// All real parameters, bit by bit, where they can be read.
fn parameters(host: &Host, picture: &Picture) -> Option<Vec<u64>> {
    let mut bits = Vec::new();
    for array in FLOATS.iter().filter(|array| array.row.causality == Causality::Parameter) {
        let mut values = vec![f64::NAN; array.len(picture.balls)];
        let n = values.len();
        if !picture.may_read()
            || unsafe { fmi3GetFloat64(host.c, &array.reference(), 1, values.as_mut_ptr(), n) } != fmi3OK
        {
            return None;
        }
        bits.extend(values.into_iter().map(f64::to_bits));
    }
    Some(bits)
}
