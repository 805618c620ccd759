//! Which function may be called in which mode of model exchange (FMI 2.0.4, section 3.2.3), call by call, both ways.

use std::ptr::{null, null_mut};

use cradle_host::{Host, fmi2Error, fmi2OK};
use newtons_cradle::fmi2::*;

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Instantiated,
    Initialization,
    Event,
    Continuous,
    Terminated,
}
use State::{Continuous, Event, Initialization, Instantiated, Terminated};

const STATES: [State; 5] = [Instantiated, Initialization, Event, Continuous, Terminated];

fn host_in(state: State) -> Host {
    let host = Host::exchanging(5);
    if state != Instantiated {
        assert_eq!((host.set_up(0.0), host.enter()), (fmi2OK, fmi2OK));
    }
    if !matches!(state, Instantiated | Initialization) {
        assert_eq!(host.exit(), fmi2OK);
    }
    if matches!(state, Continuous | Terminated) {
        host.update();
    }
    if state == Terminated {
        assert_eq!(host.terminate(), fmi2OK);
    }
    host
}

type Function = (&'static str, &'static [State], fn(&Host) -> fmi2Status);
type Getter = unsafe extern "C" fn(fmi2Component, *mut f64, usize) -> fmi2Status;

const ANY: &[State] = &STATES;
const READ: &[State] = &[Initialization, Event, Continuous, Terminated];
const SET: &[State] = &[Instantiated, Initialization, Event];
const SET_REAL: &[State] = &[Instantiated, Initialization, Event, Continuous];

fn get(host: &Host, getter: Getter, length: usize) -> fmi2Status {
    let mut values = vec![0.0; length];
    unsafe { getter(host.c, values.as_mut_ptr(), length) }
}

fn functions() -> Vec<Function> {
    vec![
        ("fmi2SetDebugLogging", ANY, |h| unsafe { fmi2SetDebugLogging(h.c, 0, 0, null()) }),
        ("fmi2SetupExperiment", &[Instantiated], |h| h.set_up(0.0)),
        ("fmi2EnterInitializationMode", &[Instantiated], Host::enter),
        ("fmi2ExitInitializationMode", &[Initialization], Host::exit),
        ("fmi2Terminate", &[Event, Continuous], Host::terminate),
        ("fmi2Reset", ANY, Host::reset),
        ("fmi2GetReal", READ, |h| unsafe { fmi2GetReal(h.c, &h.vr("x[1]"), 1, &mut 0.0) }),
        ("fmi2GetInteger", READ, |h| unsafe { fmi2GetInteger(h.c, &h.vr("pulses[1]"), 1, &mut 0) }),
        ("fmi2GetBoolean", READ, |h| unsafe { fmi2GetBoolean(h.c, &h.vr("inContact[1]"), 1, &mut 0) }),
        ("fmi2GetString", READ, |h| unsafe { fmi2GetString(h.c, null(), 0, null_mut()) }),
        ("fmi2SetReal", SET_REAL, |h| h.set("F_ext[1]", 0.0)),
        ("fmi2SetInteger", SET, |h| unsafe { fmi2SetInteger(h.c, null(), 0, null()) }),
        ("fmi2SetBoolean", SET, |h| unsafe { fmi2SetBoolean(h.c, null(), 0, null()) }),
        ("fmi2SetString", SET, |h| unsafe { fmi2SetString(h.c, null(), 0, null()) }),
        ("fmi2DeSerializeFMUstate", ANY, |h| h.set_bytes(&h.to_bytes())),
        ("fmi2GetDirectionalDerivative", READ, |h| unsafe {
            fmi2GetDirectionalDerivative(h.c, &h.vr("x[1]"), 1, &h.vr("F_ext[1]"), 1, &1.0, &mut 0.0)
        }),
        ("fmi2EnterEventMode", &[Event, Continuous], |h| unsafe { fmi2EnterEventMode(h.c) }),
        ("fmi2NewDiscreteStates", &[Event], |h| unsafe { fmi2NewDiscreteStates(h.c, &mut fmi2EventInfo::default()) }),
        ("fmi2EnterContinuousTimeMode", &[Event], |h| unsafe { fmi2EnterContinuousTimeMode(h.c) }),
        ("fmi2CompletedIntegratorStep", &[Continuous], |h| unsafe {
            fmi2CompletedIntegratorStep(h.c, 1, &mut 0, &mut 0)
        }),
        ("fmi2SetTime", &[Event, Continuous], |h| unsafe { fmi2SetTime(h.c, 0.0) }),
        ("fmi2SetContinuousStates", &[Continuous], |h| unsafe { fmi2SetContinuousStates(h.c, [0.0; 16].as_ptr(), 16) }),
        ("fmi2GetDerivatives", READ, |h| get(h, fmi2GetDerivatives, 16)),
        ("fmi2GetEventIndicators", READ, |h| get(h, fmi2GetEventIndicators, 8)),
        ("fmi2GetContinuousStates", READ, |h| get(h, fmi2GetContinuousStates, 16)),
        ("fmi2GetNominalsOfContinuousStates", ANY, |h| get(h, fmi2GetNominalsOfContinuousStates, 16)),
        // Those of co-simulation.
        ("fmi2SetRealInputDerivatives", &[], |h| unsafe {
            fmi2SetRealInputDerivatives(h.c, &h.vr("F_ext[1]"), 1, &1, &0.0)
        }),
        ("fmi2GetRealOutputDerivatives", &[], |h| unsafe {
            fmi2GetRealOutputDerivatives(h.c, &h.vr("x[1]"), 1, &1, &mut 0.0)
        }),
        ("fmi2DoStep", &[], |h| h.step(0.0, 0.01)),
        ("fmi2CancelStep", &[], |h| unsafe { fmi2CancelStep(h.c) }),
        ("fmi2GetRealStatus", &[], |h| unsafe { fmi2GetRealStatus(h.c, fmi2LastSuccessfulTime, &mut 0.0) }),
    ]
}

#[test]
fn every_function_is_legal_where_the_standard_says_so_and_nowhere_else() {
    for state in STATES {
        for (name, legal, function) in functions() {
            let host = host_in(state);
            if (name, state) == ("fmi2EnterInitializationMode", Instantiated) {
                assert_eq!(host.set_up(0.0), fmi2OK);
            }
            let before = host.to_bytes();
            let (answer, log) = (function(&host), host.log());
            if legal.contains(&state) {
                assert_eq!((answer, log.as_slice()), (fmi2OK, [].as_slice()), "{name} is legal in {state:?}");
            } else {
                assert_eq!(answer, fmi2Error, "{name} is illegal in {state:?}");
                let text = &log.last().unwrap().text;
                assert!(text.starts_with(&format!("{name}: not allowed in ")), "{text}");
                assert_eq!(host.to_bytes(), before, "{name} was refused and changed the state");
            }
        }
    }
}

#[test]
fn functions_of_model_exchange_are_not_for_co_simulation() {
    let host = Host::started();
    for (name, ..) in functions().iter().filter(|(name, ..)| name.contains("Event") || name.contains("Continuous")) {
        let function = functions().into_iter().find(|(other, ..)| other == name).unwrap().2;
        assert_eq!(function(&host), fmi2Error);
        assert!(host.error().contains("not allowed in co-simulation"), "{name}");
    }
    let (own, other) = (host_in(Continuous), Host::started().to_bytes());
    assert_eq!(own.set_bytes(&other), fmi2Error);
    assert!(own.error().contains("it is one of co-simulation"));
}

#[test]
fn bad_arguments_are_refused_and_change_nothing() {
    let host = host_in(Continuous);
    let before = host.everything();
    let mut y = host.states();
    y[3] = f64::NAN;
    let refusals = unsafe {
        [
            fmi2SetTime(host.c, f64::NAN),
            fmi2SetTime(host.c, -1.0),
            fmi2SetContinuousStates(host.c, y.as_ptr(), 16),
            fmi2SetContinuousStates(host.c, y.as_ptr(), 15),
            fmi2SetContinuousStates(host.c, null(), 16),
            fmi2GetDerivatives(host.c, null_mut(), 16),
            fmi2GetDerivatives(host.c, y.as_mut_ptr(), 0),
            fmi2GetEventIndicators(host.c, y.as_mut_ptr(), 16),
            fmi2GetContinuousStates(host.c, y.as_mut_ptr(), 1),
            fmi2GetNominalsOfContinuousStates(host.c, y.as_mut_ptr(), 17),
            fmi2CompletedIntegratorStep(host.c, 1, null_mut(), &mut 0),
            fmi2CompletedIntegratorStep(host.c, 1, &mut 0, null_mut()),
            host.set("pendulum.drag", 0.1),
            host.set("ball.mass", 2.0),
            host.set("x[1]", 2.0),
        ]
    };
    assert!(refusals.iter().all(|status| *status == fmi2Error), "{refusals:?}");
    assert!(host.log().iter().all(|line| line.text.contains("allowed: ") || line.text.contains("cannot be set")));
    assert_eq!(unsafe { fmi2EnterEventMode(host.c) }, fmi2OK);
    assert_eq!(unsafe { fmi2NewDiscreteStates(host.c, null_mut()) }, fmi2Error);
    assert_eq!(host.everything(), before);
    assert_eq!((host.set("pendulum.drag", 0.1), host.set("F_ext[1]", 1.0)), (fmi2OK, fmi2OK));
    assert!((host.get("a[1]") - 1.0 - 0.5).abs() < 1e-12, "{}", host.get("a[1]"));
}
