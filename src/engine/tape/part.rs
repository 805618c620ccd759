//! The linear maps of the parts of a run: from changes of the state at the start of a part and of the coefficients to
//! changes of the state at its end; and transposed, from derivatives of a number by the latter to derivatives by the
//! former.

use std::fmt::Debug;

use super::coefficients::Coefficients;
use crate::model::Cradle;

/// A part of a run, linearised; it changes the state of some neighbours. The `cradle` has the coefficients that acted.
pub(crate) trait Part: Debug + Send + Sync {
    /// About how many numbers it holds.
    fn numbers(&self) -> usize;

    /// Turns changes of the state before it into changes of the state after it.
    fn forward(&self, cradle: &Cradle, changes: &Coefficients, state: &mut [f64]);

    /// Turns derivatives by the state after it into derivatives by the state before it, and adds those by the
    /// coefficients.
    fn backward(&self, cradle: &Cradle, by_changes: &mut Coefficients, by_state: &mut [f64]);
}
