//! The last pulses as text: `log.pulses`.

use std::collections::VecDeque;
use std::fmt::Write;

use serde::{Deserialize, Serialize};

use crate::engine::Pulse;
use crate::variables::MAX_LOG;

const HEADER: &str = "contact,onset,release,peak,impulse\n";
/// Most bytes of a line: five digits, four numbers of up to 24 bytes, separators.
const LINE: usize = 5 + 4 * 24 + 5;
const KEPT: usize = (MAX_LOG - HEADER.len()) / LINE;

/// The last pulses, in the order in which they ended.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Pulses(VecDeque<Pulse>);

impl Pulses {
    pub fn enter(&mut self, pulse: Pulse) {
        if self.0.len() == KEPT {
            self.0.pop_front();
        }
        self.0.push_back(pulse);
    }

    /// CSV with the units of the variables; contacts are counted from 1, and numbers read back as the same doubles.
    pub fn csv(&self) -> String {
        let mut text = HEADER.to_owned();
        for Pulse { contact, onset, release, peak, impulse } in &self.0 {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{},{onset:e},{release:e},{peak:e},{impulse:e}", contact + 1);
        }
        text
    }

    pub fn are_sound(&self, contacts: usize) -> bool {
        self.0.len() <= KEPT && self.0.iter().all(|pulse| pulse.is_sound(contacts))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_is_bounded_and_has_the_last_pulses() {
        let mut pulses = Pulses::default();
        let value = -1.234_567_890_123_456_7e-300;
        for contact in 0..10_000 {
            pulses.enter(Pulse { contact, onset: value, release: value, peak: value, impulse: value });
        }
        let csv = pulses.csv();
        assert!(csv.len() <= MAX_LOG && csv.starts_with(HEADER) && csv.lines().count() == KEPT + 1);
        let last = csv.lines().last().unwrap();
        assert!(last.starts_with("10000,") && last.len() < LINE);
        assert_eq!(last.rsplit(',').next().unwrap().parse::<f64>().unwrap(), value);
        assert!(pulses.are_sound(10_000) && !pulses.are_sound(9_999));
    }
}
