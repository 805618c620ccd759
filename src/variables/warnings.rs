//! Warnings about start values that are allowed but hardly ever meant, and about start values without effect.

use super::settings::{Kind, Settings};
use super::table::TABLE;
use super::table::row::{Causality, Row};
use super::variable::Variable;
use crate::model::PendulumModel;
use crate::number::Number;

/// Largest overlap at the start without a warning, over the radius.
const OVERLAP: f64 = 1e-3;
/// Largest amplitude without a warning, over the length: a circular pendulum's period is then 0.4 % longer.
const AMPLITUDE: f64 = 0.25;

impl Settings {
    /// Warnings about start values that are allowed but hardly ever meant: the deepest overlap and the widest swing,
    /// each with the likely cure; and about parameters [without effect](Self::without_effect).
    pub fn warnings(&self, kind: Option<Kind>) -> Vec<String> {
        self.doubtful().chain(self.without_effect(kind).map(|(_, warning)| warning)).collect()
    }

    /// Rows of parameters that differ from the default but have no effect with the other parameters in an instance of
    /// this `kind`, with a warning that says what would use them. For a file, whose host may create either kind, none
    /// is given.
    pub fn without_effect(&self, kind: Option<Kind>) -> impl Iterator<Item = (&'static Row, String)> {
        let (balls, defaults) = (self.balls(), Self::default_for(self.balls()));
        TABLE.iter().enumerate().filter_map(move |(position, row)| {
            let missing = row.needs.iter().filter(|need| !(need.is_met)(&self.parameters, kind));
            let missing: Vec<&str> = missing.map(|need| need.choice).collect();
            if missing.is_empty() || row.causality != Causality::Parameter {
                return None;
            }
            let scalars = (0..row.shape.len(balls)).map(|index| Variable { row, position, index, whole: false });
            let mut changed = scalars.filter(|variable| variable.value(self) != variable.value(&defaults));
            let first = changed.next()?;
            let value = row.quantified(first.text(self)?);
            let (others, choices) = (changed.count(), missing.join(" and "));
            let more = if others > 0 { format!(" (and {others} more)") } else { String::new() };
            Some((row, format!("{first} = {value}{more} has no effect: it needs {choices}")))
        })
    }

    /// Warnings about positions and velocities.
    pub fn doubtful(&self) -> impl Iterator<Item = String> {
        let p = &self.parameters;
        let (x, v) = (&p.x_start, &p.v_start);
        let overlap = |i: usize| x[i] - x[i + 1] - p.gap[i] - p.dead_band;
        let smaller = |i: usize| p.radius_of(i).min(p.radius_of(i + 1));
        let pressed = largest(p.contacts(), |i| overlap(i) / smaller(i), OVERLAP).map(|i| {
            let (left, right, radius) = (i + 1, i + 2, Number(smaller(i)));
            let [at, next] = [x[i], x[i + 1]].map(Number);
            format!(
                "x_start[{left}] = {at} m and x_start[{right}] = {next} m press balls {left} and {right} into each \
                 other by more than a thousandth of the smaller radius, {radius} m; positions grow to the right, so that \
                 of a ball lifted to the left is negative"
            )
        });
        let length = |i: usize| p.length * p.length_ratio[i];
        let linear = p.pendulum == PendulumModel::Linear;
        let amplitude = |i: usize| match linear && p.gravity > 0.0 {
            true => x[i].hypot(v[i] * (length(i) / p.gravity).sqrt()) / length(i),
            false => 0.0,
        };
        let wide = largest(p.balls(), amplitude, AMPLITUDE).map(|i| {
            let (ball, [at, speed, length]) = (i + 1, [x[i], v[i], length(i)].map(Number));
            format!(
                "with x_start[{ball}] = {at} m and v_start[{ball}] = {speed} m/s, ball {ball} swings farther than a \
                 quarter of its pendulum, {length} m long; pendulums are linear, and real ones swing more slowly \
                 there: set pendulum.model to circular (2), lift it less, or set a larger pendulum.length"
            )
        });
        pressed.into_iter().chain(wide)
    }
}

/// Index of the (first) largest of `count` values, if it exceeds `limit`.
fn largest(count: usize, value: impl Fn(usize) -> f64, limit: f64) -> Option<usize> {
    (0..count).rev().max_by(|a, b| value(*a).total_cmp(&value(*b))).filter(|i| value(*i) > limit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{ContactModel, Parameters};

    #[test]
    fn warnings_of_a_wrong_sign_and_a_wide_swing() {
        let warnings = |change: &dyn Fn(&mut Parameters)| {
            let mut settings = Settings::default_for(5);
            change(&mut settings.parameters);
            settings.warnings(None)
        };
        assert_eq!(warnings(&|_| {}), [""; 0]);
        assert_eq!(warnings(&|p| p.x_start = vec![0.0, 0.0, 0.0, 0.0, 0.49]), [""; 0]);
        assert_eq!(warnings(&|p| p.gap[2] = -3e-5), [""; 0]);
        assert_eq!(warnings(&|p| (p.gravity, p.v_start[0]) = (0.0, 9.0)), [""; 0]);
        let [pressed] = &warnings(&|p| p.x_start = vec![0.1, 0.0, 0.0, 0.0, 0.0])[..] else {
            panic!("one is expected")
        };
        assert!(pressed.starts_with("x_start[1] = 0.1 m and x_start[2] = 0 m press balls 1 and 2 into each other"));
        assert_eq!(warnings(&|p| p.gap[2] = -4e-5).len(), 1);
        let [small] = &warnings(&|p| {
            (p.gap[2], p.radius_ratio[3], p.contact_model) = (-3e-5, 0.5, ContactModel::Hertz);
        })[..] else {
            panic!("one is expected")
        };
        assert!(
            small.contains("balls 3 and 4 into each other by more than a thousandth of the smaller radius, 0.01565")
        );
        for change in [|p: &mut Parameters| p.x_start[0] = -0.5, |p: &mut Parameters| p.v_start[0] = 1.2] {
            let [wide] = &warnings(&change)[..] else { panic!("one is expected") };
            assert!(wide.contains("ball 1 swings farther than a quarter of its pendulum, 1.962 m long"), "{wide}");
        }
        assert_eq!(warnings(&|p| p.x_start = vec![-1.0, -1.0, 0.0, 0.0, 0.0]).len(), 1);
        assert_eq!(warnings(&|p| p.x_start = vec![0.6, 0.0, 0.0, 0.0, 0.0]).len(), 2);
    }
}
