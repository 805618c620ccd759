//! A host for FMI 3.0. It is called during steps, and keeps the log.

use std::cell::{Cell, RefCell};
use std::ffi::{CStr, CString, c_void};
use std::ptr::{null, null_mut};
use std::sync::LazyLock;

use newtons_cradle::fmi3::fmi3Status::fmi3OK;
use newtons_cradle::fmi3::*;
use newtons_cradle::variables::{Description, Settings, Variable};

/// What a host does in an intermediate update: it gets the instance, the time (s), and whether the step may end here,
/// and returns whether it asks for that.
pub type Within = Box<dyn FnMut(fmi3Instance, f64, bool) -> bool>;

/// A function of model exchange that returns a vector, such as states or event indicators.
pub type Getter = unsafe extern "C" fn(fmi3Instance, *mut f64, usize) -> fmi3Status;

#[derive(Default)]
struct Environment {
    c: Cell<fmi3Instance>,
    within: RefCell<Option<Within>>,
    lines: RefCell<Vec<String>>,
}

/// An instance of five balls.
pub struct Host {
    /// The instance, for calls that the host has no function for.
    pub c: fmi3Instance,
    environment: Box<Environment>,
}

unsafe extern "C" fn within(
    environment: *mut c_void,
    time: f64,
    may_set: u8,
    may_get: u8,
    _finished: u8,
    may_end: u8,
    requested: *mut u8,
    end: *mut f64,
) {
    assert_eq!((may_set, may_get), (1, 1));
    let environment = unsafe { &*environment.cast::<Environment>() };
    // Taken out while it runs, because it may call the instance, which may call back.
    let taken = environment.within.take();
    let ends = taken.is_some_and(|mut within| {
        let ends = within(environment.c.get(), time, may_end == 1);
        environment.within.replace(Some(within));
        ends
    });
    unsafe { (*requested, *end) = (ends.into(), time) };
}

unsafe extern "C" fn log(environment: *mut c_void, _status: fmi3Status, _category: fmi3String, message: fmi3String) {
    let line = unsafe { CStr::from_ptr(message) }.to_string_lossy().into_owned();
    unsafe { &*environment.cast::<Environment>() }.lines.borrow_mut().push(line);
}

/// The instantiation token of the FMU of five balls.
pub fn token() -> &'static CStr {
    static TOKEN: LazyLock<CString> =
        LazyLock::new(|| CString::new(Description::fmi3(&Settings::default_for(5)).guid()).unwrap());
    &TOKEN
}

/// The value reference of the variable of this name.
pub fn vr(name: &str) -> u32 {
    Variable::array(name).unwrap_or_else(|| panic!("no {name}")).reference()
}

impl Host {
    /// An instance for co-simulation, with event mode or not, with early return or not.
    pub fn new(events: bool, early: bool) -> Self {
        Self::instantiated(token(), Some([events, early])).unwrap()
    }

    /// An instance for model exchange.
    pub fn exchanging() -> Self {
        Self::instantiated(token(), None).unwrap()
    }

    /// An instance for co-simulation with the options `[events, early]`, or, if `None`, for model exchange; the log if
    /// it is refused.
    pub fn instantiated(token: &CStr, co_simulation: Option<[bool; 2]>) -> Result<Self, Vec<String>> {
        let environment = Box::<Environment>::default();
        let (name, pointer) = (c"cradle".as_ptr(), (&raw const *environment).cast_mut().cast());
        let (token, log, within) = (token.as_ptr(), Some(log as _), Some(within as _));
        let c = unsafe {
            if let Some([events, early]) = co_simulation.map(|options| options.map(fmi3Boolean::from)) {
                fmi3InstantiateCoSimulation(name, token, null(), 0, 1, events, early, null(), 0, pointer, log, within)
            } else {
                fmi3InstantiateModelExchange(name, token, null(), 0, 1, pointer, log)
            }
        };
        environment.c.set(c);
        if c.is_null() { Err(environment.lines.take()) } else { Ok(Self { c, environment }) }
    }

    /// Sets what the host does in intermediate updates from now on.
    pub fn within(&self, within: impl FnMut(fmi3Instance, f64, bool) -> bool + 'static) {
        self.environment.within.replace(Some(Box::new(within)));
    }

    /// Takes the log so far.
    pub fn log(&self) -> Vec<String> {
        self.environment.lines.take()
    }

    /// Enters Initialization Mode at t = 0.
    pub fn enter(&self) -> fmi3Status {
        unsafe { fmi3EnterInitializationMode(self.c, 0, 0.0, 0.0, 0, 0.0) }
    }

    /// Enters and exits Initialization Mode.
    pub fn start(&self) {
        assert_eq!(self.enter(), fmi3OK, "{:?}", self.log());
        assert_eq!(unsafe { fmi3ExitInitializationMode(self.c) }, fmi3OK, "{:?}", self.log());
    }

    /// Makes a step from `time` (s) of the length `step` (s). Returns the status, whether an event is to be handled,
    /// and the time reached (s).
    pub fn step(&self, time: f64, step: f64) -> (fmi3Status, bool, f64) {
        let ([mut events, mut terminate, mut early], mut reached) = ([9; 3], f64::NAN);
        let status =
            unsafe { fmi3DoStep(self.c, time, step, 1, &mut events, &mut terminate, &mut early, &mut reached) };
        if status == fmi3OK {
            assert!(terminate == 0 && events <= 1 && early == u8::from(reached < time.max(time + step)));
        } else {
            // For a host that ignores the status: terminateSimulation is set.
            assert_eq!((terminate, events, early), (1, 0, 0), "{status:?}");
            assert!(!reached.is_nan() || time.is_nan(), "{status:?}");
        }
        (status, events == 1, reached)
    }

    /// Calls fmi3UpdateDiscreteStates. Returns the status, whether it must be called again, whether states have
    /// changed, and when the next event is due (s), if that is defined.
    pub fn update(&self) -> (fmi3Status, bool, bool, Option<f64>) {
        let (mut flags, mut next) = ([9; 5], f64::NAN);
        let [again, end, nominals, values, defined] = &mut flags;
        let status = unsafe { fmi3UpdateDiscreteStates(self.c, again, end, nominals, values, defined, &mut next) };
        let [again, end, nominals, values, defined] = flags;
        if status == fmi3OK {
            assert!(end == 0 && nominals == 0 && [again, values, defined].iter().all(|flag| *flag <= 1));
        } else {
            assert_eq!((again, end, nominals, values, defined), (0, 1, 0, 0, 0), "{status:?}");
        }
        (status, again == 1, values == 1, (defined == 1).then_some(next))
    }

    /// The elements of a real variable.
    pub fn floats(&self, name: &str, length: usize) -> Vec<f64> {
        let mut values = vec![f64::NAN; length];
        assert_eq!(unsafe { fmi3GetFloat64(self.c, &vr(name), 1, values.as_mut_ptr(), length) }, fmi3OK, "{name}");
        values
    }

    /// Sets the elements of a real variable.
    pub fn set(&self, name: &str, values: &[f64]) -> fmi3Status {
        unsafe { fmi3SetFloat64(self.c, &vr(name), 1, values.as_ptr(), values.len()) }
    }

    /// The directional derivatives of the unknowns along the seed of the knowns or, if `adjoint`, the adjoint
    /// derivatives by the knowns with the seed of the unknowns; both are given by value references.
    pub fn derivatives(
        &self,
        adjoint: bool,
        [unknowns, knowns]: [&[u32]; 2],
        seed: &[f64],
        found: &mut [f64],
    ) -> fmi3Status {
        let function = if adjoint { fmi3GetAdjointDerivative } else { fmi3GetDirectionalDerivative };
        let (of, by, into) = (unknowns.as_ptr(), knowns.as_ptr(), found.as_mut_ptr());
        let [rows, columns, seeds] = [unknowns.len(), knowns.len(), seed.len()];
        unsafe { function(self.c, of, rows, by, columns, seed.as_ptr(), seeds, into, found.len()) }
    }

    /// The vector that a function of model exchange returns.
    pub fn vector<const N: usize>(&self, get: Getter) -> [f64; N] {
        let mut values = [f64::NAN; N];
        assert_eq!(unsafe { get(self.c, values.as_mut_ptr(), N) }, fmi3OK, "{:?}", self.log());
        values
    }

    /// The elements of an integer variable.
    pub fn counts(&self, name: &str, length: usize) -> Vec<u64> {
        let mut values = vec![u64::MAX; length];
        assert_eq!(unsafe { fmi3GetUInt64(self.c, &vr(name), 1, values.as_mut_ptr(), length) }, fmi3OK, "{name}");
        values
    }

    /// The elements of a boolean variable.
    pub fn flags(&self, name: &str, length: usize) -> Vec<bool> {
        let mut values = vec![9; length];
        assert_eq!(unsafe { fmi3GetBoolean(self.c, &vr(name), 1, values.as_mut_ptr(), length) }, fmi3OK, "{name}");
        assert!(values.iter().all(|value| *value <= 1), "{name}: {values:?}");
        values.into_iter().map(|value| value == 1).collect()
    }

    /// Whether a clock is active.
    pub fn is_active(&self, clock: &str) -> bool {
        let mut active = 9;
        assert_eq!(unsafe { fmi3GetClock(self.c, &vr(clock), 1, &mut active) }, fmi3OK, "{clock}");
        assert!(active <= 1, "{clock}");
        active == 1
    }

    /// The state as bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let (c, mut state, mut size) = (self.c, null_mut(), 0);
        unsafe {
            assert_eq!(fmi3GetFMUState(c, &mut state), fmi3OK);
            assert_eq!(fmi3SerializedFMUStateSize(c, state, &mut size), fmi3OK);
            let mut bytes = vec![0; size];
            assert_eq!(fmi3SerializeFMUState(c, state, bytes.as_mut_ptr(), size), fmi3OK);
            assert_eq!(fmi3FreeFMUState(c, &mut state), fmi3OK);
            bytes
        }
    }

    /// Sets the state in these bytes, if they are accepted.
    pub fn set_bytes(&self, bytes: &[u8]) -> fmi3Status {
        let mut state = null_mut();
        unsafe {
            let status = fmi3DeserializeFMUState(self.c, bytes.as_ptr(), bytes.len(), &mut state);
            if status == fmi3OK {
                assert_eq!(fmi3SetFMUState(self.c, state), fmi3OK);
            }
            assert_eq!(state.is_null(), status != fmi3OK);
            fmi3FreeFMUState(self.c, &mut state);
            status
        }
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        unsafe { fmi3FreeInstance(self.c) }
    }
}
