//! Values of a step: they are those of the step that was made, whatever is set after it, or in its middle.

use std::cell::RefCell;
use std::rc::Rc;

use super::*;

/// Means and peaks of the last step.
const OF_STEP: [(&str, usize); 3] = [("F_mean", 5), ("F_peak", 5), ("F_support_mean", 1)];

/// Outputs with derivatives by the inputs over the last step.
const DERIVED: [(&str, usize); 4] = [("x", 5), ("impulse", 5), ("F_mean", 5), ("F_support_mean", 1)];

fn values(host: &Host, of: &[(&str, usize)]) -> Vec<f64> {
    of.iter().flat_map(|(name, length)| host.floats(name, *length)).collect()
}

/// Derivatives of outputs by a force on the first ball over the last step.
fn derivatives_of_step(host: &Host) -> Result<Vec<f64>, Vec<String>> {
    let unknowns = DERIVED.map(|(name, _)| vr(name));
    let mut found = vec![f64::NAN; DERIVED.iter().map(|(_, length)| length).sum()];
    match host.derivatives(false, [&unknowns, &[vr("F_ext")]], &[1.0, 0.0, 0.0, 0.0, 0.0], &mut found) {
        fmi3OK => Ok(found),
        _ => Err(host.log()),
    }
}

fn assert_same(own: &[f64], other: &[f64], tolerance: f64, what: &str) {
    for (own, other) in own.iter().zip(other) {
        assert!((own - other).abs() <= tolerance * other.abs().max(1e-3), "{what}: {own:e} {other:e}");
    }
}

/// An instance with event mode and these settings, in Step Mode, whose derivatives are those of the last step.
fn stepping(reals: &[(&str, &[f64])], items: &[(&str, i64)]) -> Host {
    let host = Host::new(true, false);
    reals.iter().for_each(|(name, values)| assert_eq!(host.set(name, values), fmi3OK, "{name}"));
    for (name, item) in [("derivatives.of", 2)].iter().chain(items) {
        assert_eq!(unsafe { fmi3SetInt64(host.c, &vr(name), 1, item, 1) }, fmi3OK, "{name}");
    }
    host.start();
    assert_eq!(unsafe { fmi3EnterStepMode(host.c) }, fmi3OK);
    host
}

/// Settings, items of enumerations, and the length of a step (s): within and between contacts, by every method.
type Scene = (&'static [(&'static str, &'static [f64])], &'static [(&'static str, i64)], f64);

const SOFT: &[(&str, &[f64])] = &[
    ("contact.stiffness", &[2e3]),
    ("contact.overlapRef", &[1.0]),
    ("contact.damping", &[3.0]),
    ("pendulum.drag", &[0.2]),
    ("F_ext", &[0.5, 0.0, 0.1, 0.0, 0.0]),
];
const PRESSED: &[(&str, &[f64])] = &[
    ("contact.deadBand", &[0.0]),
    ("x_start", &[0.0; 5]),
    ("pendulum.drag", &[0.1]),
    ("F_ext", &[5.0, 0.0, 0.0, 0.0, -3.0]),
];
const SCENES: [Scene; 9] = [
    (&[], &[], 1.0),
    (SOFT, &[], 0.72),
    (SOFT, &[("solver.method", 2)], 0.72),
    (SOFT, &[("solver.method", 3)], 0.72),
    (SOFT, &[("solver.method", 4)], 0.72),
    (SOFT, &[("pendulum.model", 2)], 0.72),
    (&[], &[("contact.model", 3)], 1.0),
    (PRESSED, &[("contact.model", 3)], 1.0),
    (PRESSED, &[("contact.model", 2), ("contact.dampingLaw", 3)], 1e-3),
];

/// Whether a step has derivatives: not where rigid balls stay in contact.
fn has_derivatives(reals: &[(&str, &[f64])], items: &[(&str, i64)]) -> bool {
    (reals, items) != (PRESSED, &[("contact.model", 3)])
}

/// In Event Mode inputs and tunable parameters act at once, and values of the step remain, with their derivatives, also
/// in a state that is saved then.
#[test]
fn fmi3_step_excludes_what_is_set_in_event_mode() {
    for (reals, items, length) in SCENES {
        let host = stepping(reals, items);
        assert_eq!(host.step(0.0, length).0, fmi3OK, "{:?}", host.log());
        let (before, derivatives) = (values(&host, &OF_STEP), derivatives_of_step(&host));
        assert_eq!(derivatives.is_ok(), has_derivatives(reals, items), "{items:?} {derivatives:?}");
        assert!(before[..5].iter().any(|mean| *mean > 0.0), "{items:?} {before:?}");
        assert_eq!(unsafe { fmi3EnterEventMode(host.c) }, fmi3OK);
        let (accelerations, forces) = (host.floats("a", 5), host.floats("F_ext", 5));
        for (name, values) in [
            ("F_ext", &[50.0, 0.0, 0.0, 0.0, -40.0][..]),
            ("F_ext", &[-50.0, 0.0, 0.0, 0.0, 40.0]),
            ("pendulum.drag", &[3.0]),
            ("contact.damping", &[50.0]),
            ("a_support", &[2.0]),
        ] {
            assert_eq!(host.set(name, values), fmi3OK);
            assert_same(&self::values(&host, &OF_STEP), &before, 1e-13, name);
        }
        assert!(host.floats("a", 5) != accelerations && host.floats("F_ext", 5) != forces);
        let other = stepping(reals, items);
        assert_eq!(other.set_bytes(&host.to_bytes()), fmi3OK, "{:?}", other.log());
        for host in [&host, &other] {
            assert_eq!(values(host, &OF_STEP), values(&other, &OF_STEP));
            if let Ok(before) = &derivatives {
                assert_same(&derivatives_of_step(host).unwrap(), before, 1e-9, "a derivative");
            }
            assert_eq!(host.update().0, fmi3OK);
            assert_same(&values(host, &OF_STEP), &before, 1e-13, "after the event");
            assert_eq!(unsafe { fmi3EnterStepMode(host.c) }, fmi3OK);
            assert_eq!(host.step(length, 1e-3).0, fmi3OK);
        }
        let after = values(&host, &OF_STEP);
        assert_eq!(after, values(&other, &OF_STEP));
        assert_ne!(after[10], before[10]);
    }
}

/// With slopes, the inputs change where the step ends: from then on they are constant.
#[test]
fn fmi3_step_under_a_slope_is_that_without_event_mode() {
    for (reals, items, length) in SCENES {
        let (host, plain) = (stepping(reals, items), Host::new(false, false));
        reals.iter().for_each(|(name, values)| assert_eq!(plain.set(name, values), fmi3OK));
        for (name, item) in items {
            assert_eq!(unsafe { fmi3SetInt64(plain.c, &vr(name), 1, item, 1) }, fmi3OK);
        }
        plain.start();
        for host in [&host, &plain] {
            assert_eq!(host.set("der(F_ext)", &[0.7, 0.0, 0.0, -0.2, 0.0]), fmi3OK);
            assert_eq!(host.step(0.0, length).0, fmi3OK);
        }
        let (before, derivatives) = (values(&plain, &OF_STEP), derivatives_of_step(&host));
        assert_eq!(derivatives.is_ok(), has_derivatives(reals, items), "{items:?} {derivatives:?}");
        assert_eq!(values(&host, &OF_STEP), before);
        assert_eq!(unsafe { fmi3EnterEventMode(host.c) }, fmi3OK);
        assert_same(&values(&host, &OF_STEP), &before, 1e-13, "in Event Mode");
        if let Ok(before) = &derivatives {
            assert_same(&derivatives_of_step(&host).unwrap(), before, 1e-9, "a derivative");
        }
    }
}

/// A step of 0.72 s of soft balls, with another force on the first ball from each onset and release on: when, and
/// values of the step so far.
fn interrupted(items: &[(&str, i64)]) -> (Host, Vec<(f64, Vec<f64>)>) {
    let host = stepping(SOFT, items);
    let seen = Rc::new(RefCell::new(Vec::new()));
    let told = seen.clone();
    host.within(move |c, time, _| {
        let mut of_step = [f64::NAN; 11];
        let references = OF_STEP.map(|(name, _)| vr(name));
        let forces = [0.5 - 2.0 * time, 0.0, 0.1, 0.0, 0.0];
        unsafe {
            assert_eq!(fmi3GetFloat64(c, references.as_ptr(), 3, of_step.as_mut_ptr(), 11), fmi3OK);
            assert_eq!(fmi3SetFloat64(c, &vr("F_ext"), 1, forces.as_ptr(), 5), fmi3OK);
        }
        told.borrow_mut().push((time, of_step.to_vec()));
        false
    });
    assert_eq!(host.step(0.0, 0.72).0, fmi3OK, "{:?}", host.log());
    let seen = seen.take();
    (host, seen)
}

/// Values of a step that inputs cut cover all of it.
#[test]
fn fmi3_step_continues_where_inputs_change_within() {
    for items in [&[][..], &[("solver.method", 3)], &[("pendulum.model", 2)]] {
        let (host, seen) = interrupted(items);
        assert!(seen.len() > 3, "{items:?} {}", seen.len());
        let own = values(&host, &OF_STEP);
        let impulses: Vec<f64> = host.floats("impulse", 5).iter().map(|impulse| impulse / 0.72).collect();
        assert_same(&own[..5], &impulses, 1e-12, "F_mean");
        // What the support got is what the inputs gave and the momentum lost, which the drag is part of.
        let mut given = 0.1 * 0.72;
        for (from, to, force) in seen.iter().zip(seen.iter().skip(1)).map(|((a, _), (b, _))| (*a, *b, 0.5 - 2.0 * a)) {
            given += force * (to - from);
        }
        given += 0.5 * seen[0].0 + (0.5 - 2.0 * seen[seen.len() - 1].0) * (0.72 - seen[seen.len() - 1].0);
        if items != [("pendulum.model", 2)] {
            let expected = (given - host.floats("p_total", 1)[0]) / 0.72;
            let tolerance = if items.is_empty() { 1e-12 } else { 1e-8 };
            assert_same(&own[10..], &[expected], tolerance, "F_support_mean");
        }
        let highest = |k: usize| seen.iter().map(|(_, values)| values[k]).fold(0.0, f64::max);
        assert!((5..9).all(|k| own[k] >= highest(k)) && own[5] > 0.0, "{own:?}");
    }
}

/// A force set within a step is continued with its slope to the end of the step, and has to stay finite until then.
#[test]
fn fmi3_step_keeps_inputs_set_within_finite() {
    let host = stepping(&[("ball.mass", &[1e307])], &[("contact.model", 3)]);
    assert_eq!(host.set("der(F_ext)", &[0.0, 0.0, 0.0, 0.0, 1.79e308]), fmi3OK);
    host.within(|c, _, _| {
        assert_eq!(unsafe { fmi3SetFloat64(c, &vr("F_ext"), 1, [0.0, 0.0, 0.0, 0.0, 1.75e308].as_ptr(), 5) }, fmi3OK);
        false
    });
    let (status, log) = (host.step(0.0, 0.8).0, host.log());
    let why = "fmi3DoStep: the rest of the step = 0.09";
    assert!(status == fmi3Error && log.last().unwrap().starts_with(why), "{status:?} {log:?}");
}
