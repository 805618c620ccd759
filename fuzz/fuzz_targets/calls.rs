//! Drives the C functions with random sequences of calls and compares the answers with a model of what is legal: a
//! legal call must not fail, an illegal one must answer fmi2Error, say so in the log, and change nothing.
#![no_main]

use std::ffi::CString;
use std::ptr::{null, null_mut};
use std::sync::LazyLock;

use arbitrary::Arbitrary;
use cradle_fuzz::interface::Interface;
use cradle_fuzz::model::{Call, Model, Phase, Type, Vector, Verdict};
use cradle_fuzz::operation::{Operation, PLACES};
use cradle_host::{Host, Line, fmi2Error, fmi2OK};
use libfuzzer_sys::fuzz_target;
use newtons_cradle::fmi2::*;

static INTERFACE: LazyLock<Interface> = LazyLock::new(Interface::default);

/// Calls after which a sequence ends, so that none takes long.
const LONGEST: usize = 60;

#[derive(Debug, Arbitrary)]
struct Sequence {
    /// What it starts from.
    beginning: Beginning,
    operations: Vec<Operation>,
}

#[derive(Debug, Arbitrary)]
enum Beginning {
    Instantiated,
    Started,
    /// A step that failed.
    Failed,
    /// The same for model exchange, where the host integrates.
    Exchanging,
    Integrating,
}

thread_local! {
    /// Reset before each sequence: creating one takes as long as many calls.
    static HOST: Host = Host::new();
    static EXCHANGING: Host = Host::exchanging(5);
}

fuzz_target!(|sequence: Sequence| {
    let exchange = matches!(sequence.beginning, Beginning::Exchanging | Beginning::Integrating);
    let host = if exchange { &EXCHANGING } else { &HOST };
    host.with(|host| {
        assert_eq!((host.reset(), unsafe { fmi2SetDebugLogging(host.c, 0, 0, null()) }), (fmi2OK, fmi2OK));
        let mut driver = Driver::new(host, &sequence.beginning);
        for operation in sequence.operations.iter().take(LONGEST) {
            driver.make(operation);
        }
        driver.free();
    });
});

/// A host with its picture of the instance, and with places for states and bytes.
struct Driver<'a> {
    host: &'a Host,
    model: Model<'static>,
    states: [fmi2FMUstate; PLACES],
    saved: [Option<Model<'static>>; PLACES],
    bytes: [Option<(Vec<u8>, Model<'static>)>; PLACES],
}

impl<'a> Driver<'a> {
    fn new(host: &'a Host, beginning: &Beginning) -> Self {
        let mut driver = Self {
            host,
            model: Model::new(&INTERFACE, matches!(beginning, Beginning::Exchanging | Beginning::Integrating)),
            states: [null_mut(); PLACES],
            saved: [const { None }; PLACES],
            bytes: [const { None }; PLACES],
        };
        match beginning {
            Beginning::Instantiated | Beginning::Exchanging => {}
            Beginning::Started | Beginning::Integrating => {
                driver.check(&Call::SetupExperiment { tolerance: None, start: 0.0, stop: None });
                driver.check(&Call::EnterInitializationMode);
                driver.check(&Call::ExitInitializationMode);
            }
            Beginning::Failed => {
                host.fail();
                driver.model.phase = Phase::Error;
                // What is found by looking ahead is kept with the state: look before anything is compared.
                driver.look();
            }
        }
        driver
    }

    fn make(&mut self, operation: &Operation) {
        let stepping = matches!(self.model.phase, Phase::StepComplete | Phase::EventMode | Phase::ContinuousTime);
        let next_onset = if stepping { self.host.get("t_next") } else { 0.0 };
        self.check(&operation.call(&INTERFACE, &self.model, next_onset));
    }

    /// Makes a call and compares the answer with the model's.
    fn check(&mut self, call: &Call) {
        let verdict = self.model.judge(call, |place| match call {
            Call::DeSerializeFMUstate { .. } => self.bytes[place].is_some(),
            _ => !self.states[place].is_null(),
        });
        let before = self.host.to_bytes();
        let status = self.perform(call);
        let log = self.host.log();
        let accepted = status == fmi2OK;
        match verdict {
            Verdict::Legal => assert!(accepted, "{call:?} in {:?}: {status:?} {log:?}", self.model.phase),
            Verdict::Illegal => assert!(!accepted, "{call:?} in {:?}", self.model.phase),
            Verdict::MayLack => {
                let none = |line: &Line| line.text.contains("has no derivative here");
                assert!(accepted || log.iter().all(none), "{call:?} in {:?}: {log:?}", self.model.phase);
            }
        }
        if accepted {
            assert!(log.iter().all(|line| line.status == fmi2OK), "{call:?}: {log:?}");
            self.model.accept(call);
            self.keep(call);
            self.look();
        } else {
            assert_eq!(status, fmi2Error);
            let [line] = log.as_slice() else { panic!("{call:?}: not one line but {log:?}") };
            assert_eq!((line.status, line.category.as_str()), (fmi2Error, "logStatusError"));
            assert!(line.text.starts_with(&format!("{}: ", function(call))), "{call:?}: {}", line.text);
            assert!(
                self.host.to_bytes() == before,
                "{call:?} was refused in {:?} and changed something",
                self.model.phase
            );
        }
    }

    /// Keeps the model beside the states and bytes that the host keeps.
    fn keep(&mut self, call: &Call) {
        match call {
            Call::GetFMUstate(place) => self.saved[*place] = Some(self.model.clone()),
            Call::SetFMUstate(place) => self.model = self.saved[*place].clone().unwrap(),
            Call::FreeFMUstate(place) => self.saved[*place] = None,
            Call::SerializeFMUstate { from, to, .. } => {
                let model = self.saved[*from].clone().unwrap();
                self.bytes[*to].as_mut().unwrap().1 = model;
            }
            Call::DeSerializeFMUstate { from, to, .. } => {
                self.saved[*to] = self.bytes[*from].as_ref().map(|(_, model)| model.clone());
            }
            _ => {}
        }
    }

    /// What can be read is what the model says, and finite.
    fn look(&self) {
        if self.model.phase == Phase::Instantiated {
            return;
        }
        for (variable, value) in INTERFACE.read(self.host) {
            assert!(value.is_finite() || self.model.phase == Phase::Error, "{} = {value}", variable.name);
            // What the host set before the step that failed is the test's business.
            if self.model.phase != Phase::Error
                && let Some((set, off)) = self.model.setting(variable.reference)
            {
                assert!((value - set).abs() <= off, "{} = {value} is not {set}", variable.name);
            }
        }
        if self.model.phase == Phase::StepComplete {
            let mut time = f64::NAN;
            assert_eq!(unsafe { fmi2GetRealStatus(self.host.c, fmi2LastSuccessfulTime, &mut time) }, fmi2OK);
            assert_eq!(time, self.model.time);
        }
    }

    fn free(self) {
        for state in self.states {
            self.host.free(state);
        }
    }

    /// Makes a call.
    fn perform(&mut self, call: &Call) -> fmi2Status {
        let c = self.host.c;
        unsafe {
            match call {
                Call::SetDebugLogging { on, categories } => {
                    let names: Vec<CString> =
                        categories.iter().map(|name| CString::new(name.as_str()).unwrap()).collect();
                    let pointers: Vec<fmi2String> = names.iter().map(|name| name.as_ptr()).collect();
                    fmi2SetDebugLogging(c, (*on).into(), pointers.len(), pointers.as_ptr())
                }
                Call::SetupExperiment { tolerance, start, stop } => fmi2SetupExperiment(
                    c,
                    tolerance.is_some().into(),
                    tolerance.unwrap_or(f64::NAN),
                    *start,
                    stop.is_some().into(),
                    stop.unwrap_or(f64::NAN),
                ),
                Call::EnterInitializationMode => fmi2EnterInitializationMode(c),
                Call::ExitInitializationMode => fmi2ExitInitializationMode(c),
                Call::Terminate => fmi2Terminate(c),
                Call::Reset => fmi2Reset(c),
                Call::Get { of, references, null } => get(c, *of, references, *null),
                Call::Set { of, values, null } => set(c, *of, values, *null),
                Call::GetFMUstate(place) => fmi2GetFMUstate(c, &mut self.states[*place]),
                Call::SetFMUstate(place) => fmi2SetFMUstate(c, self.states[*place]),
                Call::FreeFMUstate(place) => fmi2FreeFMUstate(c, &mut self.states[*place]),
                Call::SerializeFMUstate { from, to, excess } => {
                    let (state, mut size) = (self.states[*from], 0);
                    let status = fmi2SerializedFMUstateSize(c, state, &mut size);
                    if status != fmi2OK {
                        self.host.log();
                    }
                    let mut bytes = vec![0u8; size + excess];
                    let status = fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr().cast(), bytes.len());
                    if status == fmi2OK {
                        self.bytes[*to] = Some((bytes, self.model.clone()));
                    }
                    status
                }
                Call::DeSerializeFMUstate { from, to, missing } => {
                    let bytes = self.bytes[*from].as_ref().map_or(&[][..], |(bytes, _)| bytes);
                    let size = bytes.len().saturating_sub(*missing);
                    fmi2DeSerializeFMUstate(c, bytes.as_ptr().cast(), size, &mut self.states[*to])
                }
                Call::SetRealInputDerivatives(values) => {
                    let references: Vec<u32> = values.iter().map(|value| value.0).collect();
                    let orders: Vec<i32> = values.iter().map(|value| value.1).collect();
                    let values: Vec<f64> = values.iter().map(|value| value.2).collect();
                    fmi2SetRealInputDerivatives(
                        c,
                        references.as_ptr(),
                        references.len(),
                        orders.as_ptr(),
                        values.as_ptr(),
                    )
                }
                Call::GetRealOutputDerivatives(wanted) => {
                    let (references, orders): (Vec<u32>, Vec<i32>) = wanted.iter().copied().unzip();
                    let mut values = vec![f64::NAN; wanted.len()];
                    fmi2GetRealOutputDerivatives(
                        c,
                        references.as_ptr(),
                        references.len(),
                        orders.as_ptr(),
                        values.as_mut_ptr(),
                    )
                }
                Call::GetDirectionalDerivative { unknowns, knowns } => {
                    let (known, direction): (Vec<u32>, Vec<f64>) = knowns.iter().copied().unzip();
                    let mut values = vec![f64::NAN; unknowns.len()];
                    fmi2GetDirectionalDerivative(
                        c,
                        unknowns.as_ptr(),
                        unknowns.len(),
                        known.as_ptr(),
                        known.len(),
                        direction.as_ptr(),
                        values.as_mut_ptr(),
                    )
                }
                Call::DoStep { current, step } => fmi2DoStep(c, *current, *step, 0),
                Call::CancelStep => fmi2CancelStep(c),
                Call::GetStatus { of, kind } => match of {
                    None => fmi2GetStatus(c, *kind, &mut fmi2Error.clone()),
                    Some(Type::Real) => fmi2GetRealStatus(c, *kind, &mut 0.0),
                    Some(Type::Integer) => fmi2GetIntegerStatus(c, *kind, &mut 0),
                    Some(Type::Boolean) => fmi2GetBooleanStatus(c, *kind, &mut 0),
                    Some(Type::String) => fmi2GetStringStatus(c, *kind, &mut null()),
                },
                Call::EnterEventMode => fmi2EnterEventMode(c),
                Call::NewDiscreteStates => update(c, self.model.time),
                Call::EnterContinuousTimeMode => fmi2EnterContinuousTimeMode(c),
                Call::CompletedIntegratorStep => fmi2CompletedIntegratorStep(c, 1, &mut 0, &mut 0),
                Call::SetTime(time) => fmi2SetTime(c, *time),
                Call::SetContinuousStates { step, missing } => {
                    let (mut y, mut rates) = (vec![0.0; INTERFACE.states], vec![0.0; INTERFACE.states]);
                    if self.model.phase == Phase::ContinuousTime {
                        assert_eq!(fmi2GetContinuousStates(c, y.as_mut_ptr(), y.len()), fmi2OK);
                        assert_eq!(fmi2GetDerivatives(c, rates.as_mut_ptr(), y.len()), fmi2OK);
                    }
                    // A step of zero length that is not finite is not finite either.
                    y.iter_mut().zip(rates).for_each(|(y, rate)| *y += step * rate + 0.0 * step);
                    fmi2SetContinuousStates(c, y.as_ptr(), y.len() - missing)
                }
                Call::GetVector { of, missing } => vector(c, *of, *missing),
            }
        }
    }
}

/// Handles an event at `time` (s).
unsafe fn update(c: fmi2Component, time: f64) -> fmi2Status {
    let mut info = fmi2EventInfo {
        newDiscreteStatesNeeded: 0,
        terminateSimulation: 0,
        nominalsOfContinuousStatesChanged: 0,
        valuesOfContinuousStatesChanged: 0,
        nextEventTimeDefined: 0,
        nextEventTime: f64::NAN,
    };
    let status = unsafe { fmi2NewDiscreteStates(c, &mut info) };
    assert!(info.nextEventTimeDefined == 0 || info.nextEventTime > time, "{} {time}", info.nextEventTime);
    status
}

/// Reads a value for each state or indicator, `missing` too few of them.
unsafe fn vector(c: fmi2Component, of: Vector, missing: usize) -> fmi2Status {
    let length = if of == Vector::EventIndicators { INTERFACE.indicators } else { INTERFACE.states };
    let mut values = vec![f64::NAN; length];
    let (place, count) = (values.as_mut_ptr(), length - missing);
    unsafe {
        match of {
            Vector::ContinuousStates => fmi2GetContinuousStates(c, place, count),
            Vector::Derivatives => fmi2GetDerivatives(c, place, count),
            Vector::NominalsOfContinuousStates => fmi2GetNominalsOfContinuousStates(c, place, count),
            Vector::EventIndicators => fmi2GetEventIndicators(c, place, count),
        }
    }
}

/// Reads values; with `null` into nowhere.
unsafe fn get(c: fmi2Component, of: Type, references: &[u32], nowhere: bool) -> fmi2Status {
    let (vr, nvr) = (references.as_ptr(), references.len());
    fn place<T>(values: &mut [T], nowhere: bool) -> *mut T {
        if nowhere { null_mut() } else { values.as_mut_ptr() }
    }
    unsafe {
        match of {
            Type::Real => fmi2GetReal(c, vr, nvr, place(&mut vec![0.0; nvr], nowhere)),
            Type::Integer => fmi2GetInteger(c, vr, nvr, place(&mut vec![0; nvr], nowhere)),
            Type::Boolean => fmi2GetBoolean(c, vr, nvr, place(&mut vec![0; nvr], nowhere)),
            Type::String => fmi2GetString(c, vr, nvr, place(&mut vec![null(); nvr], nowhere)),
        }
    }
}

/// Sets values; with `null` from nowhere.
unsafe fn set(c: fmi2Component, of: Type, values: &[(u32, f64)], nowhere: bool) -> fmi2Status {
    let references: Vec<u32> = values.iter().map(|value| value.0).collect();
    let (vr, nvr) = (references.as_ptr(), references.len());
    fn place<T>(values: &[T], nowhere: bool) -> *const T {
        if nowhere { null() } else { values.as_ptr() }
    }
    let reals: Vec<f64> = values.iter().map(|value| value.1).collect();
    let integers: Vec<i32> = reals.iter().map(|value| *value as i32).collect();
    unsafe {
        match of {
            Type::Real => fmi2SetReal(c, vr, nvr, place(&reals, nowhere)),
            Type::Integer => fmi2SetInteger(c, vr, nvr, place(&integers, nowhere)),
            Type::Boolean => fmi2SetBoolean(c, vr, nvr, place(&integers, nowhere)),
            Type::String => fmi2SetString(c, vr, nvr, place(&vec![c"1".as_ptr(); nvr], nowhere)),
        }
    }
}

/// Name of the C function.
fn function(call: &Call) -> String {
    match call {
        Call::Get { of, .. } => format!("fmi2Get{of:?}"),
        Call::Set { of, .. } => format!("fmi2Set{of:?}"),
        Call::GetVector { of, .. } => format!("fmi2Get{of:?}"),
        Call::GetStatus { of: Some(of), .. } => format!("fmi2Get{of:?}Status"),
        other => format!("fmi2{}", format!("{other:?}").split(['(', ' ']).next().unwrap_or_default()),
    }
}
