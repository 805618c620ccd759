//! What the first impact in a process would otherwise wait for.

use std::sync::atomic::{AtomicBool, Ordering};

use super::engine::Engine;
use crate::engine::observer::Unrecorded;
use crate::model::{Inputs, Parameters};

/// Whether this process has done it.
static DONE: AtomicBool = AtomicBool::new(false);

/// An exponent for each way in which time is stretched: their coefficients differ.
const EXPONENTS: [f64; 3] = [1.5, 1.7, 2.0];

/// Once in a process, has a ball strike two that touch: then the code of contacts that are not linear is in memory and its tables are
/// computed. Else the first step with such an impact would take up to 0.1 ms longer than others, which hosts with a clock do not expect.
pub(super) fn warm_up() {
    if DONE.swap(true, Ordering::Relaxed) {
        return;
    }
    let mut parameters = Parameters::default_for(3);
    (parameters.x_start, parameters.v_start, parameters.dead_band) = (vec![0.0; 3], vec![1.0, 0.0, 0.0], 0.0);
    for exponent in EXPONENTS {
        parameters.exponent = exponent;
        if let Ok(mut engine) = Engine::new(&parameters, &Inputs::zero(3), 0.0) {
            let _ = engine.advance(1e-3, &mut Unrecorded);
        }
    }
}
