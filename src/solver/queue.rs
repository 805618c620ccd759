//! A priority queue over a fixed set of keys: the next event of each.

use super::double_double::DoubleDouble;

/// A tournament of times: at most one entry a key; to enter, move or remove one takes O(log n).
///
/// Equal times come in the order of their keys, so that a run never depends on its history in the queue.
#[derive(Clone, Debug)]
pub struct EventQueue {
    /// Time of each key, infinite where it has no entry. There are as many as a power of two.
    time: Vec<DoubleDouble>,
    /// The tournament: the keys one by one in its second half, and in place `k` the earlier one of those in the places
    /// `2 k` and `2 k + 1`.
    earliest: Vec<u32>,
}

impl EventQueue {
    /// An empty queue for the keys `0..keys`.
    pub fn new(keys: usize) -> Self {
        let size = keys.next_power_of_two();
        let mut earliest = vec![0; size];
        earliest.extend(0..size as u32);
        (1..size).rev().for_each(|place| earliest[place] = earliest[2 * place]);
        Self { time: vec![f64::INFINITY.into(); size], earliest }
    }

    /// The earliest entry.
    pub fn first(&self) -> Option<(DoubleDouble, usize)> {
        let key = self.earliest[1] as usize;
        Some((self.time[key], key)).filter(|(time, _)| time.value() < f64::INFINITY)
    }

    /// Enters `key` at `time`, in place of its old entry if it has one. A time that is no number comes first of all, as
    /// minus infinity, so that nobody waits for it.
    pub fn set(&mut self, key: usize, time: DoubleDouble) {
        self.time[key] = if time.value().is_nan() { f64::NEG_INFINITY.into() } else { time };
        let mut place = (self.time.len() + key) / 2;
        while place > 0 {
            let (left, right) = (self.earliest[2 * place], self.earliest[2 * place + 1]);
            let earlier = if self.time[right as usize] < self.time[left as usize] { right } else { left };
            if earlier == self.earliest[place] && earlier as usize != key {
                break; // Nothing changes from here on.
            }
            self.earliest[place] = earlier;
            place /= 2;
        }
    }

    /// Takes the entry of `key` out, if there is one.
    pub fn remove(&mut self, key: usize) {
        self.set(key, f64::INFINITY.into());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The entries in their order.
    fn emptied(mut queue: EventQueue) -> impl Iterator<Item = (f64, usize)> {
        std::iter::from_fn(move || queue.first().inspect(|(_, key)| queue.remove(*key)))
            .map(|(time, key)| (time.value(), key))
    }

    #[test]
    fn no_number_hides_what_comes() {
        let mut queue = EventQueue::new(3);
        for (key, time) in [1.0, f64::NAN, 0.0].into_iter().enumerate() {
            queue.set(key, time.into());
        }
        assert_eq!(emptied(queue).map(|(_, key)| key).collect::<Vec<_>>(), [1, 2, 0]);
    }

    #[test]
    fn gives_entries_in_order_of_time_then_key() {
        let mut queue = EventQueue::new(100);
        for key in 0..100 {
            queue.set(key, ((key * 37 % 50) as f64).into());
        }
        queue.set(7, 1e3.into());
        queue.remove(11);
        queue.remove(11);
        let mut expected: Vec<_> = (0..100).filter(|&k| k != 11 && k != 7).map(|k| ((k * 37 % 50) as f64, k)).collect();
        expected.push((1e3, 7));
        expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(emptied(queue).collect::<Vec<_>>(), expected);
    }
}
