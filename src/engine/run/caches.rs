//! Values that could be computed again. None of it is state, except the progress of a look ahead, from which later
//! looks continue.

use std::cell::{Cell, RefCell};

use crate::engine::{Next, cluster::Cluster};
use crate::solver::DoubleDouble;

/// The time (s; NaN for none), the anchor of a ball's flight then, its position (m) and velocity (m/s).
type KnownState = (f64, DoubleDouble, (f64, f64));

/// The caches of a run `R`, of which they are a part.
#[derive(Debug)]
pub(crate) struct Caches<R> {
    /// For each ball: its state when it was last asked for.
    pub states: Vec<Cell<KnownState>>,
    /// A copy of the run that has gone ahead on the same trajectory until the inputs change, to the next onset at most.
    pub ahead: RefCell<Option<Box<R>>>,
    /// The last result of a look ahead, and the time of the request, s.
    pub found: Cell<Option<(f64, Next)>>,
    /// The last cluster that ended, whose memory is reused.
    pub spare: Option<Box<Cluster>>,
}

impl<R> Caches<R> {
    pub fn new(balls: usize) -> Self {
        let states = vec![Cell::new((f64::NAN, DoubleDouble::ZERO, (0.0, 0.0))); balls];
        Self { states, ahead: RefCell::default(), found: Cell::default(), spare: None }
    }

    /// Empties all caches, because the equations change.
    pub fn clear(&mut self) {
        *self = Self::new(self.states.len());
    }
}

/// A copy keeps the look ahead and recomputes everything else.
impl<R: Clone> Clone for Caches<R> {
    fn clone(&self) -> Self {
        Self { ahead: self.ahead.clone(), found: self.found.clone(), ..Self::new(self.states.len()) }
    }
}
