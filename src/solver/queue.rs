//! A priority queue over a fixed set of keys: the next event of each.

use super::double_double::DoubleDouble;

/// A tournament of times with at most one entry per key; entering, moving or removing one takes O(log n).
///
/// Equal times come in the order of their keys, so the order does not depend on the history of the queue.
#[derive(Clone, Debug, Default)]
pub struct EventQueue {
    /// Time of each key, infinite without an entry; their number is a power of two.
    time: Vec<DoubleDouble>,
    /// The tournament: the keys in its second half, and at place `k` the earlier one of the places `2 k` and `2 k + 1`.
    earliest: Vec<u32>,
}

impl EventQueue {
    pub fn new(keys: usize) -> Self {
        let size = keys.next_power_of_two();
        let mut earliest = vec![0; size];
        earliest.extend(0..size as u32);
        (1..size).rev().for_each(|place| earliest[place] = earliest[2 * place]);
        Self { time: vec![f64::INFINITY.into(); size], earliest }
    }

    pub fn first(&self) -> Option<(DoubleDouble, usize)> {
        let key = self.earliest[1] as usize;
        Some((self.time[key], key)).filter(|(time, _)| time.value() < f64::INFINITY)
    }

    /// Enters `key` at `time`, in place of its old entry if any. NaN becomes minus infinity: it comes first and is
    /// noticed.
    pub fn set(&mut self, key: usize, time: DoubleDouble) {
        self.time[key] = if time.value().is_nan() { f64::NEG_INFINITY.into() } else { time };
        let (mut place, mut earlier) = (self.time.len() + key, (self.time[key], key as u32));
        while place > 1 {
            let beside = self.earliest[place ^ 1];
            let other = (self.time[beside as usize], beside);
            if other < earlier {
                earlier = other;
            }
            place /= 2;
            if self.earliest[place] == earlier.1 && earlier.1 as usize != key {
                break; // Nothing changes from here on.
            }
            self.earliest[place] = earlier.1;
        }
    }

    pub fn remove(&mut self, key: usize) {
        self.set(key, f64::INFINITY.into());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn queue_has_nan_first_and_ties_by_key() {
        let mut queue = EventQueue::new(5);
        (0..5).for_each(|key| queue.set(key, [1.0, f64::NAN, 0.0, 1.0, 0.0][key].into()));
        let keys = std::iter::from_fn(|| queue.first().map(|(_, key)| key).inspect(|key| queue.remove(*key)));
        assert_eq!(keys.collect::<Vec<_>>(), [1, 2, 4, 0, 3]);
    }
}
