//! What the binary answers in model exchange: a host's way through its functions, with one step of Euler's method.
#![allow(unsafe_code)]

use std::ffi::c_int;

use super::probe::{Instance, Probe};

/// `fmi2EventInfo` of the standard.
#[repr(C)]
#[derive(Default)]
struct EventInfo {
    new_discrete_states_needed: c_int,
    terminate: c_int,
    nominals_changed: c_int,
    values_changed: c_int,
    next_defined: c_int,
    next: f64,
}

/// Events that may follow each other at one time.
const MOST_UPDATES: usize = 1000;

type Read = unsafe extern "C" fn(Instance, *mut f64, usize) -> c_int;

impl Probe<'_> {
    /// From the end of initialization at the time `start` (s): the first event, a step of the length `step` (s), and another event.
    pub(super) fn integrate(&mut self, start: f64, step: f64) -> Result<(), String> {
        let (states, indicators) = self.continuous();
        self.update(start)?;
        let time = start + step;
        let mut y = self.vector("fmi2GetContinuousStates", states)?;
        let rates = self.vector("fmi2GetDerivatives", states)?;
        self.vector("fmi2GetEventIndicators", indicators)?;
        let nominals = self.vector("fmi2GetNominalsOfContinuousStates", states)?;
        if nominals.iter().any(|nominal| nominal.is_nan() || *nominal <= 0.0) {
            return Err("fmi2GetNominalsOfContinuousStates answers one that is not positive".to_owned());
        }
        y.iter_mut().zip(rates).for_each(|(y, rate)| *y += step * rate);
        let set_time = self.function::<unsafe extern "C" fn(Instance, f64) -> c_int>("fmi2SetTime")?;
        // SAFETY: the arguments of the standard, here and below.
        self.status("fmi2SetTime", unsafe { set_time(self.instance, time) })?;
        type Write = unsafe extern "C" fn(Instance, *const f64, usize) -> c_int;
        let set_states = self.function::<Write>("fmi2SetContinuousStates")?;
        self.status("fmi2SetContinuousStates", unsafe { set_states(self.instance, y.as_ptr(), states) })?;
        type Completed = unsafe extern "C" fn(Instance, c_int, *mut c_int, *mut c_int) -> c_int;
        let completed = self.function::<Completed>("fmi2CompletedIntegratorStep")?;
        let (mut enter, mut terminate) = (0, 0);
        let status = unsafe { completed(self.instance, 1, &mut enter, &mut terminate) };
        self.status("fmi2CompletedIntegratorStep", status)?;
        self.values(false)?;
        self.plain("fmi2EnterEventMode")?;
        self.update(time)
    }

    /// An event at `time` (s), and on to Continuous-Time Mode.
    fn update(&mut self, time: f64) -> Result<(), String> {
        let name = "fmi2NewDiscreteStates";
        let update = self.function::<unsafe extern "C" fn(Instance, *mut EventInfo) -> c_int>(name)?;
        for _ in 0..MOST_UPDATES {
            let mut info = EventInfo::default();
            self.status(name, unsafe { update(self.instance, &mut info) })?;
            if info.next_defined != 0 && (info.next.is_nan() || info.next <= time) {
                return Err(format!(
                    "{name} answers nextEventTime = {} s, which is not later than {time} s",
                    info.next
                ));
            }
            if info.new_discrete_states_needed == 0 || info.terminate != 0 {
                return self.plain("fmi2EnterContinuousTimeMode");
            }
        }
        Err(format!("{name} wants more than {MOST_UPDATES} updates at t = {time} s"))
    }

    fn vector(&mut self, name: &str, length: usize) -> Result<Vec<f64>, String> {
        let mut values = vec![0.0; length];
        let get = self.function::<Read>(name)?;
        self.status(name, unsafe { get(self.instance, values.as_mut_ptr(), length) })?;
        match values.iter().position(|value| !value.is_finite()) {
            Some(place) => Err(format!("{name} answers {} in place {place}", values[place])),
            None => Ok(values),
        }
    }
}
