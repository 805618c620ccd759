//! What can be read of an instance of FMI 3.0, and what it does in a state that nobody wrote.

use std::ptr::null_mut;
use std::sync::LazyLock;

use cradle_host::fmi3::Host;
use newtons_cradle::fmi3::fmi3Status::{fmi3Discard, fmi3Error, fmi3OK};
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
        let Some(values) = floats(host, picture, *array) else { continue };
        assert!(values.iter().all(|value| value.is_finite()), "{array} = {values:?} in {:?}", picture);
        if array.row.causality == Causality::Independent {
            assert_eq!(values, [picture.time]);
        }
    }
    for clock in of_type(Type::Clock) {
        assert!(!host.is_active(&clock.to_string()) || picture.phase == Phase::Event);
    }
}

/// The values of an array, which are refused only after extreme ones have been set.
pub fn floats(host: &Host, picture: &Picture, array: Variable) -> Option<Vec<f64>> {
    let mut values = vec![f64::NAN; array.len(picture.balls)];
    let status = unsafe { fmi3GetFloat64(host.c, &array.reference(), 1, values.as_mut_ptr(), values.len()) };
    assert!(status == fmi3OK || picture.extreme && status == fmi3Discard, "{array} in {picture:?}: {status:?}");
    (status == fmi3OK).then_some(values)
}

/// Reads a forged state: it is refused, and then nothing has changed, or accepted, and then it is a state, which can be
/// looked at, written and read. It is gone on from only if the settings are those of before, and not far if balls move
/// as none do: with a mass of 1e-300 kg, or balls 1e100 m within each other, it would take long.
pub fn forge(host: &Host, picture: &Picture, changes: &[Change]) {
    host.within(|_, _, _| false);
    let (all, settings) = (|_: &Variable| true, |array: &Variable| array.row.settable());
    let [before, own] = [values(host, picture, all), values(host, picture, settings)];
    let (bytes, mut state) = (host.to_bytes(), null_mut());
    let forged = forged(&bytes, changes);
    let status = unsafe { fmi3DeserializeFMUState(host.c, forged.as_ptr(), forged.len(), &mut state) };
    if status != fmi3OK {
        assert!(status == fmi3Error && state.is_null());
        assert!(host.log().last().is_some_and(|line| line.contains("the state is refused: ")));
        let after = values(host, picture, all);
        assert!(after.is_none() || after == before, "a refused state has changed something");
        return;
    }
    assert!(host.to_bytes() == bytes, "reading bytes has changed the instance");
    unsafe {
        assert_eq!(fmi3SetFMUState(host.c, state), fmi3OK);
        assert_eq!(fmi3FreeFMUState(host.c, &mut state), fmi3OK);
    }
    let bytes = host.to_bytes();
    assert_eq!(host.set_bytes(&bytes), fmi3OK);
    assert!(host.to_bytes() == bytes, "its own bytes read and written are others");
    if own.is_none() || values(host, picture, settings) != own {
        return;
    }
    if picture.phase != Phase::Step {
        // Events there may be, of any number, but an end of them.
        return (0..3).for_each(|_| assert!(host.update().0 <= fmi3Error));
    }
    // What a forged state amounts to may be beyond the range of doubles.
    let moves = |array: &Variable| ["x", "v"].contains(&array.row.name);
    let everyday = |moves: Vec<f64>| moves.iter().all(|value| value.abs() < 10.0);
    if !picture.extreme && values(host, picture, moves).is_some_and(everyday) && values(host, picture, all).is_some() {
        // Short: a forged contact may open and close every 1e-13 s.
        let (status, ..) = host.step(host.floats("time", 1)[0], 1e-8);
        assert!(status == fmi3OK || status == fmi3Error, "{status:?}");
    }
}

/// Real variables and enumerations of a kind, where all of them can be read. Those of settings are allowed.
fn values(host: &Host, picture: &Picture, of: fn(&Variable) -> bool) -> Option<Vec<f64>> {
    let value = |array: Variable| {
        let (mut values, mut item) = (vec![f64::NAN; array.len(picture.balls)], 0);
        let (c, n, reference) = (host.c, values.len(), array.reference());
        let of_items = array.row.access.data_type() == Type::Enumeration;
        let status = if of_items {
            unsafe { fmi3GetInt64(c, &reference, 1, &mut item, 1) }
        } else {
            unsafe { fmi3GetFloat64(c, &reference, 1, values.as_mut_ptr(), n) }
        };
        if of_items {
            values[0] = item as f64;
        }
        let allowed = |value: &f64| array.check(*value).is_ok();
        let sound = status != fmi3OK || !array.row.settable() || values.iter().all(allowed);
        assert!(sound, "{array} = {values:?} was accepted");
        (status == fmi3OK).then_some(values)
    };
    let arrays = FLOATS.iter().copied().chain(of_type(Type::Enumeration)).filter(of);
    let all = if picture.may_read() { arrays.map(value).collect::<Option<Vec<_>>>() } else { None };
    all.map(|values| values.concat())
}
