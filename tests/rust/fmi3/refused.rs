//! Calls of FMI 3.0 in corners: within others, refused, or after the number of balls has changed.

use newtons_cradle::fmi3::fmi3Status::fmi3Discard;
use newtons_cradle::variables::Type;

use super::*;

/// A host that meets an error within a step may clean up at once; the instance is still in the middle of that step.
#[test]
fn fmi3_instance_is_not_freed_within_a_step() {
    let answer = ask(Intermediate, false, |host| {
        let (refused, ..) = host.step(0.0, 1.0);
        unsafe { fmi3FreeInstance(host.c) };
        assert_eq!(host.counts("n", 1), [5], "it is still there");
        refused
    });
    assert_eq!(answer, fmi3Error);
}

#[test]
fn fmi3_refused_number_of_balls_changes_nothing() {
    let host = Host::new(true, true);
    let (n, numbers) = ([vr("n"); 2], [3, 0]);
    unsafe {
        assert_eq!(fmi3EnterConfigurationMode(host.c), fmi3OK);
        assert_eq!(fmi3SetUInt64(host.c, n.as_ptr(), 2, numbers.as_ptr(), 2), fmi3Discard);
        assert_eq!(fmi3ExitConfigurationMode(host.c), fmi3OK);
    }
    assert_eq!(host.enter(), fmi3OK);
    assert_eq!(host.counts("n", 1), [5]);
}

/// Slopes act over a step: at a point nothing depends on them. A weight that is no number, or a change that is none,
/// has no answer.
#[test]
fn fmi3_derivatives_at_a_point() {
    let (a, knowns) = ([vr("a")], ["F_ext", "der(F_ext)", "der(a_support)"].map(vr));
    let initializing = || {
        let host = Host::new(true, true);
        assert_eq!(host.enter(), fmi3OK);
        host
    };
    let (host, mut along, mut by) = (initializing(), [f64::NAN; 5], [f64::NAN; 11]);
    assert_eq!(host.derivatives(false, [&a, &knowns], &[1.0; 11], &mut along), fmi3OK);
    assert_eq!(host.derivatives(true, [&a, &knowns], &[1.0; 5], &mut by), fmi3OK);
    assert_eq!((along, by), ([1.0; 5], [1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
    for weight in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for adjoint in [false, true] {
            let (seed, mut found) = ([1.0, 1.0, weight, 1.0, 1.0], [0.5; 5]);
            let status = initializing().derivatives(adjoint, [&a, &knowns[..1]], &seed, &mut found);
            assert_eq!((status, found), (fmi3Error, [0.5; 5]), "{weight}");
        }
    }
}

/// Before initialization a host reads start values, those of the description or what it has set, and nothing that is
/// calculated.
#[test]
fn fmi3_start_values_can_be_read_before_initialization() {
    let (own, forces) = (Host::new(true, true), [1.0, 2.0, 3.0, 4.0, 5.0]);
    let mut model = 0;
    assert_eq!(own.set("F_ext", &forces), fmi3OK);
    unsafe {
        assert_eq!(fmi3SetInt64(own.c, &vr("contact.model"), 1, &2, 1), fmi3OK);
        assert_eq!(fmi3GetInt64(own.c, &vr("contact.model"), 1, &mut model, 1), fmi3OK);
    }
    assert_eq!((own.floats("F_ext", 5), own.counts("n", 1), model), (forces.to_vec(), vec![5], 2));
    for array in Variable::arrays() {
        let (host, reference) = (Host::new(true, true), array.reference());
        let mut values = [0_u64; 5];
        let (at, length) = (values.as_mut_ptr(), array.len(5));
        let answer = unsafe {
            match array.row.access.data_type() {
                Type::Real => fmi3GetFloat64(host.c, &reference, 1, at.cast(), length),
                Type::Integer => fmi3GetUInt64(host.c, &reference, 1, at, length),
                Type::Enumeration => fmi3GetInt64(host.c, &reference, 1, at.cast(), length),
                Type::Boolean => fmi3GetBoolean(host.c, &reference, 1, at.cast(), length),
                Type::Clock => fmi3GetClock(host.c, &reference, 1, at.cast()),
                Type::Binary => fmi3GetBinary(host.c, &reference, 1, &mut 0, &mut null(), 1),
                Type::String => panic!("no variable is a string"),
            }
        };
        assert_eq!(answer, if array.has_start() { fmi3OK } else { fmi3Error }, "{array}");
    }
}

/// Within a step, hosts may read every variable, beyond the standard, and set those that the standard allows.
#[test]
fn fmi3_everything_can_be_read_within_a_step() {
    let answer = ask(Intermediate, false, |host| {
        let scalars = ["t_next", "E_residual", "F_support_mean", "E_dissipated"].map(|name| (name, 1));
        let arrays = ["F_mean", "F_peak", "overlap", "a"].map(|name| (name, 5));
        for (name, length) in scalars.into_iter().chain(arrays) {
            assert!(host.floats(name, length).iter().all(|value| value.is_finite()), "{name}");
        }
        host.set("pendulum.drag", &[0.1])
    });
    assert_eq!(answer, fmi3Error);
}

/// By FMI 3.0.2 the name has a character that is no white space.
#[test]
fn fmi3_blank_instance_name_is_refused() {
    let token = cradle_host::fmi3::token();
    for (name, created) in [(c" \t\n", false), (c"", false), (c" a", true)] {
        let c = unsafe { fmi3InstantiateModelExchange(name.as_ptr(), token.as_ptr(), null(), 0, 0, null_mut(), None) };
        assert_eq!(!c.is_null(), created, "{name:?}");
        unsafe { fmi3FreeInstance(c) };
    }
}

/// `#` is an escape character in messages, and a message names the refused call that ended the run.
#[test]
fn fmi3_messages_say_what_ended_the_run() {
    let refused = Host::instantiated(c"#1#", None).err().unwrap();
    assert!(refused[0].contains("##1##"), "{refused:?}");
    let host = Host::exchanging();
    assert_eq!(unsafe { fmi3SetContinuousStates(host.c, null(), 0) }, fmi3Error);
    assert_eq!(host.enter(), fmi3Error);
    let lines = host.log();
    assert!(lines[1].contains("fmi3SetContinuousStates ended the run"), "{lines:?}");
}
