//! The door by which a method enters the clusters: what it has to tell of a motion that it describes.

use super::window::{OverlapSeries, Window};
use crate::engine::flight::{Forcing, Rounding};
use crate::next::Next;

/// The motion of a window on a segment. Balls and contacts are counted within the window, times (s) from the start of
/// the segment. Forces are those of the law without clipping.
pub(crate) trait DenseOutput {
    /// Displacement of ball `i` (m) and the change of its velocity (m/s) till `tau`. The change: at the start, where
    /// many switchings may come at once, it must be exactly 0.
    fn moved(&self, i: usize, tau: f64) -> (f64, f64);
    /// Integral of that displacement, m.s.
    fn displacement_integral(&self, i: usize, tau: f64) -> f64;
    /// Integral of the squared velocity of ball `i`, m2/s. A method may enter the sum over a group, weighted with the
    /// masses over that of the group's first ball, at that ball.
    fn squared_velocity_integral(&self, i: usize, tau: f64) -> f64;
    /// Work per unit of mass of the acceleration `forcing` on ball `i`, m2/s2.
    fn work(&self, i: usize, forcing: &Forcing, tau: f64) -> f64;
    /// Overlap of contact `j` (m) at `tau` and the change of its rate (m/s) till then.
    fn overlap(&self, j: usize, tau: f64) -> (f64, f64);
    /// Coefficients of that overlap as a power series of the time from `tau` on; `None` if the equations tell them as
    /// well.
    fn overlap_series(&self, j: usize, tau: f64) -> Option<OverlapSeries>;
    /// Impulse of the pressing contact `j`, N.s.
    fn impulse(&self, j: usize, tau: f64) -> f64;
    /// The larger of `known` and the largest force of the pressing contact `j` between two times, N.
    fn peak(&self, j: usize, from: f64, to: f64, known: f64) -> f64;
    /// Energy that the pressing contact `j` dissipates, J. A method may enter that of a group of contacts at the first
    /// one.
    fn contact_loss(&self, j: usize, tau: f64) -> f64;

    /// The onset of the open contact `j` of the `window` described, before `until`. Balls that swing side by side
    /// approach each other by `rounding`: that is no onset.
    fn onset(&self, j: usize, window: &Window, until: f64, rounding: &Rounding) -> Next;
    /// The release of the closed contact `j`, before `until`.
    fn release(&self, j: usize, until: f64, rounding: &Rounding) -> Next;
    /// The beginning or, in mode `Clipped`, the end of the clipping of contact `j`, before `until`, by more than
    /// `rounding`.
    fn clip(&self, j: usize, window: &Window, until: f64, rounding: &Rounding) -> Next;

    /// The contact that seems to switch first: looked at first, it leaves the others less time to switch in.
    fn next_to_switch(&self) -> usize {
        0
    }

    /// Evaluations of closed forms that the searches for switchings have taken so far.
    fn searched(&self) -> u64 {
        0
    }
}
