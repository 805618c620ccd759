//! Start values that balls on arcs cannot have.

use super::contact::ContactLaw;
use super::cradle::{BallModel, Cradle};
use crate::number::Number;

/// Refuses start values that balls on arcs cannot have, with the reason and what is allowed.
pub(crate) fn check_start(cradle: &Cradle, x_start: &[f64]) -> Result<(), String> {
    if !cradle.on_arcs() {
        return Ok(());
    }
    for (i, (BallModel { length, .. }, x)) in (1..).zip(cradle.balls.iter().zip(x_start)) {
        if x.abs() >= *length {
            let (x, length) = (Number(*x), Number(*length));
            let text = format_args!("x_start[{i}] = {x} m lifts its ball to 90 degrees or farther");
            let allowed = format_args!("more than -{length} m and less than {length} m");
            return Err(format!("{text}; allowed: {allowed}"));
        }
    }
    for (i, ContactLaw { pivots, clearance, .. }) in (1..).zip(&cradle.contacts) {
        if pivots.min(pivots - clearance) <= 0.0 {
            let text = "contact.gap and contact.deadBand leave no distance between the centres of balls";
            let allowed = "allowed: their radii plus contact.gap, and their radii minus contact.deadBand, above 0";
            return Err(format!("{text} {i} and {}; {allowed}", i + 1));
        }
    }
    for j in 0..cradle.contacts.len() {
        let (pair, [left, right]) = (cradle.pair(j), [j, j + 1].map(|i| x_start[i]));
        let places = [0, 1].map(|k| pair.balls[k].along_path([left, right][k], 0.0).0);
        if pair.changed_sides(places) {
            let (i, next, [left, right]) = (j + 1, j + 2, [left, right].map(Number));
            return Err(format!(
                "balls {i} and {next} have changed sides with x_start[{i}] = {left} m and x_start[{next}] = {right} m; \
                 allowed: each on its side of the other one's string"
            ));
        }
    }
    Ok(())
}
