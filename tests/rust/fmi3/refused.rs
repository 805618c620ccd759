//! Calls of FMI 3.0 in corners: within others, refused, or after the number of balls has changed.

use newtons_cradle::fmi3::fmi3Status::fmi3Discard;

use newtons_cradle::variables::Type;

use super::*;

/// A host that meets an error within a step may clean up at once; the instance is still in the middle of that step.
#[test]
fn an_instance_is_not_freed_in_the_middle_of_a_step() {
    let answer = Host::ask(Intermediate, |c| {
        let refused = do_step(c);
        unsafe { fmi3FreeInstance(c) };
        assert_eq!(unsafe { fmi3GetUInt64(c, &vr("n"), 1, &mut 0, 1) }, fmi3OK, "it is still there");
        refused
    });
    assert_eq!(answer, fmi3Error);
}

#[test]
fn a_refused_number_of_balls_changes_nothing() {
    let host = Host::new();
    let (n, numbers) = ([vr("n"); 2], [3, 0]);
    let mut balls = 0;
    unsafe {
        assert_eq!(fmi3EnterConfigurationMode(host.c), fmi3OK);
        assert_eq!(fmi3SetUInt64(host.c, n.as_ptr(), 2, numbers.as_ptr(), 2), fmi3Discard);
        assert_eq!(fmi3ExitConfigurationMode(host.c), fmi3OK);
        assert_eq!(fmi3EnterInitializationMode(host.c, 0, 0.0, 0.0, 0, 0.0), fmi3OK);
        assert_eq!(fmi3GetUInt64(host.c, n.as_ptr(), 1, &mut balls, 1), fmi3OK);
    }
    assert_eq!(balls, 5);
}

/// Slopes act over a step: at a point nothing depends on them.
#[test]
fn nothing_depends_on_slopes_at_a_point() {
    let host = Host::new();
    let knowns = [vr("F_ext"), vr("der(F_ext)"), vr("der(a_support)")];
    let (seed, mut along) = ([1.0; 11], [f64::NAN; 5]);
    let mut back = [f64::NAN; 11];
    unsafe {
        assert_eq!(fmi3EnterInitializationMode(host.c, 0, 0.0, 0.0, 0, 0.0), fmi3OK);
        let found = fmi3GetDirectionalDerivative(
            host.c,
            &vr("a"),
            1,
            knowns.as_ptr(),
            3,
            seed.as_ptr(),
            11,
            along.as_mut_ptr(),
            5,
        );
        assert_eq!(found, fmi3OK);
        let found =
            fmi3GetAdjointDerivative(host.c, &vr("a"), 1, knowns.as_ptr(), 3, seed.as_ptr(), 5, back.as_mut_ptr(), 11);
        assert_eq!(found, fmi3OK);
    }
    assert_eq!(along, [1.0; 5]);
    assert_eq!(back, [1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
}

/// A weight that is no number, or a change that is none, has no answer.
#[test]
fn seeds_are_finite() {
    for weight in [1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for call in [fmi3GetAdjointDerivative, fmi3GetDirectionalDerivative] {
            let (host, seed, mut found) = (Host::new(), [1.0, 1.0, weight, 1.0, 1.0], [0.5; 5]);
            let answer = unsafe {
                assert_eq!(fmi3EnterInitializationMode(host.c, 0, 0.0, 0.0, 0, 0.0), fmi3OK);
                call(host.c, &vr("a"), 1, &vr("F_ext"), 1, seed.as_ptr(), 5, found.as_mut_ptr(), 5)
            };
            let expected = if weight == 1.0 { (fmi3OK, [1.0; 5]) } else { (fmi3Error, [0.5; 5]) };
            assert_eq!((answer, found), expected, "{weight}");
        }
    }
}

/// Before initialization a host reads start values, those of the description or what it has set, and nothing that is
/// calculated.
#[test]
fn start_values_are_there_before_initialization() {
    let host = Host::new();
    let (mut forces, mut balls, mut model) = ([f64::NAN; 5], 0, 0);
    unsafe {
        assert_eq!(fmi3SetFloat64(host.c, &vr("F_ext"), 1, [1.0, 2.0, 3.0, 4.0, 5.0].as_ptr(), 5), fmi3OK);
        assert_eq!(fmi3SetInt64(host.c, &vr("contact.model"), 1, &2, 1), fmi3OK);
        assert_eq!(fmi3GetFloat64(host.c, &vr("F_ext"), 1, forces.as_mut_ptr(), 5), fmi3OK);
        assert_eq!(fmi3GetUInt64(host.c, &vr("n"), 1, &mut balls, 1), fmi3OK);
        assert_eq!(fmi3GetInt64(host.c, &vr("contact.model"), 1, &mut model, 1), fmi3OK);
    }
    assert_eq!((forces, balls, model), ([1.0, 2.0, 3.0, 4.0, 5.0], 5, 2));
    for array in Array::all() {
        let host = Host::new();
        let (mut values, reference) = ([0_u64; 5], array.reference());
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

/// Hosts that record intermediate values read everything: beyond the standard, they get it. They set what the standard
/// allows.
#[test]
fn everything_can_be_read_in_the_middle_of_a_step() {
    let answer = Host::ask(Intermediate, |c| {
        let (mut value, mut values) = (f64::NAN, [f64::NAN; 5]);
        for name in ["t_next", "E_residual", "F_support_mean", "E_dissipated"] {
            assert_eq!(unsafe { fmi3GetFloat64(c, &vr(name), 1, &mut value, 1) }, fmi3OK, "{name}");
            assert!(value.is_finite(), "{name}");
        }
        for name in ["F_mean", "F_peak", "overlap", "a"] {
            assert_eq!(unsafe { fmi3GetFloat64(c, &vr(name), 1, values.as_mut_ptr(), 5) }, fmi3OK, "{name}");
            assert!(values.iter().all(|value| value.is_finite()), "{name}");
        }
        unsafe { fmi3SetFloat64(c, &vr("pendulum.drag"), 1, &0.1, 1) }
    });
    assert_eq!(answer, fmi3Error);
}

/// By FMI 3.0.2 the name has a character that is no white space.
#[test]
fn a_blank_name_is_refused() {
    let token = CString::new(Description::fmi3(&Settings::default_for(5)).guid()).unwrap();
    for (name, created) in [(c" \t\n", false), (c"", false), (c" a", true)] {
        let c = unsafe { fmi3InstantiateModelExchange(name.as_ptr(), token.as_ptr(), null(), 0, 0, null_mut(), None) };
        assert_eq!(!c.is_null(), created, "{name:?}");
        unsafe { fmi3FreeInstance(c) };
    }
}

thread_local! {
    static LINES: std::cell::RefCell<Vec<String>> = const { std::cell::RefCell::new(Vec::new()) };
}

unsafe extern "C" fn keep(_: *mut c_void, _: fmi3Status, _: *const std::ffi::c_char, line: *const std::ffi::c_char) {
    let line = unsafe { std::ffi::CStr::from_ptr(line) }.to_string_lossy().into_owned();
    LINES.with(|lines| lines.borrow_mut().push(line));
}

/// `#` is an escape character in messages, and a message names the refused call that ended the run.
#[test]
fn messages_say_what_ended_the_run() {
    let name = c"a";
    let made = |token: &CString| unsafe {
        fmi3InstantiateModelExchange(name.as_ptr(), token.as_ptr(), null(), 0, 1, null_mut(), Some(keep))
    };
    assert!(made(&c"#1#".to_owned()).is_null());
    let c = made(&CString::new(Description::fmi3(&Settings::default_for(5)).guid()).unwrap());
    unsafe {
        assert_eq!(fmi3SetContinuousStates(c, null(), 0), fmi3Error);
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), fmi3Error);
        fmi3FreeInstance(c);
    }
    let lines = LINES.take();
    assert!(lines[0].contains("##1##") && lines[2].contains("fmi3SetContinuousStates ended the run"), "{lines:?}");
}
