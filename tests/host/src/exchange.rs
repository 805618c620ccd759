//! Model exchange: the host integrates the states by a method with fixed steps.

use std::ops::Deref;

use super::{Host, fmi2OK};
use newtons_cradle::fmi2::*;

/// Makes a step between two times (s); returns the states at its end.
pub type Method = fn(&Host, f64, f64) -> Vec<f64>;

/// The explicit Euler method, of order 1.
pub fn euler(host: &Host, from: f64, to: f64) -> Vec<f64> {
    plus(&host.states(), to - from, &host.rates())
}

/// The classical method of Runge and Kutta, of order 4.
pub fn rk4(host: &Host, from: f64, to: f64) -> Vec<f64> {
    let (h, y, k1) = (to - from, host.states(), host.rates());
    let rates = |time: f64, y: &[f64]| {
        host.place(time, y);
        host.rates()
    };
    let k2 = rates(from + 0.5 * h, &plus(&y, 0.5 * h, &k1));
    let k3 = rates(from + 0.5 * h, &plus(&y, 0.5 * h, &k2));
    let k4 = rates(to, &plus(&y, h, &k3));
    let mean = |i: usize| (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) / 6.0;
    y.iter().enumerate().map(|(i, y)| y + h * mean(i)).collect()
}

impl Host {
    /// A component for model exchange of the FMU with this many balls.
    pub fn exchanging(balls: usize) -> Self {
        Self::of_kind(fmi2ModelExchange, balls)
    }

    /// Handles the event in Event Mode, and enters Continuous-Time Mode.
    pub fn update(&self) -> fmi2EventInfo {
        let mut info = fmi2EventInfo {
            newDiscreteStatesNeeded: 1,
            terminateSimulation: 1,
            nominalsOfContinuousStatesChanged: 1,
            valuesOfContinuousStatesChanged: 1,
            nextEventTimeDefined: 1,
            nextEventTime: f64::NAN,
        };
        assert_eq!(unsafe { fmi2NewDiscreteStates(self.c, &mut info) }, fmi2OK, "{:?}", self.log());
        assert_eq!((info.newDiscreteStatesNeeded, info.terminateSimulation), (0, 0));
        assert_eq!(unsafe { fmi2EnterContinuousTimeMode(self.c) }, fmi2OK);
        info
    }

    /// Enters Event Mode from Continuous-Time Mode, handles the event, and returns.
    pub fn event(&self) -> fmi2EventInfo {
        assert_eq!(unsafe { fmi2EnterEventMode(self.c) }, fmi2OK);
        self.update()
    }

    /// Number of continuous states.
    pub fn state_count(&self) -> usize {
        3 * self.balls + 1
    }

    fn vector(
        &self,
        length: usize,
        get: unsafe extern "C" fn(fmi2Component, *mut f64, usize) -> fmi2Status,
    ) -> Vec<f64> {
        let mut values = vec![f64::NAN; length];
        assert_eq!(unsafe { get(self.c, values.as_mut_ptr(), length) }, fmi2OK, "{:?}", self.log());
        values
    }

    /// The continuous states.
    pub fn states(&self) -> Vec<f64> {
        self.vector(self.state_count(), fmi2GetContinuousStates)
    }

    /// The derivatives of the continuous states.
    pub fn rates(&self) -> Vec<f64> {
        self.vector(self.state_count(), fmi2GetDerivatives)
    }

    /// The nominal values of the continuous states.
    pub fn nominals(&self) -> Vec<f64> {
        self.vector(self.state_count(), fmi2GetNominalsOfContinuousStates)
    }

    /// The event indicators.
    pub fn indicators(&self) -> Vec<f64> {
        self.vector(2 * (self.balls - 1), fmi2GetEventIndicators)
    }

    /// Sets the time (s) and the states.
    pub fn place(&self, time: f64, states: &[f64]) {
        assert_eq!(unsafe { fmi2SetTime(self.c, time) }, fmi2OK, "{:?}", self.log());
        let status = unsafe { fmi2SetContinuousStates(self.c, states.as_ptr(), states.len()) };
        assert_eq!(status, fmi2OK, "{:?}", self.log());
    }

    /// Completes a step; returns whether the component asks for Event Mode.
    pub fn completed(&self) -> bool {
        let (mut enter, mut terminate) = (-1, -1);
        let status = unsafe { fmi2CompletedIntegratorStep(self.c, 1, &mut enter, &mut terminate) };
        assert_eq!((status, terminate), (fmi2OK, 0), "{:?}", self.log());
        enter != 0
    }
}

/// A component that is integrated in Continuous-Time Mode.
pub struct Master {
    /// The component.
    pub host: Host,
    /// The time, s.
    pub time: f64,
    /// When the next event is due, s.
    pub next: f64,
    /// Number of events so far.
    pub events: usize,
    /// The event indicators after the last event or step.
    pub indicators: Vec<f64>,
}

fn plus(y: &[f64], h: f64, rates: &[f64]) -> Vec<f64> {
    y.iter().zip(rates).map(|(y, rate)| y + h * rate).collect()
}

impl Deref for Master {
    type Target = Host;

    fn deref(&self) -> &Host {
        &self.host
    }
}

impl Master {
    /// Starts a component at t = 0.
    pub fn start(host: Host) -> Self {
        host.start();
        let info = host.update();
        let mut master = Self { host, time: 0.0, next: f64::INFINITY, events: 0, indicators: Vec::new() };
        master.after(info);
        master
    }

    fn after(&mut self, info: fmi2EventInfo) {
        self.next = if info.nextEventTimeDefined != 0 { info.nextEventTime } else { f64::INFINITY };
        assert!(self.next > self.time, "{} {}", self.next, self.time);
        self.indicators = self.host.indicators();
        self.events += 1;
    }

    /// Handles an event at the present time.
    pub fn event(&mut self) {
        self.after(self.host.event());
    }

    /// Makes a step to the time `to` (s), and handles an event at its end if one is due.
    pub fn step(&mut self, to: f64, method: Method) {
        self.host.place(to, &method(&self.host, self.time, to));
        self.time = to;
        let asked = self.host.completed();
        let indicators = self.host.indicators();
        let crossed = indicators.iter().zip(&self.indicators).any(|(now, before)| (*now > 0.0) != (*before > 0.0));
        self.indicators = indicators;
        if asked || crossed || to >= self.next {
            self.event();
        }
    }

    /// Makes steps of the length `h` (s) to the time `until` (s). A time event within a step waits until its end.
    pub fn whole_steps(&mut self, until: f64, h: f64, method: Method) {
        let (start, steps) = (self.time, ((until - self.time) / h).round() as usize);
        for k in 1..=steps {
            self.step(start + k as f64 * h, method);
        }
    }

    /// Makes steps of the length `h` (s) to the time `until` (s); a step ends early at a time event.
    pub fn steps(&mut self, until: f64, h: f64, method: Method) {
        while self.time < until {
            self.step((self.time + h).min(self.next).min(until), method);
        }
    }
}
