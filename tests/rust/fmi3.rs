//! FMI 3.0: which function may be called in which state (FMI 3.0.2, sections 2.3 and 4.2), call by call, both ways, and
//! the description as another reader understands it. A legal call is not turned down for its time; an illegal one
//! answers fmi3Error, and the run is over.

mod exchange;
mod refused;

use std::cell::Cell;
use std::ffi::{CString, c_void};
use std::ptr::{null, null_mut};

use fmi_schema::fmi3::Fmi3ModelDescription;
use fmi_schema::traits::FmiModelDescription;
use newtons_cradle::fmi3::fmi3Status::{fmi3Error, fmi3OK};
use newtons_cradle::fmi3::*;
use newtons_cradle::model::ContactModel;
use newtons_cradle::variables::{Array, Causality, Description, Settings, Shape};

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Instantiated,
    Configuration,
    Initialization,
    Event,
    Step,
    /// Within a step, where the host has been called.
    Intermediate,
    Terminated,
    /// After a refused call, before initialization.
    Abandoned,
}
use State::{Abandoned, Configuration, Event, Initialization, Instantiated, Intermediate, Step, Terminated};

const STATES: [State; 8] =
    [Instantiated, Configuration, Initialization, Event, Step, Intermediate, Terminated, Abandoned];

/// A call.
type Asked = fn(fmi3Instance) -> fmi3Status;

/// An instance, and what it is to be asked within a step.
struct Host {
    c: fmi3Instance,
    asked: Cell<Option<Asked>>,
    answer: Cell<Option<fmi3Status>>,
}

unsafe extern "C" fn within(
    environment: *mut c_void,
    _time: f64,
    _set: u8,
    _get: u8,
    _finished: u8,
    _may_end: u8,
    _requested: *mut u8,
    _end: *mut f64,
) {
    let host = unsafe { &*environment.cast::<Host>() };
    if let Some(asked) = host.asked.take() {
        host.answer.set(Some(asked(host.c)));
    }
}

/// What inputs of five balls are set to.
static ZEROS: [f64; 5] = [0.0; 5];

fn vr(name: &str) -> u32 {
    Array::named(name).unwrap().reference()
}

impl Host {
    fn new() -> Box<Self> {
        let mut host = Box::new(Self { c: null_mut(), asked: Cell::new(None), answer: Cell::new(None) });
        let token = CString::new(Description::fmi3(&Settings::default_for(5)).guid()).unwrap();
        let environment: *mut Self = &mut *host;
        let update: fmi3IntermediateUpdateCallback = Some(within);
        host.c = unsafe {
            fmi3InstantiateCoSimulation(
                c"test".as_ptr(),
                token.as_ptr(),
                null(),
                0,
                0,
                1,
                1,
                null(),
                0,
                environment.cast(),
                None,
                update,
            )
        };
        assert!(!host.c.is_null());
        host
    }

    /// What `function` answers in this state.
    fn ask(state: State, function: Asked) -> fmi3Status {
        let host = Self::new();
        let c = host.c;
        let ok = |status| assert_eq!(status, fmi3OK, "{state:?}");
        unsafe {
            if state == Configuration {
                ok(fmi3EnterConfigurationMode(c));
            }
            if state == Abandoned {
                assert_eq!(fmi3EnterStepMode(c), fmi3Error);
            }
            if !matches!(state, Instantiated | Configuration | Abandoned) {
                ok(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0));
            }
            if matches!(state, Event | Step | Intermediate | Terminated) {
                ok(fmi3ExitInitializationMode(c));
            }
            if matches!(state, Step | Intermediate | Terminated) {
                ok(fmi3EnterStepMode(c));
            }
            if state == Terminated {
                ok(fmi3Terminate(c));
            }
        }
        if state == Intermediate {
            host.asked.set(Some(function));
            do_step(c);
            return host.answer.get().unwrap();
        }
        function(c)
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        unsafe { fmi3FreeInstance(self.c) };
    }
}

fn do_step(c: fmi3Instance) -> fmi3Status {
    let (mut flags, mut time) = ([0_u8; 3], 0.0);
    let [events, terminate, early] = &mut flags;
    unsafe { fmi3DoStep(c, 0.0, 1.0, 1, events, terminate, early, &mut time) }
}

fn update(c: fmi3Instance) -> fmi3Status {
    let (mut flags, mut time) = ([0_u8; 5], 0.0);
    let [again, terminate, nominals, values, defined] = &mut flags;
    unsafe { fmi3UpdateDiscreteStates(c, again, terminate, nominals, values, defined, &mut time) }
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

fn weighted(
    function: unsafe extern "C" fn(
        fmi3Instance,
        *const u32,
        usize,
        *const u32,
        usize,
        *const f64,
        usize,
        *mut f64,
        usize,
    ) -> fmi3Status,
    c: fmi3Instance,
) -> fmi3Status {
    let mut found = [0.0; 5];
    unsafe { function(c, &vr("x"), 1, &vr("F_ext"), 1, ZEROS.as_ptr(), 5, found.as_mut_ptr(), 5) }
}

type Function = (&'static str, &'static [State], Asked);

const ANY: &[State] = &[Instantiated, Configuration, Initialization, Event, Step, Terminated, Abandoned];
const READ: &[State] = &[Initialization, Event, Step, Intermediate, Terminated];
/// What has a start value can be read before initialization, what is calculated cannot.
const START: &[State] = &[Instantiated, Initialization, Event, Step, Intermediate, Terminated];
const READ_NOTHING: &[State] = &[Instantiated, Initialization, Event, Step, Intermediate, Terminated];
/// There are no clocks with intervals: a call for none of them does nothing.
const INTERVALS: &[State] = &[Initialization, Event];
const SET: &[State] = &[Instantiated, Initialization, Event, Step, Intermediate];
const SET_DISCRETE: &[State] = &[Instantiated, Initialization, Event, Step];
const SENSITIVE: &[State] = &[Initialization, Event, Step, Terminated];
const NOWHERE: &[State] = &[];

/// Getter and setter of a type that no variable has.
macro_rules! untyped {
    ($get:ident $set:ident) => {
        [
            (stringify!($get), READ_NOTHING, (|c| unsafe { $get(c, null(), 0, null_mut(), 0) }) as Asked),
            (stringify!($set), SET_DISCRETE, |c| unsafe { $set(c, null(), 0, null(), 0) }),
        ]
    };
}

/// Every function with an instance but fmi3FreeInstance, the states it is legal in, and a call that is fine in those.
fn functions() -> Vec<Function> {
    let mut functions: Vec<Function> = vec![
        ("fmi3SetDebugLogging", &STATES, |c| unsafe { fmi3SetDebugLogging(c, 0, 0, null()) }),
        ("fmi3EnterInitializationMode", &[Instantiated], |c| unsafe {
            fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0)
        }),
        ("fmi3ExitInitializationMode", &[Initialization], |c| unsafe { fmi3ExitInitializationMode(c) }),
        ("fmi3EnterEventMode", &[Step], |c| unsafe { fmi3EnterEventMode(c) }),
        ("fmi3Terminate", &[Event, Step], |c| unsafe { fmi3Terminate(c) }),
        ("fmi3Reset", ANY, |c| unsafe { fmi3Reset(c) }),
        ("fmi3GetFloat64", READ, |c| unsafe { fmi3GetFloat64(c, &vr("E_total"), 1, &mut 0.0, 1) }),
        ("fmi3GetUInt64", READ, |c| unsafe { fmi3GetUInt64(c, &vr("pulses"), 1, [0; 5].as_mut_ptr(), 5) }),
        ("fmi3GetInt64", START, |c| unsafe { fmi3GetInt64(c, &vr("contact.model"), 1, &mut 0, 1) }),
        ("fmi3GetBoolean", READ, |c| unsafe { fmi3GetBoolean(c, &vr("inContact"), 1, [0; 5].as_mut_ptr(), 5) }),
        ("fmi3GetClock", READ, |c| unsafe { fmi3GetClock(c, &vr("onset.clock"), 1, &mut 0) }),
        ("fmi3GetBinary", READ_NOTHING, |c| unsafe { fmi3GetBinary(c, null(), 0, null_mut(), null_mut(), 0) }),
        ("fmi3SetFloat64", SET, |c| unsafe { fmi3SetFloat64(c, &vr("F_ext"), 1, ZEROS.as_ptr(), 5) }),
        ("fmi3SetUInt64", &[Configuration], |c| unsafe { fmi3SetUInt64(c, &vr("n"), 1, &7, 1) }),
        ("fmi3SetInt64", SET_DISCRETE, |c| unsafe { fmi3SetInt64(c, null(), 0, null(), 0) }),
        ("fmi3SetBoolean", SET_DISCRETE, |c| unsafe { fmi3SetBoolean(c, null(), 0, null(), 0) }),
        ("fmi3SetClock", SET_DISCRETE, |c| unsafe { fmi3SetClock(c, null(), 0, null()) }),
        ("fmi3SetBinary", SET_DISCRETE, |c| unsafe { fmi3SetBinary(c, null(), 0, null(), null(), 0) }),
        ("fmi3GetFMUState", ANY, |c| with_state(c, |_| fmi3OK)),
        ("fmi3SetFMUState", ANY, |c| with_state(c, |state| unsafe { fmi3SetFMUState(c, state) })),
        ("fmi3FreeFMUState", ANY, |c| unsafe { fmi3FreeFMUState(c, &mut null_mut()) }),
        ("fmi3SerializedFMUStateSize", ANY, |c| {
            with_state(c, |state| unsafe { fmi3SerializedFMUStateSize(c, state, &mut 0) })
        }),
        ("fmi3DeserializeFMUState", ANY, |c| {
            with_state(c, |state| unsafe {
                let mut size = 0;
                assert_eq!(fmi3SerializedFMUStateSize(c, state, &mut size), fmi3OK);
                let mut bytes = vec![0; size];
                assert_eq!(fmi3SerializeFMUState(c, state, bytes.as_mut_ptr(), size), fmi3OK);
                fmi3DeserializeFMUState(c, bytes.as_ptr(), size, &mut { state })
            })
        }),
        ("fmi3GetDirectionalDerivative", SENSITIVE, |c| weighted(fmi3GetDirectionalDerivative, c)),
        ("fmi3GetAdjointDerivative", SENSITIVE, |c| weighted(fmi3GetAdjointDerivative, c)),
        ("fmi3EnterConfigurationMode", &[Instantiated], |c| unsafe { fmi3EnterConfigurationMode(c) }),
        ("fmi3ExitConfigurationMode", &[Configuration], |c| unsafe { fmi3ExitConfigurationMode(c) }),
        ("fmi3UpdateDiscreteStates", &[Event], update),
        ("fmi3EnterStepMode", &[Event], |c| unsafe { fmi3EnterStepMode(c) }),
        ("fmi3GetOutputDerivatives", &[Step, Intermediate, Terminated], |c| unsafe {
            fmi3GetOutputDerivatives(c, &vr("E_total"), 1, &1, &mut 0.0, 1)
        }),
        ("fmi3DoStep", &[Step], do_step),
        // Not offered, or for model exchange.
        ("fmi3GetNumberOfVariableDependencies", NOWHERE, |c| unsafe {
            fmi3GetNumberOfVariableDependencies(c, 0, &mut 0)
        }),
        ("fmi3GetVariableDependencies", NOWHERE, |c| unsafe {
            fmi3GetVariableDependencies(c, 0, null_mut(), null_mut(), null_mut(), null_mut(), 0)
        }),
        ("fmi3GetIntervalDecimal", INTERVALS, |c| unsafe {
            fmi3GetIntervalDecimal(c, null(), 0, null_mut(), null_mut())
        }),
        ("fmi3GetIntervalFraction", INTERVALS, |c| unsafe {
            fmi3GetIntervalFraction(c, null(), 0, null_mut(), null_mut(), null_mut())
        }),
        ("fmi3GetShiftDecimal", INTERVALS, |c| unsafe { fmi3GetShiftDecimal(c, null(), 0, null_mut()) }),
        ("fmi3GetShiftFraction", INTERVALS, |c| unsafe { fmi3GetShiftFraction(c, null(), 0, null_mut(), null_mut()) }),
        ("fmi3SetIntervalDecimal", INTERVALS, |c| unsafe { fmi3SetIntervalDecimal(c, null(), 0, null()) }),
        ("fmi3SetIntervalFraction", INTERVALS, |c| unsafe { fmi3SetIntervalFraction(c, null(), 0, null(), null()) }),
        ("fmi3SetShiftDecimal", INTERVALS, |c| unsafe { fmi3SetShiftDecimal(c, null(), 0, null()) }),
        ("fmi3SetShiftFraction", INTERVALS, |c| unsafe { fmi3SetShiftFraction(c, null(), 0, null(), null()) }),
        ("fmi3EvaluateDiscreteStates", &[Event], |c| unsafe { fmi3EvaluateDiscreteStates(c) }),
        ("fmi3EnterContinuousTimeMode", NOWHERE, |c| unsafe { fmi3EnterContinuousTimeMode(c) }),
        ("fmi3CompletedIntegratorStep", NOWHERE, |c| unsafe { fmi3CompletedIntegratorStep(c, 1, &mut 0, &mut 0) }),
        ("fmi3SetTime", NOWHERE, |c| unsafe { fmi3SetTime(c, 0.0) }),
        ("fmi3SetContinuousStates", NOWHERE, |c| unsafe { fmi3SetContinuousStates(c, null(), 0) }),
        ("fmi3GetContinuousStateDerivatives", NOWHERE, |c| unsafe {
            fmi3GetContinuousStateDerivatives(c, null_mut(), 0)
        }),
        ("fmi3GetEventIndicators", NOWHERE, |c| unsafe { fmi3GetEventIndicators(c, null_mut(), 0) }),
        ("fmi3GetContinuousStates", NOWHERE, |c| unsafe { fmi3GetContinuousStates(c, null_mut(), 0) }),
        ("fmi3GetNominalsOfContinuousStates", NOWHERE, |c| unsafe {
            fmi3GetNominalsOfContinuousStates(c, null_mut(), 0)
        }),
        ("fmi3GetNumberOfEventIndicators", NOWHERE, |c| unsafe { fmi3GetNumberOfEventIndicators(c, &mut 0) }),
        ("fmi3GetNumberOfContinuousStates", NOWHERE, |c| unsafe { fmi3GetNumberOfContinuousStates(c, &mut 0) }),
        ("fmi3ActivateModelPartition", NOWHERE, |c| unsafe { fmi3ActivateModelPartition(c, 0, 0.0) }),
    ];
    functions.extend(untyped!(fmi3GetFloat32 fmi3SetFloat32));
    functions.extend(untyped!(fmi3GetInt8 fmi3SetInt8));
    functions.extend(untyped!(fmi3GetUInt8 fmi3SetUInt8));
    functions.extend(untyped!(fmi3GetInt16 fmi3SetInt16));
    functions.extend(untyped!(fmi3GetUInt16 fmi3SetUInt16));
    functions.extend(untyped!(fmi3GetInt32 fmi3SetInt32));
    functions.extend(untyped!(fmi3GetUInt32 fmi3SetUInt32));
    functions.extend(untyped!(fmi3GetString fmi3SetString));
    functions
}

#[test]
fn calls_of_fmi_3_are_legal_where_the_standard_has_them() {
    let functions = functions();
    // All but fmi3GetVersion, three that instantiate, fmi3FreeInstance and fmi3SerializeFMUState, which is called on
    // the way.
    assert_eq!(functions.len(), 75 - 6);
    for (name, legal, function) in functions {
        for state in STATES {
            let expected = if legal.contains(&state) { fmi3OK } else { fmi3Error };
            assert_eq!(Host::ask(state, function), expected, "{name} in {state:?}");
        }
    }
}

#[test]
fn after_a_refused_call_there_is_a_new_start() {
    let host = Host::new();
    let c = host.c;
    unsafe {
        assert_eq!(fmi3EnterStepMode(c), fmi3Error);
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), fmi3Error);
        assert_eq!(fmi3Reset(c), fmi3OK);
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), fmi3OK);
        assert_eq!(fmi3ExitInitializationMode(c), fmi3OK);
    }
}

#[test]
fn an_instance_of_one_version_is_none_of_the_other() {
    let (host, other) = (Host::new(), cradle_host::Host::started());
    unsafe {
        assert_eq!(newtons_cradle::fmi2::fmi2Reset(host.c), cradle_host::fmi2Error);
        assert_eq!(fmi3Reset(other.c), fmi3Error);
        fmi3FreeInstance(other.c); // Left alone.
        newtons_cradle::fmi2::fmi2FreeInstance(host.c);
        assert_eq!(fmi3Reset(host.c), fmi3OK);
    }
    assert_eq!(other.reset(), cradle_host::fmi2OK);
}

/// For hosts that take no clocks: nothing else is left out, and the binary knows both descriptions by their tokens.
#[test]
fn the_clocks_can_be_left_out() {
    let settings = Settings::default_for(5);
    let [with, without] = [Description::fmi3(&settings), Description::fmi3(&settings).without_clocks()];
    let tokens = [&with, &without].map(|description| CString::new(description.guid()).unwrap());
    assert_ne!(tokens[0], tokens[1]);
    for token in tokens {
        let c =
            unsafe { fmi3InstantiateModelExchange(c"test".as_ptr(), token.as_ptr(), null(), 0, 0, null_mut(), None) };
        assert!(!c.is_null());
        unsafe { fmi3FreeInstance(c) };
    }
    let (with, without) = (with.xml(""), without.xml(""));
    for array in Array::all() {
        let (name, unknown) = (format!(" name=\"{array}\""), format!(" valueReference=\"{}\" dep", array.reference()));
        assert_eq!(without.contains(&name), with.contains(&name) && !array.needs_clocks(), "{array}");
        assert_eq!(without.contains(&unknown), with.contains(&unknown) && !array.needs_clocks(), "{array}");
    }
    assert!(!without.to_lowercase().contains("clock"));
}

#[test]
fn the_description_of_fmi_3_is_the_table() {
    for balls in [1, 2, 5, 13, 100] {
        let settings = Settings::default_for(balls);
        let xml = Description::fmi3(&settings).xml("2000-01-01T00:00:00Z");
        let description = Fmi3ModelDescription::deserialize(&xml).unwrap();
        assert_eq!(description.instantiation_token, Description::fmi3(&settings).guid());
        assert_ne!(description.instantiation_token, Description::of(&settings).guid());
        assert!(!xml.contains("{{") && !xml.contains("}}"));
        for array in Array::all() {
            let name = format!(" name=\"{array}\" valueReference=\"{}\"", array.reference());
            let line = xml.lines().find(|line| line.contains(&name)).unwrap();
            assert_eq!(
                line.contains("<Dimension valueReference=\"1\"/>"),
                (array.row.shape != Shape::Scalar),
                "{line}"
            );
            let start = line.split_once(" start=\"").map(|(_, rest)| rest.split('"').next().unwrap());
            let settable = [Causality::Parameter, Causality::Input, Causality::StructuralParameter];
            let set = settable.contains(&array.row.causality);
            assert_eq!(array.has_start(), set, "{array}");
            assert_eq!(start.map(|start| start.split(' ').count()), set.then_some(array.len(balls)), "{line}");
        }
        let outputs = Array::all().filter(|array| array.row.causality == Causality::Output).count();
        assert_eq!(xml.matches("<Output ").count(), outputs);
    }
}

/// The host may select rigid contacts, whose forces depend on inputs directly, whatever the start value is.
#[test]
fn dependencies_are_those_of_any_contact_model() {
    let structure = |model| {
        let mut settings = Settings::default_for(5);
        settings.parameters.contact_model = model;
        let xml = Description::fmi3(&settings).xml("");
        xml[xml.find("<ModelStructure>").unwrap()..].to_owned()
    };
    let resolved = structure(ContactModel::PowerLaw);
    assert_eq!(resolved, structure(ContactModel::Rigid));
    for unknown in ["F", "F_mean", "a", "der(E_dissipated)", "z.contact", "z.clip"] {
        let entry = format!(" valueReference=\"{}\" dependencies=\"", vr(unknown));
        let depends =
            resolved.lines().filter(|line| !line.contains("InitialUnknown")).find_map(|line| line.split_once(&entry));
        let (_, dependencies) = depends.unwrap_or_else(|| panic!("{unknown}"));
        let input = vr("F_ext").to_string();
        assert!(dependencies.split(['"', ' ']).any(|dependency| dependency == input), "{unknown}: {dependencies}");
    }
}
