//! How time passes: steps, what a host does within them, and events.

use cradle_host::fmi3::vr;
use newtons_cradle::fmi3::fmi3Status::{fmi3Discard, fmi3OK};
use newtons_cradle::fmi3::*;

use crate::Driver;
use crate::hybrid::{Operation, Within};
use crate::values::{Current, LONGEST_STEP, Step, clock_tolerance};

/// With extreme values, how many times as long as to the next onset a step may be.
const FEW_ONSETS: f64 = 3.0;

/// The longest step (s) with extreme values where the next onset is not known.
const SHORT_STEP: f64 = 1e-9;

impl Driver<'_> {
    /// Event Mode has been entered: in co-simulation an event within the tolerance of the host's clock has been
    /// handled.
    pub fn reach_event(&mut self) {
        let own = &mut self.picture.time;
        if self.picture.exchange {
            self.picture.event = *own;
        } else {
            let mut reached = f64::NAN;
            assert_eq!(unsafe { fmi3GetFloat64(self.host.c, &vr("time"), 1, &mut reached, 1) }, fmi3OK);
            assert!((*own..=*own + clock_tolerance(*own)).contains(&reached), "{reached} at {own}");
            *own = reached;
        }
    }

    /// fmi3UpdateDiscreteStates: whether there is more at once.
    pub fn update(&mut self) -> bool {
        let (status, again, _, next) = self.host.update();
        if self.take(&Operation::Update, true, status)
            && let Some(next) = next
        {
            assert!(!again && next > self.picture.time, "{next} after {:?}", self.picture);
        }
        again
    }

    pub fn step(&mut self, operation: &Operation, current: &Current, step: &Step, within: &Within) {
        let own = self.picture.time;
        let (current, length) = (current.time(own), self.length(operation, step));
        self.prepare(within.clone());
        let (status, events, reached) = self.host.step(current, length);
        let near = (current - own).abs() <= clock_tolerance(own);
        let legal = near && length > 0.0 && (current + length).is_finite();
        if self.take(operation, legal, status) {
            let end = own.max(current + length);
            assert!(reached >= own && reached <= end, "{reached} from {own} to {end}");
            assert!(self.early || reached == end, "{operation:?}: early return without leave");
            assert!(self.picture.events || !events, "an event without event mode");
            self.picture.time = reached;
        }
    }

    /// What the host does when it is called within the next step.
    fn prepare(&self, within: Within) {
        let (n, extreme, mut last, mut calls) = (self.picture.balls, self.picture.extreme, self.picture.time, 0_u8);
        self.host.within(move |c, time, may_end| {
            assert!(time >= last);
            (last, calls) = (time, calls.saturating_add(1));
            let mut x = vec![f64::NAN; n];
            let status = unsafe { fmi3GetFloat64(c, &vr("x"), 1, x.as_mut_ptr(), n) };
            assert!(status == fmi3OK && x.iter().all(|x| x.is_finite()) || extreme && status == fmi3Discard);
            if let Some(size) = within.force {
                let forces = vec![f64::from(size) / 128.0 - 1.0; n];
                assert_eq!(unsafe { fmi3SetFloat64(c, &vr("F_ext"), 1, forces.as_ptr(), n) }, fmi3OK);
            }
            within.end_after.is_some_and(|after| calls > after) && (may_end || within.asks)
        });
    }

    /// How long it is to the next onset, s, where this call is legal and that is known.
    fn ahead(&self, operation: &Operation) -> Option<f64> {
        let next = self.picture.allows(operation).then(|| self.floats("t_next")).flatten()?;
        Some(next[0] - self.picture.time)
    }

    /// The length of a step, s. With extreme values, one of more than a few times the time to the next onset might take
    /// days.
    pub fn length(&self, operation: &Operation, step: &Step) -> f64 {
        let ahead = self.ahead(operation);
        let length = step.length(ahead.unwrap_or_default(), LONGEST_STEP);
        let longest = ahead.map_or(SHORT_STEP, |ahead| FEW_ONSETS * ahead);
        if self.picture.extreme { length.min(longest) } else { length }
    }
}
