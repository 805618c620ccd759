//! Derivatives by finite differences, and the laws and dependencies for which exact ones are checked.

use std::collections::BTreeSet;

use newtons_cradle::variables::{Causality, Type, Variable, variables};

/// Contacts of every law.
pub const LAWS: [(&str, &str); 14] = [
    ("linear", ""),
    ("cubic", "contact.exponent=3"),
    ("not whole", "contact.exponent=2.3"),
    ("Hertz", "contact.model=hertz"),
    ("dashpot", "contact.damping=1e4"),
    ("dashpot without pull", "contact.dampingLaw=kelvinVoigtNoPull contact.damping=1e4"),
    (
        "Hunt-Crossley with drag",
        "contact.dampingLaw=huntCrossley contact.huntCrossley=0.42 contact.exponent=1.5 pendulum.drag=0.2",
    ),
    (
        "viscoelastic",
        "contact.dampingLaw=viscoelastic contact.relaxationTime=2e-7 contact.exponent=2 pendulum.drag=0.2",
    ),
    ("viscoelastic Hertz", "contact.model=hertz contact.dampingLaw=viscoelastic contact.relaxationTime=2e-6"),
    ("arcs", "pendulum.model=circular contact.exponent=1.5 pendulum.drag=0.2"),
    ("dashpots on arcs", "pendulum.model=circular contact.damping=1e4"),
    ("rigid", "contact.model=rigid"),
    ("rigid with losses", "contact.model=rigid contact.restitution=0.7 ball.massRatio[3]=1.2"),
    ("rigid on arcs", "contact.model=rigid pendulum.model=circular ball.massRatio[3]=1.2"),
];

/// The real parameters of the physics, start values and inputs: what a run may depend on.
pub fn knowns(balls: usize) -> impl Iterator<Item = Variable> {
    let real = |variable: &Variable| variable.row.settable() && variable.row.access.data_type() == Type::Real;
    variables(balls).filter(real).filter(|known| !known.row.name.starts_with("solver"))
}

/// The real outputs.
pub fn outputs(balls: usize) -> Vec<Variable> {
    let real = |variable: &Variable| variable.row.access.data_type() == Type::Real;
    variables(balls).filter(real).filter(|variable| variable.row.causality == Causality::Output).collect()
}

/// The unknowns in a part of a description of FMI 2.0, each with its dependencies in rising order; none if these may be
/// everything.
pub fn dependencies(part: &str, balls: usize) -> Vec<(Variable, Option<BTreeSet<String>>)> {
    let named = |indices: &str| -> Vec<Variable> {
        let indices: Vec<usize> = indices.split_whitespace().map(|index| index.parse().unwrap()).collect();
        assert!(indices.is_sorted_by(|a, b| a < b), "{indices:?}");
        indices.iter().map(|index| variables(balls).nth(index - 1).unwrap()).collect()
    };
    let unknown = |line: &str| {
        let pieces: Vec<&str> = line.split('"').collect();
        let on = pieces.get(3).map(|on| named(on).iter().map(Variable::to_string).collect());
        (named(pieces[1])[0], on)
    };
    part.lines().filter(|line| line.contains("<Unknown ")).map(unknown).collect()
}

/// The change of a known with this value for finite differences.
pub fn step(known: Variable, value: f64) -> f64 {
    let unit = if ["contact.gap", "contact.deadBand"].contains(&known.row.name) { 1e-3 } else { 1.0 };
    1e-5 * if value == 0.0 { unit } else { value.abs() }
}

/// Finite differences of the values `at` multiples of `h`, of sixth order or, `one_sided`, of fourth order, and their
/// change by a rounding of 1 of the values.
pub fn by_differences(h: f64, one_sided: bool, mut at: impl FnMut(f64) -> Vec<f64>) -> (Vec<f64>, f64) {
    let weights: &[(f64, f64)] = if one_sided {
        &[(0.0, -25.0 / 12.0), (1.0, 4.0), (2.0, -3.0), (3.0, 4.0 / 3.0), (4.0, -0.25)]
    } else {
        &[(1.0, 0.75), (-1.0, -0.75), (2.0, -0.15), (-2.0, 0.15), (3.0, 1.0 / 60.0), (-3.0, -1.0 / 60.0)]
    };
    let rounding: f64 = weights.iter().map(|(_, weight)| weight.abs()).sum();
    let mut sums = Vec::new();
    for (steps, weight) in weights {
        let values = at(steps * h);
        sums.resize(values.len(), 0.0);
        sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
    }
    (sums.into_iter().map(|sum| sum / h).collect(), rounding / h)
}
