//! Which function may be called in which state (FMI 2.0.4, section 4.2.4), call by call, both ways: a legal call is not
//! turned down for its time, an illegal one answers fmi2Error and leaves the state as it was.

use std::ptr::{null, null_mut};

use cradle_host::{Host, fmi2Error, fmi2OK};
use newtons_cradle::fmi2::*;

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Instantiated,
    Initialization,
    StepComplete,
    Terminated,
    Error,
}
use State::{Error, Initialization, Instantiated, StepComplete, Terminated};

const STATES: [State; 5] = [Instantiated, Initialization, StepComplete, Terminated, Error];

/// A component in this state.
fn host_in(state: State) -> Host {
    let host = Host::new();
    if state == Error {
        host.fail();
        return host;
    }
    if state != Instantiated {
        assert_eq!(host.set_up(0.0), fmi2OK);
        assert_eq!(host.enter(), fmi2OK);
    }
    if !matches!(state, Instantiated | Initialization) {
        assert_eq!(host.exit(), fmi2OK);
    }
    if state == Terminated {
        assert_eq!(host.terminate(), fmi2OK);
    }
    host
}

type Function = (&'static str, &'static [State], fn(&Host) -> fmi2Status);

const ANY: &[State] = &STATES;
const READ: &[State] = &[Initialization, StepComplete, Terminated, Error];
const SET: &[State] = &[Instantiated, Initialization, StepComplete];
const DERIVATIVES: &[State] = &[StepComplete, Terminated, Error];
const STATUS: &[State] = &[StepComplete, Terminated];

/// Calls `function` with a saved state, which is freed afterwards.
fn with_state(host: &Host, function: impl FnOnce(fmi2FMUstate) -> fmi2Status) -> fmi2Status {
    let state = host.save();
    let status = function(state);
    host.free(state);
    status
}

/// Every function with a component, the states it is legal in, and a call that is fine in those.
fn functions() -> Vec<Function> {
    vec![
        ("fmi2SetDebugLogging", ANY, |h| unsafe { fmi2SetDebugLogging(h.c, 0, 0, null()) }),
        ("fmi2SetupExperiment", &[Instantiated], |h| h.set_up(0.0)),
        ("fmi2EnterInitializationMode", &[Instantiated], Host::enter),
        ("fmi2ExitInitializationMode", &[Initialization], Host::exit),
        ("fmi2Terminate", &[StepComplete], Host::terminate),
        ("fmi2Reset", ANY, Host::reset),
        ("fmi2GetReal", READ, |h| unsafe { fmi2GetReal(h.c, &h.vr("x[1]"), 1, &mut 0.0) }),
        ("fmi2GetInteger", READ, |h| unsafe { fmi2GetInteger(h.c, &h.vr("pulses[1]"), 1, &mut 0) }),
        ("fmi2GetBoolean", READ, |h| unsafe { fmi2GetBoolean(h.c, &h.vr("inContact[1]"), 1, &mut 0) }),
        ("fmi2GetString", READ, |h| unsafe { fmi2GetString(h.c, null(), 0, null_mut()) }),
        ("fmi2SetReal", SET, |h| h.set("F_ext[1]", 0.0)),
        ("fmi2SetInteger", SET, |h| unsafe { fmi2SetInteger(h.c, null(), 0, null()) }),
        ("fmi2SetBoolean", SET, |h| unsafe { fmi2SetBoolean(h.c, null(), 0, null()) }),
        ("fmi2SetString", SET, |h| unsafe { fmi2SetString(h.c, null(), 0, null()) }),
        ("fmi2GetFMUstate", ANY, |h| with_state(h, |state| unsafe { fmi2GetFMUstate(h.c, &mut { state }) })),
        ("fmi2SetFMUstate", ANY, |h| with_state(h, |state| h.restore(state))),
        ("fmi2FreeFMUstate", ANY, |h| unsafe { fmi2FreeFMUstate(h.c, &mut null_mut()) }),
        ("fmi2SerializedFMUstateSize", ANY, |h| {
            with_state(h, |state| unsafe { fmi2SerializedFMUstateSize(h.c, state, &mut 0) })
        }),
        ("fmi2SerializeFMUstate", ANY, |h| {
            let mut bytes = h.to_bytes();
            with_state(h, |state| unsafe { fmi2SerializeFMUstate(h.c, state, bytes.as_mut_ptr().cast(), bytes.len()) })
        }),
        ("fmi2DeSerializeFMUstate", ANY, |h| h.set_bytes(&h.to_bytes())),
        ("fmi2GetDirectionalDerivative", READ, |h| unsafe {
            fmi2GetDirectionalDerivative(h.c, &h.vr("x[1]"), 1, &h.vr("F_ext[1]"), 1, &1.0, &mut 0.0)
        }),
        ("fmi2SetRealInputDerivatives", SET, |h| unsafe {
            fmi2SetRealInputDerivatives(h.c, &h.vr("F_ext[1]"), 1, &1, &0.0)
        }),
        ("fmi2GetRealOutputDerivatives", DERIVATIVES, |h| unsafe {
            fmi2GetRealOutputDerivatives(h.c, &h.vr("x[1]"), 1, &1, &mut 0.0)
        }),
        ("fmi2DoStep", &[StepComplete], |h| h.step(0.0, 0.01)),
        ("fmi2CancelStep", &[], |h| unsafe { fmi2CancelStep(h.c) }),
        ("fmi2GetStatus", STATUS, |h| unsafe { fmi2GetStatus(h.c, fmi2DoStepStatus, &mut fmi2Error.clone()) }),
        ("fmi2GetRealStatus", STATUS, |h| unsafe { fmi2GetRealStatus(h.c, fmi2LastSuccessfulTime, &mut 0.0) }),
        ("fmi2GetIntegerStatus", STATUS, |h| unsafe { fmi2GetIntegerStatus(h.c, 0, &mut 0) }),
        ("fmi2GetBooleanStatus", STATUS, |h| unsafe { fmi2GetBooleanStatus(h.c, fmi2Terminated, &mut 0) }),
        ("fmi2GetStringStatus", STATUS, |h| unsafe { fmi2GetStringStatus(h.c, fmi2PendingStatus, &mut null()) }),
    ]
}

/// The state, told by what is legal in it and changes nothing.
fn state_of(host: &Host) -> State {
    let reads = unsafe { fmi2GetReal(host.c, null(), 0, null_mut()) } == fmi2OK;
    let sets = unsafe { fmi2SetReal(host.c, null(), 0, null()) } == fmi2OK;
    let answers = unsafe { fmi2GetRealStatus(host.c, fmi2LastSuccessfulTime, &mut 0.0) } == fmi2OK;
    host.log();
    match (reads, sets, answers) {
        (false, true, false) => Instantiated,
        (true, true, false) => Initialization,
        (true, true, true) => StepComplete,
        (true, false, true) => Terminated,
        (true, false, false) => Error,
        other => panic!("no state answers like this: {other:?}"),
    }
}

#[test]
fn every_function_is_legal_where_the_standard_says_so_and_nowhere_else() {
    assert_eq!(functions().len(), 30);
    for state in STATES {
        for (name, legal, function) in functions() {
            let host = host_in(state);
            assert_eq!(state_of(&host), state);
            if (name, state) == ("fmi2EnterInitializationMode", Instantiated) {
                assert_eq!(host.set_up(0.0), fmi2OK); // What it is illegal without.
            }
            let answer = function(&host);
            let log = host.log();
            if !legal.contains(&state) {
                assert_eq!(answer, fmi2Error, "{name} is illegal in {state:?}");
                let text = &log.last().unwrap().text;
                assert!(text.starts_with(&format!("{name}: not allowed in ")), "{text}");
                assert_eq!(state_of(&host), state, "{name} was refused and changed the state");
            } else if name == "fmi2GetIntegerStatus" {
                assert_eq!(answer, fmi2Error, "no status is an integer");
                assert!(!log[0].text.contains("not allowed"), "{}", log[0].text);
                assert_eq!(state_of(&host), state, "{name} was refused and changed the state");
            } else {
                assert_eq!((answer, log.as_slice()), (fmi2OK, [].as_slice()), "{name} is legal in {state:?}");
                let after = match name {
                    "fmi2EnterInitializationMode" => Initialization,
                    "fmi2ExitInitializationMode" => StepComplete,
                    "fmi2Terminate" => Terminated,
                    "fmi2Reset" => Instantiated,
                    _ => state,
                };
                assert_eq!(state_of(&host), after, "{name} in {state:?}");
            }
        }
    }
}

#[test]
fn a_component_can_be_freed_in_every_state() {
    for state in STATES {
        drop(host_in(state));
    }
    unsafe { fmi2FreeInstance(null_mut()) };
}

#[test]
fn every_state_leads_back_by_a_reset() {
    for state in STATES {
        let host = host_in(state);
        host.assert_usable();
        assert_eq!((host.get("gravity"), host.get("F_ext[1]")), (9.81, 0.0), "{state:?}");
    }
}

#[test]
fn what_may_be_set_depends_on_the_state() {
    let settable = |host: &Host, name: &str| {
        let set = host.set(name, 0.5) == fmi2OK;
        host.log();
        set
    };
    for state in STATES {
        let host = host_in(state);
        let before = matches!(state, Instantiated | Initialization);
        let between = before || state == StepComplete;
        for (name, expected) in [
            ("ball.mass", before),
            ("x_start[1]", before),
            ("solver.tolerance", false), // 0.5 is out of range.
            ("pendulum.drag", between),
            ("contact.damping", between),
            ("contact.huntCrossley", between),
            ("contact.relaxationTime", between),
            ("F_ext[5]", between),
            ("a_support", between),
            ("x[1]", false),
            ("overlap[1]", false),
            ("pendulum.period", false),
        ] {
            assert_eq!(settable(&host, name), expected, "{name} in {state:?}");
        }
        assert_eq!(host.set_integer("contact.dampingLaw", 2) == fmi2OK, before);
    }
}

#[test]
fn types_and_version_are_those_of_the_standard() {
    unsafe {
        assert_eq!(std::ffi::CStr::from_ptr(fmi2GetTypesPlatform()), c"default");
        assert_eq!(std::ffi::CStr::from_ptr(fmi2GetVersion()), c"2.0");
    }
}
