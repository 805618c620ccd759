//! An instance of FMI 3.0 and its host, which is called within steps.

use std::cell::RefCell;
use std::ffi::{CString, c_void};
use std::ptr::{null, null_mut};

use arbitrary::Arbitrary;
use newtons_cradle::fmi3::fmi3Status::fmi3OK;
use newtons_cradle::fmi3::*;
use newtons_cradle::variables::{Array, Description, Settings};

/// What the host does within a step.
#[derive(Clone, Debug, Default, Arbitrary)]
pub struct Within {
    pub force: Option<u8>,
    pub end_after: Option<u8>,
    pub asks: bool,
}

/// What the host's environment points to.
#[derive(Default)]
struct Environment {
    c: usize,
    balls: usize,
    within: Within,
    calls: u8,
    /// s.
    last: f64,
}

/// An instance of five balls, and what its host does when it is called.
pub struct Host {
    pub c: fmi3Instance,
    environment: Box<RefCell<Environment>>,
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
    let mut environment = unsafe { &*environment.cast::<RefCell<Environment>>() }.borrow_mut();
    assert!((may_set, may_get) == (1, 1) && time >= environment.last);
    (environment.last, environment.calls) = (time, environment.calls.saturating_add(1));
    let (c, n) = (environment.c as fmi3Instance, environment.balls);
    let mut values = vec![f64::NAN; n];
    let [x, force] = ["x", "F_ext"].map(|name| Array::named(name).unwrap().reference());
    assert_eq!(unsafe { fmi3GetFloat64(c, &x, 1, values.as_mut_ptr(), n) }, fmi3OK);
    assert!(values.iter().all(|x| x.is_finite()));
    if let Some(size) = environment.within.force {
        let forces = vec![f64::from(size) / 128.0 - 1.0; n];
        assert_eq!(unsafe { fmi3SetFloat64(c, &force, 1, forces.as_ptr(), n) }, fmi3OK);
    }
    let ends = environment.within.end_after.is_some_and(|calls| environment.calls > calls);
    unsafe {
        *requested = (ends && (may_end == 1 || environment.within.asks)).into();
        *end = time + f64::from(environment.calls) * 1e-6;
    }
}

fn token() -> CString {
    CString::new(Description::fmi3(&Settings::default_for(5)).guid()).unwrap()
}

impl Host {
    /// With event mode or not, with early return or not.
    pub fn new(events: bool, early: bool) -> Self {
        let environment: Box<RefCell<Environment>> = Box::default();
        let token = token();
        let pointer = (&raw const *environment).cast_mut().cast();
        let c = unsafe {
            fmi3InstantiateCoSimulation(
                c"fuzz".as_ptr(),
                token.as_ptr(),
                null(),
                0,
                0,
                events.into(),
                early.into(),
                null(),
                0,
                pointer,
                None,
                Some(within),
            )
        };
        assert!(!c.is_null());
        Self { c, environment }
    }

    /// For model exchange.
    pub fn exchanging() -> Self {
        let token = token();
        let c =
            unsafe { fmi3InstantiateModelExchange(c"fuzz".as_ptr(), token.as_ptr(), null(), 0, 0, null_mut(), None) };
        assert!(!c.is_null());
        Self { c, environment: Box::default() }
    }

    /// What it does within the next step, from `time` (s) on, in a cradle of so many balls.
    pub fn prepare(&self, within: &Within, balls: usize, time: f64) {
        let c = self.c as usize;
        *self.environment.borrow_mut() = Environment { c, balls, within: within.clone(), calls: 0, last: time };
    }

    /// The state as bytes.
    pub fn bytes(&self) -> Vec<u8> {
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
}
