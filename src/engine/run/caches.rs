//! What has been computed and could be computed again. None of it is state, except how far a look ahead has come: later
//! looks go on from there.

use std::cell::{Cell, RefCell};

use crate::engine::cluster::Cluster;
use crate::next::Next;
use crate::solver::double_double::DoubleDouble;

/// Everything that a run keeps of what it has computed for those who ask. `R` is the run, which these caches are a part
/// of.
#[derive(Debug)]
pub(crate) struct Caches<R> {
    /// A ball each: its state when it was last asked for.
    pub states: Vec<Cell<KnownState>>,
    pub ahead: LookAhead<R>,
    /// The last cluster that is over, for its memory.
    pub spare: Option<Box<Cluster>>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct KnownState {
    /// The time, s; NaN for none.
    pub time: f64,
    /// The anchor of its flight then.
    pub anchor: DoubleDouble,
    /// Position, m, and velocity, m/s.
    pub state: (f64, f64),
}

/// What has been seen of the future. It is good until the inputs change. The copy stands at most at the first onset
/// that the run has yet to come to.
#[derive(Clone, Debug)]
pub(crate) struct LookAhead<R> {
    /// A copy of the run that has gone ahead on the same trajectory.
    pub copy: RefCell<Option<Box<R>>>,
    /// What was found last, and when it was asked for, s.
    pub found: Cell<Option<(f64, Next)>>,
}

impl<R> Caches<R> {
    /// Empty ones for a run of so many balls.
    pub fn new(balls: usize) -> Self {
        let unknown = KnownState { time: f64::NAN, anchor: DoubleDouble::default(), state: (0.0, 0.0) };
        Self {
            states: vec![Cell::new(unknown); balls],
            ahead: LookAhead { copy: RefCell::default(), found: Cell::default() },
            spare: None,
        }
    }

    /// Empties all of them: other equations hold from now on.
    pub fn clear(&mut self) {
        *self = Self::new(self.states.len());
    }
}

/// A copy goes on from the same look ahead; it computes for itself what else it is asked for.
impl<R: Clone> Clone for Caches<R> {
    fn clone(&self) -> Self {
        Self { ahead: self.ahead.clone(), ..Self::new(self.states.len()) }
    }
}
