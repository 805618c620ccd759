//! Which function may be called in which state (FMI 2.0.4, sections 3.2.3 and 4.2.4), call by call, both ways: a call
//! legal in a state is not rejected there, an illegal one returns fmi2Error, says why and changes nothing.

use std::ptr::{null, null_mut};

use cradle_host::{Host, call, fmi2Error, fmi2OK};
use newtons_cradle::fmi2::*;

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Instantiated,
    Initialization,
    StepComplete,
    Event,
    Continuous,
    Terminated,
    Error,
}
use State::{Continuous, Error, Event, Initialization, Instantiated, StepComplete, Terminated};

/// States of co-simulation, and of model exchange.
const STATES: [&[State]; 2] = [
    &[Instantiated, Initialization, StepComplete, Terminated, Error],
    &[Instantiated, Initialization, Event, Continuous, Terminated],
];

/// A component in this state.
fn host_in(state: State, exchange: bool) -> Host {
    let host = if exchange { Host::exchanging(5) } else { Host::default() };
    if state == Error {
        host.fail();
        return host;
    }
    if state != Instantiated {
        assert_eq!((host.set_up(0.0), host.enter()), (fmi2OK, fmi2OK));
    }
    if !matches!(state, Instantiated | Initialization) {
        assert_eq!(host.exit(), fmi2OK);
    }
    if exchange && matches!(state, Continuous | Terminated) {
        host.update();
    }
    if state == Terminated {
        assert_eq!(host.terminate(), fmi2OK);
    }
    host
}

/// A function, the states in which it is legal, and a call that succeeds there.
type Function = (&'static str, &'static [State], fn(&Host) -> fmi2Status);

const ANY: &[State] = &[Instantiated, Initialization, StepComplete, Event, Continuous, Terminated, Error];
const READ: &[State] = &[Initialization, StepComplete, Event, Continuous, Terminated, Error];
const SET: &[State] = &[Instantiated, Initialization, StepComplete, Event];
const SET_REAL: &[State] = &[Instantiated, Initialization, StepComplete, Event, Continuous];
const RATES: &[State] = &[Instantiated, Initialization, StepComplete];
const STATUS: &[State] = &[StepComplete, Terminated];

/// Calls `function` with a saved state, which is freed afterwards.
fn with_state(host: &Host, function: impl FnOnce(fmi2FMUstate) -> fmi2Status) -> fmi2Status {
    let state = host.save();
    let status = function(state);
    host.free(state);
    status
}

/// Functions of both kinds of components.
const COMMON: &[Function] = &[
    call!(h, ANY, fmi2SetDebugLogging(0, 0, null())),
    ("fmi2SetupExperiment", &[Instantiated], |h| h.set_up(0.0)),
    ("fmi2EnterInitializationMode", &[Instantiated], Host::enter),
    ("fmi2ExitInitializationMode", &[Initialization], Host::exit),
    ("fmi2Terminate", &[StepComplete, Event, Continuous], Host::terminate),
    ("fmi2Reset", ANY, Host::reset),
    call!(h, READ, fmi2GetReal(&h.vr("x[1]"), 1, &mut 0.0)),
    call!(h, READ, fmi2GetInteger(&h.vr("pulses[1]"), 1, &mut 0)),
    call!(h, READ, fmi2GetBoolean(&h.vr("inContact[1]"), 1, &mut 0)),
    call!(h, READ, fmi2GetString(null(), 0, null_mut())),
    ("fmi2SetReal", SET_REAL, |h| h.set("F_ext[1]", 0.0)),
    call!(h, SET, fmi2SetInteger(null(), 0, null())),
    call!(h, SET, fmi2SetBoolean(null(), 0, null())),
    call!(h, SET, fmi2SetString(null(), 0, null())),
    ("fmi2GetFMUstate", ANY, |h| with_state(h, |state| unsafe { fmi2GetFMUstate(h.c, &mut { state }) })),
    ("fmi2SetFMUstate", ANY, |h| with_state(h, |state| h.restore(state))),
    call!(h, ANY, fmi2FreeFMUstate(&mut null_mut())),
    ("fmi2SerializedFMUstateSize", ANY, |h| {
        with_state(h, |state| unsafe { fmi2SerializedFMUstateSize(h.c, state, &mut 0) })
    }),
    ("fmi2SerializeFMUstate", ANY, |h| {
        let mut bytes = h.to_bytes();
        with_state(h, |state| unsafe { fmi2SerializeFMUstate(h.c, state, bytes.as_mut_ptr().cast(), bytes.len()) })
    }),
    ("fmi2DeSerializeFMUstate", ANY, |h| h.set_bytes(&h.to_bytes())),
    call!(h, READ, fmi2GetDirectionalDerivative(&h.vr("x[1]"), 1, &h.vr("F_ext[1]"), 1, &1.0, &mut 0.0)),
    call!(h, &[], fmi2CancelStep()),
];

/// Those of co-simulation, and those of model exchange.
const OWN: [&[Function]; 2] = [
    &[
        ("fmi2SetRealInputDerivatives", RATES, |h| h.set_derivative("F_ext[1]", 1, 0.0)),
        call!(h, &[StepComplete, Terminated, Error], fmi2GetRealOutputDerivatives(&h.vr("x[1]"), 1, &1, &mut 0.0)),
        ("fmi2DoStep", &[StepComplete], |h| h.step(0.0, 0.01)),
        call!(h, STATUS, fmi2GetStatus(fmi2DoStepStatus, &mut fmi2Error.clone())),
        call!(h, STATUS, fmi2GetRealStatus(fmi2LastSuccessfulTime, &mut 0.0)),
        call!(h, STATUS, fmi2GetIntegerStatus(0, &mut 0)),
        call!(h, STATUS, fmi2GetBooleanStatus(fmi2Terminated, &mut 0)),
        call!(h, STATUS, fmi2GetStringStatus(fmi2PendingStatus, &mut null())),
    ],
    &[
        call!(h, &[Event, Continuous], fmi2EnterEventMode()),
        call!(h, &[Event], fmi2NewDiscreteStates(&mut fmi2EventInfo::default())),
        call!(h, &[Event], fmi2EnterContinuousTimeMode()),
        call!(h, &[Continuous], fmi2CompletedIntegratorStep(1, &mut 0, &mut 0)),
        call!(h, &[Event, Continuous], fmi2SetTime(0.0)),
        call!(h, &[Continuous], fmi2SetContinuousStates([0.0; 16].as_ptr(), 16)),
        call!(h, READ, fmi2GetDerivatives([0.0; 16].as_mut_ptr(), 16)),
        call!(h, READ, fmi2GetEventIndicators([0.0; 8].as_mut_ptr(), 8)),
        call!(h, READ, fmi2GetContinuousStates([0.0; 16].as_mut_ptr(), 16)),
        call!(h, ANY, fmi2GetNominalsOfContinuousStates([0.0; 16].as_mut_ptr(), 16)),
    ],
];

#[test]
fn calls_are_legal_exactly_where_fmi_2_says_so() {
    assert_eq!(COMMON.len() + OWN[0].len() + OWN[1].len(), 40);
    for (exchange, states) in [false, true].into_iter().zip(STATES) {
        let own = OWN[usize::from(exchange)].iter().map(|function| (*function, true));
        let others = OWN[usize::from(!exchange)].iter().map(|function| (*function, false));
        for ((name, legal, function), has) in COMMON.iter().map(|function| (*function, true)).chain(own).chain(others) {
            for state in states {
                let host = host_in(*state, exchange);
                if (name, *state) == ("fmi2EnterInitializationMode", Instantiated) {
                    assert_eq!(host.set_up(0.0), fmi2OK); // What it is illegal without.
                }
                let before = host.to_bytes();
                let (answer, log) = (function(&host), host.log());
                if has && legal.contains(state) && name == "fmi2GetIntegerStatus" {
                    assert_eq!(answer, fmi2Error, "no status is an integer");
                    assert!(!log[0].text.contains("not allowed"), "{}", log[0].text);
                } else if has && legal.contains(state) {
                    assert_eq!((answer, log.as_slice()), (fmi2OK, [].as_slice()), "{name} is legal in {state:?}");
                } else {
                    assert_eq!(answer, fmi2Error, "{name} is illegal in {state:?}");
                    let text = &log.last().unwrap().text;
                    assert!(text.starts_with(&format!("{name}: not allowed in ")), "{text}");
                    assert!(host.to_bytes() == before, "{name} was refused and changed the state");
                }
            }
        }
    }
}

#[test]
fn calls_of_reset_lead_back_from_every_state() {
    for state in STATES[0] {
        let host = host_in(*state, false);
        host.assert_usable();
        assert_eq!((host.get("gravity"), host.get("F_ext[1]")), (9.81, 0.0), "{state:?}");
    }
    unsafe { fmi2FreeInstance(null_mut()) };
}

#[test]
fn calls_of_setters_are_legal_by_state_and_variable() {
    const TUNABLE: [&str; 7] = [
        "pendulum.drag",
        "contact.damping",
        "contact.huntCrossley",
        "contact.relaxationTime",
        "contact.restitution",
        "contact.lossRatio[1]",
        "a_support",
    ];
    for state in STATES[0] {
        let host = host_in(*state, false);
        let before = matches!(state, Instantiated | Initialization);
        let of = |expected: bool| move |name: &'static str| (name, expected);
        let fixed = ["ball.mass", "x_start[1]"].map(of(before)).into_iter();
        let calculated = ["x[1]", "overlap[1]", "pendulum.period"].map(of(false));
        for (name, expected) in fixed.chain(TUNABLE.map(of(before || *state == StepComplete))).chain(calculated) {
            assert_eq!(host.set(name, 0.5) == fmi2OK, expected, "{name} in {state:?}");
        }
        assert_eq!(host.set("contact.dampingLaw", 2.0) == fmi2OK, before);
    }
}

#[test]
fn calls_with_bad_arguments_in_model_exchange_change_nothing() {
    let host = host_in(Continuous, true);
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
    host.give("pendulum.drag=0.1 F_ext[1]=1");
    assert!((host.get("a[1]") - 1.0 - 0.5).abs() < 1e-12, "{}", host.get("a[1]"));
}

#[test]
fn saved_states_belong_to_instances_of_their_kind() {
    let hosts = [Host::default(), Host::exchanging(5)];
    for (kind, name) in ["co-simulation", "model exchange"].into_iter().enumerate() {
        for state in STATES[kind] {
            let bytes = host_in(*state, kind == 1).to_bytes();
            assert_eq!(hosts[kind].set_bytes(&bytes), fmi2OK, "{state:?}");
            assert!(hosts[kind].to_bytes() == bytes, "{state:?}");
            let other = &hosts[1 - kind];
            other.refused(other.set_bytes(&bytes), &format!("it is one of {name}"));
        }
    }
}

#[test]
fn calls_of_types_and_version_answer_as_in_the_standard() {
    unsafe {
        assert_eq!(std::ffi::CStr::from_ptr(fmi2GetTypesPlatform()), c"default");
        assert_eq!(std::ffi::CStr::from_ptr(fmi2GetVersion()), c"2.0");
    }
}

/// Hosts that do not ask whether a call was refused come to an end all the same.
#[test]
fn calls_refused_are_answered_with_values_that_end_a_run() {
    let host = Host::default();
    for c in [host.c, null_mut()] {
        let (mut enter, mut terminate, mut ended, mut status) = (1, 0, 0, fmi2OK);
        let mut info = fmi2EventInfo {
            newDiscreteStatesNeeded: 1,
            terminateSimulation: 0,
            nominalsOfContinuousStatesChanged: 1,
            valuesOfContinuousStatesChanged: 1,
            nextEventTimeDefined: 1,
            nextEventTime: f64::NAN,
        };
        unsafe {
            assert_eq!(fmi2NewDiscreteStates(c, &mut info), fmi2Error);
            assert_eq!(fmi2CompletedIntegratorStep(c, 1, &mut enter, &mut terminate), fmi2Error);
            assert_eq!(fmi2GetStatus(c, fmi2DoStepStatus, &mut status), fmi2Error);
            assert_eq!(fmi2GetBooleanStatus(c, fmi2Terminated, &mut ended), fmi2Error);
        }
        let flags = [info.nominalsOfContinuousStatesChanged, info.valuesOfContinuousStatesChanged];
        assert_eq!((info.newDiscreteStatesNeeded, info.terminateSimulation, flags), (0, 1, [0; 2]));
        assert_eq!((info.nextEventTimeDefined, info.nextEventTime), (0, 0.0));
        assert_eq!((enter, terminate, ended, status), (0, 1, 1, fmi2Error));
    }
}
