//! FMI 3.0: which function may be called in which state (FMI 3.0.2, sections 2.3, 3.2 and 4.2), call by call, both
//! ways, and the description as another reader understands it. A call legal in a state is not rejected there; an
//! illegal one returns fmi3Error and ends the run.

mod exchange;
mod refused;
mod scalars;
mod steps;

use std::cell::Cell;
use std::collections::BTreeSet;
use std::ptr::{null, null_mut};
use std::rc::Rc;

use cradle_host::call;
use cradle_host::fmi3::{Host, vr};
use fmi_schema::fmi3::Fmi3ModelDescription;
use fmi_schema::traits::FmiModelDescription;
use newtons_cradle::fmi3::fmi3Status::{fmi3Error, fmi3OK};
use newtons_cradle::fmi3::*;
use newtons_cradle::model::ContactModel;
use newtons_cradle::variables::{Causality, Description, Settings, Shape, Variable};

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Instantiated,
    Configuration,
    Initialization,
    Event,
    Step,
    /// Within a step, where the host has been called.
    Intermediate,
    Continuous,
    Terminated,
    /// After a refused call, before initialization.
    Abandoned,
}
use State::{
    Abandoned, Configuration, Continuous, Event, Initialization, Instantiated, Intermediate, Step, Terminated,
};

/// States of co-simulation, and of model exchange.
const STATES: [&[State]; 2] = [
    &[Instantiated, Configuration, Initialization, Event, Step, Intermediate, Terminated, Abandoned],
    &[Instantiated, Configuration, Initialization, Event, Continuous, Terminated, Abandoned],
];

/// A call.
type Asked = fn(&Host) -> fmi3Status;

/// The status of `function` in this state.
fn ask(state: State, exchange: bool, function: Asked) -> fmi3Status {
    let host = if exchange { Host::exchanging() } else { Host::new(true, true) };
    let c = host.c;
    let ok = |status| assert_eq!(status, fmi3OK, "{state:?}");
    unsafe {
        match state {
            Instantiated => {}
            Configuration => ok(fmi3EnterConfigurationMode(c)),
            Initialization => ok(host.enter()),
            Abandoned => assert_eq!(fmi3EnterStepMode(c), fmi3Error),
            Event | Step | Intermediate | Continuous | Terminated => host.start(),
        }
        match state {
            Step | Intermediate => ok(fmi3EnterStepMode(c)),
            Continuous => ok(fmi3EnterContinuousTimeMode(c)),
            Terminated => ok(fmi3Terminate(c)),
            _ => {}
        }
    }
    if state != Intermediate {
        return function(&host);
    }
    let (host, answer) = (Rc::new(host), Rc::new(Cell::new(None)));
    let (own, given) = (Rc::downgrade(&host), answer.clone());
    host.within(move |_, _, _| {
        if given.get().is_none() {
            given.set(Some(function(&own.upgrade().unwrap())));
        }
        false
    });
    host.step(0.0, 1.0);
    answer.get().unwrap()
}

fn with_state(c: fmi3Instance, function: impl FnOnce(fmi3FMUState) -> fmi3Status) -> fmi3Status {
    let mut state = null_mut();
    let saved = unsafe { fmi3GetFMUState(c, &mut state) };
    if saved != fmi3OK {
        return saved;
    }
    let status = function(state);
    unsafe { fmi3FreeFMUState(c, &mut state) };
    status
}

fn derivatives(host: &Host, adjoint: bool) -> fmi3Status {
    host.derivatives(adjoint, [&[vr("x")], &[vr("F_ext")]], &[0.0; 5], &mut [0.0; 5])
}

/// A function, the states in which it is legal, and a call that succeeds there.
type Function = (&'static str, &'static [State], Asked);

const ANY: &[State] = &[Instantiated, Configuration, Initialization, Event, Step, Continuous, Terminated, Abandoned];
const LOGGED: &[State] =
    &[Instantiated, Configuration, Initialization, Event, Step, Intermediate, Continuous, Terminated, Abandoned];
const READ: &[State] = &[Initialization, Event, Step, Intermediate, Continuous, Terminated];
/// Start values can be read before initialization, calculated values cannot.
const START: &[State] = &[Instantiated, Initialization, Event, Step, Intermediate, Continuous, Terminated];
/// There are no clocks with intervals: a call for none of them does nothing.
const INTERVALS: &[State] = &[Initialization, Event];
const SET: &[State] = &[Instantiated, Initialization, Event, Step, Intermediate, Continuous];
/// In model exchange discrete variables change in events only.
const SET_DISCRETE: &[State] = &[Instantiated, Initialization, Event, Step];
const SENSITIVE: &[State] = &[Initialization, Event, Step, Continuous, Terminated];
const CONTINUOUS: &[State] = &[Initialization, Event, Continuous, Terminated];
const NOMINALS: &[State] = &[Instantiated, Initialization, Event, Continuous, Terminated];

/// Functions of both kinds of instances.
const COMMON: [Function; 55] = [
    call!(h, LOGGED, fmi3SetDebugLogging(0, 0, null())),
    ("fmi3EnterInitializationMode", &[Instantiated], Host::enter),
    call!(h, &[Initialization], fmi3ExitInitializationMode()),
    call!(h, &[Step, Continuous], fmi3EnterEventMode()),
    call!(h, &[Event, Step, Continuous], fmi3Terminate()),
    call!(h, ANY, fmi3Reset()),
    call!(h, READ, fmi3GetFloat64(&vr("E_total"), 1, &mut 0.0, 1)),
    call!(h, READ, fmi3GetUInt64(&vr("pulses"), 1, [0; 5].as_mut_ptr(), 5)),
    call!(h, START, fmi3GetInt64(&vr("contact.model"), 1, &mut 0, 1)),
    call!(h, READ, fmi3GetBoolean(&vr("inContact"), 1, [0; 5].as_mut_ptr(), 5)),
    call!(h, READ, fmi3GetClock(&vr("onset.clock"), 1, &mut 0)),
    call!(h, START, fmi3GetBinary(null(), 0, null_mut(), null_mut(), 0)),
    ("fmi3SetFloat64", SET, |h| h.set("F_ext", &[0.0; 5])),
    call!(h, &[Configuration], fmi3SetUInt64(&vr("n"), 1, &7, 1)),
    call!(h, SET_DISCRETE, fmi3SetInt64(null(), 0, null(), 0)),
    call!(h, SET_DISCRETE, fmi3SetBoolean(null(), 0, null(), 0)),
    call!(h, SET_DISCRETE, fmi3SetClock(null(), 0, null())),
    call!(h, SET_DISCRETE, fmi3SetBinary(null(), 0, null(), null(), 0)),
    ("fmi3GetFMUState", ANY, |h| with_state(h.c, |_| fmi3OK)),
    ("fmi3SetFMUState", ANY, |h| with_state(h.c, |state| unsafe { fmi3SetFMUState(h.c, state) })),
    call!(h, ANY, fmi3FreeFMUState(&mut null_mut())),
    ("fmi3SerializedFMUStateSize", ANY, |h| {
        with_state(h.c, |state| unsafe { fmi3SerializedFMUStateSize(h.c, state, &mut 0) })
    }),
    ("fmi3DeserializeFMUState", ANY, |h| with_state(h.c, |_| h.set_bytes(&h.to_bytes()))),
    ("fmi3GetDirectionalDerivative", SENSITIVE, |h| derivatives(h, false)),
    ("fmi3GetAdjointDerivative", SENSITIVE, |h| derivatives(h, true)),
    call!(h, &[Instantiated], fmi3EnterConfigurationMode()),
    call!(h, &[Configuration], fmi3ExitConfigurationMode()),
    ("fmi3UpdateDiscreteStates", &[Event], |h| h.update().0),
    call!(h, &[Event], fmi3EvaluateDiscreteStates()),
    call!(h, INTERVALS, fmi3GetIntervalDecimal(null(), 0, null_mut(), null_mut())),
    call!(h, INTERVALS, fmi3GetIntervalFraction(null(), 0, null_mut(), null_mut(), null_mut())),
    call!(h, INTERVALS, fmi3GetShiftDecimal(null(), 0, null_mut())),
    call!(h, INTERVALS, fmi3GetShiftFraction(null(), 0, null_mut(), null_mut())),
    call!(h, INTERVALS, fmi3SetIntervalDecimal(null(), 0, null())),
    call!(h, INTERVALS, fmi3SetIntervalFraction(null(), 0, null(), null())),
    call!(h, INTERVALS, fmi3SetShiftDecimal(null(), 0, null())),
    call!(h, INTERVALS, fmi3SetShiftFraction(null(), 0, null(), null())),
    // Of types that no variable has.
    call!(h, START, fmi3GetFloat32(null(), 0, null_mut(), 0)),
    call!(h, SET_DISCRETE, fmi3SetFloat32(null(), 0, null(), 0)),
    call!(h, START, fmi3GetInt8(null(), 0, null_mut(), 0)),
    call!(h, SET_DISCRETE, fmi3SetInt8(null(), 0, null(), 0)),
    call!(h, START, fmi3GetUInt8(null(), 0, null_mut(), 0)),
    call!(h, SET_DISCRETE, fmi3SetUInt8(null(), 0, null(), 0)),
    call!(h, START, fmi3GetInt16(null(), 0, null_mut(), 0)),
    call!(h, SET_DISCRETE, fmi3SetInt16(null(), 0, null(), 0)),
    call!(h, START, fmi3GetUInt16(null(), 0, null_mut(), 0)),
    call!(h, SET_DISCRETE, fmi3SetUInt16(null(), 0, null(), 0)),
    call!(h, START, fmi3GetInt32(null(), 0, null_mut(), 0)),
    call!(h, SET_DISCRETE, fmi3SetInt32(null(), 0, null(), 0)),
    call!(h, START, fmi3GetUInt32(null(), 0, null_mut(), 0)),
    call!(h, SET_DISCRETE, fmi3SetUInt32(null(), 0, null(), 0)),
    call!(h, START, fmi3GetString(null(), 0, null_mut(), 0)),
    call!(h, SET_DISCRETE, fmi3SetString(null(), 0, null(), 0)),
    // Not offered.
    call!(h, &[], fmi3GetNumberOfVariableDependencies(0, &mut 0)),
    call!(h, &[], fmi3GetVariableDependencies(0, null_mut(), null_mut(), null_mut(), null_mut(), 0)),
];

/// Those of co-simulation, and those of model exchange.
const OWN: [&[Function]; 2] = [
    &[
        call!(h, &[Event], fmi3EnterStepMode()),
        call!(h, &[Step, Intermediate, Terminated], fmi3GetOutputDerivatives(&vr("E_total"), 1, &1, &mut 0.0, 1)),
        ("fmi3DoStep", &[Step], |h| h.step(0.0, 1.0).0),
        call!(h, &[], fmi3ActivateModelPartition(0, 0.0)),
    ],
    &[
        call!(h, &[Event], fmi3EnterContinuousTimeMode()),
        call!(h, &[Continuous], fmi3CompletedIntegratorStep(1, &mut 0, &mut 0)),
        call!(h, &[Continuous], fmi3SetTime(0.0)),
        call!(h, &[Continuous], fmi3SetContinuousStates([0.0; 17].as_ptr(), 17)),
        call!(h, CONTINUOUS, fmi3GetContinuousStateDerivatives([0.0; 17].as_mut_ptr(), 17)),
        call!(h, CONTINUOUS, fmi3GetEventIndicators([0.0; 10].as_mut_ptr(), 10)),
        call!(h, CONTINUOUS, fmi3GetContinuousStates([0.0; 17].as_mut_ptr(), 17)),
        call!(h, NOMINALS, fmi3GetNominalsOfContinuousStates([0.0; 17].as_mut_ptr(), 17)),
        call!(h, ANY, fmi3GetNumberOfEventIndicators(&mut 0)),
        call!(h, ANY, fmi3GetNumberOfContinuousStates(&mut 0)),
    ],
];

#[test]
fn calls_are_legal_exactly_where_fmi_3_says_so() {
    // All but fmi3GetVersion, three that instantiate, fmi3FreeInstance and fmi3SerializeFMUState, which is called on
    // the way.
    assert_eq!(COMMON.len() + OWN[0].len() + OWN[1].len(), 75 - 6);
    for (exchange, states) in [false, true].into_iter().zip(STATES) {
        let has = COMMON.iter().chain(OWN[usize::from(exchange)]).map(|function| (function, true));
        let others = OWN[usize::from(!exchange)].iter().map(|function| (function, false));
        for ((name, legal, function), has) in has.chain(others) {
            for state in states {
                let expected = if has && legal.contains(state) { fmi3OK } else { fmi3Error };
                assert_eq!(ask(*state, exchange, *function), expected, "{name} in {state:?}, {exchange}");
            }
        }
    }
}

#[test]
fn fmi3_refuses_instances_of_fmi_2() {
    let (host, other) = (Host::new(true, true), cradle_host::Host::started());
    unsafe {
        assert_eq!(newtons_cradle::fmi2::fmi2Reset(host.c), cradle_host::fmi2Error);
        assert_eq!(fmi3Reset(other.c), fmi3Error);
        fmi3FreeInstance(other.c); // Left alone.
        newtons_cradle::fmi2::fmi2FreeInstance(host.c);
        assert_eq!(fmi3Reset(host.c), fmi3OK);
    }
    assert_eq!(other.reset(), cradle_host::fmi2OK);
}

#[test]
fn fmi3_description_is_the_table() {
    for balls in [1, 2, 5, 13, 100] {
        let settings = Settings::default_for(balls);
        let xml = Description::fmi3(&settings).xml("2000-01-01T00:00:00Z");
        let description = Fmi3ModelDescription::deserialize(&xml).unwrap();
        assert_eq!(description.instantiation_token, Description::fmi3(&settings).guid());
        assert_ne!(description.instantiation_token, Description::of(&settings).guid());
        assert!(!xml.contains("{{") && !xml.contains("}}"));
        for array in Variable::arrays() {
            let name = format!(" name=\"{array}\" valueReference=\"{}\"", array.reference());
            let line = xml.lines().find(|line| line.contains(&name)).unwrap();
            let is_array = array.row.shape != Shape::Scalar;
            assert_eq!(line.contains("<Dimension valueReference=\"1\"/>"), is_array, "{line}");
            let start = line.split_once(" start=\"").map(|(_, rest)| rest.split('"').next().unwrap());
            let settable = [Causality::Parameter, Causality::Input, Causality::StructuralParameter];
            let set = settable.contains(&array.row.causality);
            assert_eq!(array.has_start(), set, "{array}");
            assert_eq!(start.map(|start| start.split(' ').count()), set.then_some(array.len(balls)), "{line}");
        }
        let outputs = Variable::arrays().filter(|array| array.row.causality == Causality::Output).count();
        assert_eq!(xml.matches("<Output ").count(), outputs);
    }
}

/// The host may select rigid contacts, whose forces depend on inputs directly, whatever the start value is.
#[test]
fn fmi3_dependencies_cover_every_contact_model() {
    let structure = |model| {
        let mut settings = Settings::default_for(5);
        settings.parameters.contact_model = model;
        let xml = Description::fmi3(&settings).xml("");
        xml[xml.find("<ModelStructure>").unwrap()..].to_owned()
    };
    let resolved = structure(ContactModel::PowerLaw);
    assert_eq!(resolved, structure(ContactModel::Rigid));
    const EVERYTHING: &[&str] = &["q", "v", "F_ext", "a_support"];
    let of_forces = ["F", "F_mean", "a", "der(E_dissipated)", "z.contact", "z.clip"].map(|name| (name, EVERYTHING));
    let others = [("t_next", &["F_ext", "a_support"][..]), ("E_total", &["q", "v"]), ("der(q)", &["v"])];
    for (unknown, dependencies) in of_forces.into_iter().chain(others) {
        let references = dependencies.iter().map(|name| vr(name)).collect::<BTreeSet<u32>>();
        let references = references.iter().map(u32::to_string).collect::<Vec<_>>().join(" ");
        let entry = format!(" valueReference=\"{}\" dependencies=\"{references}\"/>", vr(unknown));
        let listed = resolved.lines().any(|line| !line.contains("InitialUnknown") && line.ends_with(&entry));
        assert!(listed, "{unknown} on {dependencies:?}");
    }
}

/// Also of a step that returns early, again and again.
#[test]
fn fmi3_step_past_the_stop_time_is_told_once() {
    let (host, mut time, mut steps) = (Host::new(true, true), 0.0, 0);
    assert_eq!(unsafe { fmi3EnterInitializationMode(host.c, 0, 0.0, 0.0, 1, 3.0) }, fmi3OK);
    assert_eq!(unsafe { fmi3ExitInitializationMode(host.c) }, fmi3OK);
    while time < 3.5 {
        assert_eq!(unsafe { fmi3EnterStepMode(host.c) }, fmi3OK);
        (_, _, time) = host.step(time, 3.5 - time);
        assert_eq!(unsafe { fmi3EnterEventMode(host.c) }, fmi3OK);
        host.update();
        steps += 1;
    }
    let told = host.log().into_iter().filter(|line| line.contains("stopTime = 3 s"));
    assert_eq!((steps > 3, told.count()), (true, 1));
}
