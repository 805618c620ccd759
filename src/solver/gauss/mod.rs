//! Gauss collocation for `y'' = g(t, y, y')`, with time that may be stretched at one end of a step. See "Gauss
//! collocation" in docs/theory.md for the formulas with `phi`, `Q`, `Q1` and `Q2`.
//!
//! The nodes are symmetric about the middle. The integral of an even function is odd up to a constant, the integral of
//! an odd function even. So a product with `Q` or `Q Q` takes two matrices of half the size.
//!
//! Nodes, weights and `Q` are computed in double-double: an error in a last digit would have one sign in every step.

mod rule;

use std::sync::LazyLock;

use super::double_double::DoubleDouble;

use super::power::is_whole;
pub use rule::{NODES, Nodes, RULE, combine, weighted};

/// The exponent q of a stretching.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Power {
    Square,
    Cube,
    Fourth,
}

/// How the time runs within a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stretching {
    /// `phi = c`.
    #[default]
    None,
    /// `phi = c^q`.
    AtStart(Power),
    /// `phi = 1 - (1 - c)^q`.
    AtEnd(Power),
}

impl Stretching {
    /// All stretchings, in the order of [`Self::table`].
    const ALL: [Self; 7] = {
        let [square, cube, fourth] = Power::ALL;
        [
            Self::None,
            Self::AtStart(square),
            Self::AtStart(cube),
            Self::AtStart(fourth),
            Self::AtEnd(square),
            Self::AtEnd(cube),
            Self::AtEnd(fourth),
        ]
    };

    /// Computes all tables, once in a process, so that no step waits for them.
    pub fn compute_tables() {
        LazyLock::force(&TABLES);
    }

    /// The coefficients for this stretching.
    pub fn table(self) -> &'static Table {
        let k = match self {
            Self::None => 0,
            Self::AtStart(power) => 1 + power as usize,
            Self::AtEnd(power) => 4 + power as usize,
        };
        &TABLES[k]
    }

    /// The exponent q; 1 without stretching.
    pub fn order(self) -> usize {
        match self {
            Self::None => 1,
            Self::AtStart(power) | Self::AtEnd(power) => power.order(),
        }
    }

    /// `phi` and `phi'` at c, with `rest` = `1 - c`.
    fn at(self, c: DoubleDouble, rest: DoubleDouble) -> (DoubleDouble, DoubleDouble) {
        let one = DoubleDouble::from(1.0);
        match self {
            Self::None => (c, one),
            Self::AtStart(power) => power.of(c),
            Self::AtEnd(power) => {
                let (value, slope) = power.of(rest);
                (one - value, slope)
            }
        }
    }

    /// `phi` and `phi'` at c, with all digits of both.
    pub fn at_rounded(self, c: f64) -> (f64, f64) {
        let (phi, slope) = self.at(c.into(), DoubleDouble::from(1.0) - DoubleDouble::from(c));
        (phi.value(), slope.value())
    }

    /// `phi` at the nodes of an integral from the start to c = `end`, and the weights.
    pub fn nodes_up_to(self, end: f64) -> [Nodes; 2] {
        let rule = &RULE;
        let along = Self::None.table().times.map(|c| self.at_rounded(end * c));
        [along.map(|(phi, _)| phi), std::array::from_fn(|m| rule.weights[m].value() * end * along[m].1)]
    }

    /// The c at which `phi` is `part`.
    pub fn inverse(self, part: f64) -> f64 {
        // Rounding may put `part` slightly outside.
        let part = part.clamp(0.0, 1.0);
        match self {
            Self::None => part,
            Self::AtStart(power) => power.root(part),
            Self::AtEnd(power) => {
                // `1 - root(1 - part)` without cancellation.
                let rest = power.root(1.0 - part);
                match power {
                    Power::Square => part / (1.0 + rest),
                    Power::Cube => part / (1.0 + rest * (1.0 + rest)),
                    Power::Fourth => part / ((1.0 + rest) * (1.0 + rest * rest)),
                }
            }
        }
    }
}

impl Power {
    /// All exponents.
    pub const ALL: [Self; 3] = [Self::Square, Self::Cube, Self::Fourth];

    /// The exponent q.
    pub fn order(self) -> usize {
        match self {
            Self::Square => 2,
            Self::Cube => 3,
            Self::Fourth => 4,
        }
    }

    /// Whether functions with these powers of the time are smooth in c.
    pub fn resolves(self, mut exponents: impl Iterator<Item = f64>) -> bool {
        let q = self.order() as f64;
        exponents.all(|exponent| is_whole(q * exponent))
    }

    /// `c^q` and its derivative.
    fn of(self, c: DoubleDouble) -> (DoubleDouble, DoubleDouble) {
        match self {
            Self::Square => (c * c, c * DoubleDouble::from(2.0)),
            Self::Cube => (c * c * c, c * c * DoubleDouble::from(3.0)),
            Self::Fourth => (c * c * (c * c), c * c * c * DoubleDouble::from(4.0)),
        }
    }

    /// The c for which `c^q` is `power`.
    fn root(self, power: f64) -> f64 {
        match self {
            Self::Square => power.sqrt(),
            Self::Cube => libm::cbrt(power),
            Self::Fourth => power.sqrt().sqrt(),
        }
    }
}

/// The coefficients for one stretching. Aligned like [`RULE`].
#[derive(Debug)]
#[repr(align(16))]
pub struct Table {
    /// `phi` at the nodes.
    pub times: Nodes,
    /// `phi'` at the nodes.
    pub paces: Nodes,
    /// `Q1`, one row per node.
    pub up_to_node: [Nodes; NODES],
    /// `Q2`, one column per node.
    pub positions: [Nodes; NODES],
    stretched: bool,
    /// Weights of the integral over the whole step: for the rate at the end.
    pub of_rate: Nodes,
    /// Weights of the double integral over the whole step: for the position at the end.
    pub of_position: Nodes,
    /// Weights of the two highest Legendre coefficients of `g phi'`.
    pub tail: [Nodes; 2],
}

static TABLES: LazyLock<[Table; 7]> = LazyLock::new(|| Stretching::ALL.map(Table::new));

impl Table {
    fn new(stretching: Stretching) -> Self {
        let rule = &RULE;
        let (one, half) = (DoubleDouble::from(1.0), DoubleDouble::from(0.5));
        let along = rule.x.map(|x| stretching.at((one + x) * half, (one - x) * half));
        let (times, paces) = (along.map(|(phi, _)| phi.value()), along.map(|(_, slope)| slope.value()));
        let of_rate: [DoubleDouble; NODES] = std::array::from_fn(|l| rule.weights[l] * along[l].1);
        let column = |l: usize| {
            let mut values = [0.0; NODES];
            values[l] = paces[l];
            rule.integrate(&values)
        };
        let rates: [Nodes; NODES] = std::array::from_fn(column);
        Self {
            times,
            paces,
            up_to_node: std::array::from_fn(|m| std::array::from_fn(|l| rates[l][m])),
            // Within a step, sums of rounded products are exact enough.
            positions: rates.map(|column| rule.integrate(&std::array::from_fn(|m| paces[m] * column[m]))),
            of_rate: of_rate.map(DoubleDouble::value),
            of_position: std::array::from_fn(|l| (of_rate[l] * (one - along[l].0)).value()),
            tail: [1, 2].map(|k| std::array::from_fn(|l| rule.lagrange[NODES - k][l] * paces[l])),
            stretched: stretching != Stretching::None,
        }
    }

    /// `sum_l Q1_ml values_l` at the nodes.
    #[inline(always)]
    pub fn integrate(&self, values: &Nodes) -> Nodes {
        let mut paced = [0.0; NODES];
        for m in 0..NODES {
            paced[m] = self.paces[m] * values[m];
        }
        RULE.integrate(&paced)
    }

    /// Both `sum_l Q1_ml values_l` and `sum_l Q2_ml values_l` at the nodes.
    #[inline(always)]
    pub fn integrate_both(&self, values: &Nodes) -> [Nodes; 2] {
        let once = self.integrate(values);
        [once, self.integrate(&once)]
    }

    /// The transposed of [`Self::integrate`], `sum_m Q1_ml values_m`.
    #[inline(always)]
    pub fn integrate_back(&self, values: &Nodes) -> Nodes {
        let sums = RULE.integrate_back(values);
        std::array::from_fn(|l| self.paces[l] * sums[l])
    }

    /// `sum_l Q2_ml values_l` at the nodes.
    #[inline(always)]
    pub fn integrate_twice(&self, values: &Nodes) -> Nodes {
        if self.stretched { combine(&self.positions, values) } else { RULE.integrate_twice(values) }
    }
}
