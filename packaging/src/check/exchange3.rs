//! What the binary answers in model exchange of FMI 3.0: a host's way through its functions, with one step of Euler's method.
#![allow(unsafe_code)]

use std::ffi::c_int;

use super::exchange::MOST_UPDATES;
use super::probe::{Instance, Probe};

impl Probe<'_> {
    /// From the end of initialization at the time `start` (s): the first event, a step of the length `step` (s), and another event.
    pub(super) fn integrate_arrays(&mut self, start: f64, step: f64) -> Result<(), String> {
        let states = self.count("fmi3GetNumberOfContinuousStates", "ContinuousStateDerivative")?;
        let indicators = self.count("fmi3GetNumberOfEventIndicators", "EventIndicator")?;
        self.update_discrete_states(start)?;
        let time = start + step;
        self.euler_step("fmi3GetContinuousStateDerivatives", states, indicators, time, step)?;
        type Completed = unsafe extern "C" fn(Instance, bool, *mut bool, *mut bool) -> c_int;
        let completed = self.function::<Completed>("fmi3CompletedIntegratorStep")?;
        let (mut enter, mut terminate) = (false, false);
        // SAFETY: the arguments of the standard, here and below.
        let status = unsafe { completed(self.instance, true, &mut enter, &mut terminate) };
        self.status("fmi3CompletedIntegratorStep", status)?;
        self.elements(false)?;
        self.plain("fmi3EnterEventMode")?;
        self.update_discrete_states(time)
    }

    /// How many states or indicators there are, which is what the description's entries of this `list` add up to.
    fn count(&mut self, name: &str, list: &str) -> Result<usize, String> {
        let count = self.function::<unsafe extern "C" fn(Instance, *mut usize) -> c_int>(name)?;
        let mut answer = 0;
        self.status(name, unsafe { count(self.instance, &mut answer) })?;
        let model = self.model;
        let listed = model.unknowns.iter().filter(|unknown| unknown.list == list);
        let arrays =
            listed.filter_map(|unknown| model.arrays.iter().find(|array| array.reference == unknown.reference));
        let described: usize = arrays.map(|array| model.elements(array)).sum();
        if answer == described {
            return Ok(answer);
        }
        Err(format!("{name} answers {answer}; the description has {described}"))
    }

    /// An event at `time` (s), and on to Continuous-Time Mode.
    fn update_discrete_states(&mut self, time: f64) -> Result<(), String> {
        type Update =
            unsafe extern "C" fn(Instance, *mut bool, *mut bool, *mut bool, *mut bool, *mut bool, *mut f64) -> c_int;
        let name = "fmi3UpdateDiscreteStates";
        let update = self.function::<Update>(name)?;
        for _ in 0..MOST_UPDATES {
            let (mut again, mut terminate, mut defined, mut next) = (false, false, false, 0.0);
            let (mut nominals, mut values) = (false, false);
            let status = unsafe {
                update(self.instance, &mut again, &mut terminate, &mut nominals, &mut values, &mut defined, &mut next)
            };
            self.status(name, status)?;
            if defined && !again {
                self.later(name, next, time)?;
            }
            if !again || terminate {
                return self.plain("fmi3EnterContinuousTimeMode");
            }
        }
        Err(format!("{name} wants more than {MOST_UPDATES} updates at t = {time} s"))
    }
}
