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
pub(super) const MOST_UPDATES: usize = 1000;

type Read = unsafe extern "C" fn(Instance, *mut f64, usize) -> c_int;

impl Probe<'_> {
    /// From the end of initialization at the time `start` (s): the first event, a step of the length `step` (s), and another event.
    pub(super) fn integrate(&mut self, start: f64, step: f64) -> Result<(), String> {
        let (states, indicators) = self.continuous();
        self.update(start)?;
        let time = start + step;
        self.euler_step("fmi2GetDerivatives", states, indicators, time, step)?;
        type Completed = unsafe extern "C" fn(Instance, c_int, *mut c_int, *mut c_int) -> c_int;
        let completed = self.function::<Completed>("fmi2CompletedIntegratorStep")?;
        let (mut enter, mut terminate) = (0, 0);
        // SAFETY: the arguments of the standard, here and below.
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
            if info.next_defined != 0 {
                self.later(name, info.next, time)?;
            }
            if info.new_discrete_states_needed == 0 || info.terminate != 0 {
                return self.plain("fmi2EnterContinuousTimeMode");
            }
        }
        Err(format!("{name} wants more than {MOST_UPDATES} updates at t = {time} s"))
    }

    /// All that is read before a step of Euler's method, and the step of the length `step` (s) to `time` (s). The functions have the
    /// same arguments in both versions, and the same names but for that of the `derivatives`.
    pub(super) fn euler_step(
        &mut self,
        derivatives: &str,
        states: usize,
        indicators: usize,
        time: f64,
        step: f64,
    ) -> Result<(), String> {
        let version = &derivatives[..4];
        let name = |function: &str| format!("{version}{function}");
        let mut y = self.vector(&name("GetContinuousStates"), states)?;
        let rates = self.vector(derivatives, states)?;
        self.vector(&name("GetEventIndicators"), indicators)?;
        let of_nominals = name("GetNominalsOfContinuousStates");
        let nominals = self.vector(&of_nominals, states)?;
        if nominals.iter().any(|nominal| *nominal <= 0.0) {
            return Err(format!("{of_nominals} answers one that is not positive"));
        }
        y.iter_mut().zip(rates).for_each(|(y, rate)| *y += step * rate);
        let of_time = name("SetTime");
        let set_time = self.function::<unsafe extern "C" fn(Instance, f64) -> c_int>(&of_time)?;
        // SAFETY: the arguments of the standard, here and below.
        self.status(&of_time, unsafe { set_time(self.instance, time) })?;
        type Write = unsafe extern "C" fn(Instance, *const f64, usize) -> c_int;
        let of_states = name("SetContinuousStates");
        let set_states = self.function::<Write>(&of_states)?;
        self.status(&of_states, unsafe { set_states(self.instance, y.as_ptr(), states) })
    }

    /// Nothing wrong with an answer about the next event, if it is later than `time` (s).
    pub(super) fn later(&self, function: &str, next: f64, time: f64) -> Result<(), String> {
        if next > time {
            return Ok(());
        }
        Err(format!("{function} answers nextEventTime = {next} s, which is not later than {time} s"))
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
