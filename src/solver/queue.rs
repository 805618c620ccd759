//! A priority queue over a fixed set of keys: the next event of each.

use super::double_double::DoubleDouble;

/// Binary heap of times, indexed by key: at most one entry a key; insert, move and remove in O(log n).
///
/// Equal times come in the order of their keys, so that a run never depends on its history in the heap.
#[derive(Clone, Debug)]
pub struct EventQueue {
    /// Keys in heap order.
    heap: Vec<u32>,
    /// Place of each key in `heap`, or `ABSENT`.
    place: Vec<u32>,
    /// Time of each key, meaningful where it is present.
    time: Vec<DoubleDouble>,
}

const ABSENT: u32 = u32::MAX;

impl EventQueue {
    /// An empty queue for the keys `0..keys`.
    pub fn new(keys: usize) -> Self {
        Self { heap: Vec::with_capacity(keys), place: vec![ABSENT; keys], time: vec![DoubleDouble::default(); keys] }
    }

    /// The earliest entry.
    pub fn first(&self) -> Option<(DoubleDouble, usize)> {
        self.heap.first().map(|&key| (self.time[key as usize], key as usize))
    }

    /// Enters `key` at `time`, in place of its old entry if it has one. A time that is no number comes first of all, as
    /// minus infinity, so that nobody waits for it.
    pub fn set(&mut self, key: usize, time: DoubleDouble) {
        self.time[key] = if time.value().is_nan() { f64::NEG_INFINITY.into() } else { time };
        if self.place[key] == ABSENT {
            self.place[key] = self.heap.len() as u32;
            self.heap.push(key as u32);
        }
        let place = self.sift_up(self.place[key] as usize);
        self.sift_down(place);
    }

    /// Takes the entry of `key` out, if there is one.
    pub fn remove(&mut self, key: usize) {
        let place = self.place[key];
        if place == ABSENT {
            return;
        }
        let place = place as usize;
        self.place[key] = ABSENT;
        let Some(last) = self.heap.pop() else { return };
        if place < self.heap.len() {
            self.heap[place] = last;
            self.place[last as usize] = place as u32;
            let place = self.sift_up(place);
            self.sift_down(place);
        }
    }

    fn before(&self, a: u32, b: u32) -> bool {
        let (ta, tb) = (self.time[a as usize], self.time[b as usize]);
        ta < tb || (ta == tb && a < b)
    }

    fn swap(&mut self, a: usize, b: usize) {
        self.heap.swap(a, b);
        self.place[self.heap[a] as usize] = a as u32;
        self.place[self.heap[b] as usize] = b as u32;
    }

    fn sift_up(&mut self, mut at: usize) -> usize {
        while at > 0 {
            let parent = (at - 1) / 2;
            if !self.before(self.heap[at], self.heap[parent]) {
                break;
            }
            self.swap(at, parent);
            at = parent;
        }
        at
    }

    fn sift_down(&mut self, mut at: usize) {
        loop {
            let mut least = at;
            for child in [2 * at + 1, 2 * at + 2] {
                if child < self.heap.len() && self.before(self.heap[child], self.heap[least]) {
                    least = child;
                }
            }
            if least == at {
                break;
            }
            self.swap(at, least);
            at = least;
        }
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
