//! Gauss collocation for `y'' = g(t, y, y')`, solved by Picard's iteration, with time that may be stretched at one end of a step.
//!
//! On a step of length h the time is `t = h phi(c)` for c in [0, 1]. The acceleration times `phi'` is interpolated at the nodes of
//! Gauss and Legendre; with the integrals `Q` of the Lagrange polynomials from 0 to the nodes and `Q1 = Q diag(phi')`, `Q2 = Q1 Q1`,
//!
//! ```text
//! rate_m     = rate_0 + h sum_l Q1_ml g_l,
//! position_m = position_0 + rate_0 h phi_m + h^2 sum_l Q2_ml g_l
//! ```
//!
//! (Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I, 1993, section II.7). At the end of the step the method has
//! twice the order that it has within. Where g has a branch point at an end of the step, such as the square root of an overlap, the
//! stretching `c^q` or `1 - (1 - c)^q` makes it smooth as a function of c.
//!
//! The nodes, the weights and `Q` are computed in double-double: an error in the last digit of a weight would act in the same
//! direction in every step.

use std::sync::LazyLock;

use super::double_double::DoubleDouble;

/// Number of nodes.
pub const NODES: usize = 16;

/// One value a node.
pub type Nodes = [f64; NODES];

/// How the time runs within a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stretching {
    /// `phi = c`.
    #[default]
    None,
    /// `phi = c^q`.
    AtStart(u8),
    /// `phi = 1 - (1 - c)^2`.
    AtEnd,
}

impl Stretching {
    /// The coefficients for this stretching; q is 2 or 4.
    pub fn table(self) -> &'static Table {
        match self {
            Self::None => &PLAIN,
            Self::AtStart(2) => &START[0],
            Self::AtStart(_) => &START[1],
            Self::AtEnd => &END,
        }
    }

    /// `phi` and `phi'` at c, `1 - c` being `rest`.
    fn at(self, c: DoubleDouble, rest: DoubleDouble) -> (DoubleDouble, DoubleDouble) {
        let one = DoubleDouble::from(1.0);
        let power = |base: DoubleDouble, q: u8| (1..q).fold(one, |power, _| power * base);
        let slope = |lower: DoubleDouble, q: u8| lower * DoubleDouble::from(f64::from(q));
        match self {
            Self::None => (c, one),
            Self::AtStart(q) => (power(c, q) * c, slope(power(c, q), q)),
            Self::AtEnd => (one - rest * rest, slope(rest, 2)),
        }
    }

    /// `phi` at c.
    pub fn part(self, c: f64) -> f64 {
        self.at(c.into(), (1.0 - c).into()).0.value()
    }

    /// The c at which `phi` is `part`.
    pub fn inverse(self, part: f64) -> f64 {
        // Rounding may ask beyond the ends.
        let part = part.clamp(0.0, 1.0);
        let root = |part: f64, q: u8| if q == 2 { part.sqrt() } else { part.sqrt().sqrt() };
        match self {
            Self::None => part,
            Self::AtStart(q) => root(part, q),
            Self::AtEnd => 1.0 - root(1.0 - part, 2),
        }
    }
}

/// The coefficients for one stretching.
#[derive(Debug)]
pub struct Table {
    /// `phi` at the nodes.
    pub times: Nodes,
    /// `phi'` there.
    pub paces: Nodes,
    /// `Q1`, a column a node.
    pub rates: [Nodes; NODES],
    /// `Q2`, a column a node.
    pub positions: [Nodes; NODES],
    /// Weights of the integral over the whole step: of the rate at the end.
    pub of_rate: Nodes,
    /// Weights of the double integral: of the position at the end.
    pub of_position: Nodes,
    /// The two highest coefficients of `g phi'` in the Legendre polynomials.
    pub tail: [Nodes; 2],
}

static PLAIN: LazyLock<Table> = LazyLock::new(|| Table::new(Stretching::None));
static START: [LazyLock<Table>; 2] =
    [LazyLock::new(|| Table::new(Stretching::AtStart(2))), LazyLock::new(|| Table::new(Stretching::AtStart(4)))];
static END: LazyLock<Table> = LazyLock::new(|| Table::new(Stretching::AtEnd));

/// What all tables share.
static RULE: LazyLock<Rule> = LazyLock::new(Rule::new);

/// Nodes, weights and Lagrange polynomials.
#[derive(Debug)]
pub struct Rule {
    /// The nodes on [-1, 1].
    x: [DoubleDouble; NODES],
    /// The weights of the nodes on [0, 1].
    weights: [DoubleDouble; NODES],
    /// `Q`: the integral from 0 to node m of the Lagrange polynomial of node l, at `[m][l]`.
    integrals: [[DoubleDouble; NODES]; NODES],
    /// Coefficient of the Legendre polynomial k in the Lagrange polynomial of node l, at `[k][l]`.
    lagrange: [Nodes; NODES],
    /// Coefficient of `x^k`, `x = 2 c - 1`, in the Lagrange polynomial of node l, at `[k][l]`: large ones, which leave ten digits.
    pub powers: [Nodes; NODES],
}

/// The Legendre polynomials at a place.
type Legendre = [DoubleDouble; NODES + 1];

/// `1 / a`.
fn inverse(a: DoubleDouble) -> DoubleDouble {
    let rough = DoubleDouble::from(1.0 / a.value());
    rough + rough * (DoubleDouble::from(1.0) - rough * a)
}

/// The Legendre polynomials of degree 0 to [`NODES`] at x, with the `ratios` `k / (k + 1)`.
fn legendre(x: DoubleDouble, ratios: &[DoubleDouble; NODES]) -> Legendre {
    let mut p = [DoubleDouble::from(1.0); NODES + 1];
    p[1] = x;
    for k in 1..NODES {
        let product = x * p[k];
        p[k + 1] = product + ratios[k] * (product - p[k - 1]);
    }
    p
}

impl Rule {
    fn new() -> Self {
        let (zero, one, half) = (DoubleDouble::ZERO, DoubleDouble::from(1.0), DoubleDouble::from(0.5));
        let number = |k: usize| DoubleDouble::from(k as f64);
        let ratios = std::array::from_fn(|k| number(k) * inverse(number(k + 1)));
        let (mut x, mut weights, mut p) = ([zero; NODES], [zero; NODES], [[zero; NODES + 1]; NODES]);
        for l in 0..NODES / 2 {
            // Newton's method, from a start that is within the last one's reach (Abramowitz and Stegun, 22.16.6).
            let start = -libm::cos(std::f64::consts::PI * (l as f64 + 0.75) / (NODES as f64 + 0.5));
            let slope = |node: DoubleDouble, p: &Legendre| {
                number(NODES) * (p[NODES - 1] - node * p[NODES]) * inverse(one - node * node)
            };
            let mut node = DoubleDouble::from(start);
            let mut at_node = legendre(node, &ratios);
            for _ in 0..4 {
                node = node - at_node[NODES] * inverse(slope(node, &at_node));
                at_node = legendre(node, &ratios);
            }
            let slope = slope(node, &at_node);
            let weight = inverse((one - node * node) * slope * slope);
            // Its mirror image is a node, too.
            let mirrored = NODES - 1 - l;
            (x[l], x[mirrored]) = (node, -node);
            (weights[l], weights[mirrored]) = (weight, weight);
            p[mirrored] = std::array::from_fn(|k| if k % 2 == 0 { at_node[k] } else { -at_node[k] });
            p[l] = at_node;
        }
        // The integral of a Legendre polynomial is half the difference of its neighbours, over 2 k + 1.
        let integrals = std::array::from_fn(|m| {
            let differences: [_; NODES] = std::array::from_fn(|k| match k {
                0 => (one + x[m]) * half,
                _ => (p[m][k + 1] - p[m][k - 1]) * half,
            });
            std::array::from_fn(|l| weights[l] * dot(&differences, &p[l]))
        });
        let lagrange =
            std::array::from_fn(|k| std::array::from_fn(|l| (number(2 * k + 1) * weights[l] * p[l][k]).value()));
        Self { x, weights, integrals, powers: powers(&lagrange), lagrange }
    }

    /// The only instance that is needed.
    pub fn get() -> &'static Self {
        &RULE
    }

    /// Integrals from 0 to `c` of the Lagrange polynomials.
    pub fn integrals(&self, c: f64) -> Nodes {
        let x = 2.0 * c - 1.0;
        let mut integrals = [0.0; NODES];
        let (mut before, mut p) = (1.0, x);
        for (k, row) in self.lagrange.iter().enumerate() {
            let integral = if k == 0 {
                c
            } else {
                let k = k as f64;
                let next = ((2.0 * k + 1.0) * x * p - k * before) / (k + 1.0);
                let integral = 0.5 * (next - before) / (2.0 * k + 1.0);
                (before, p) = (p, next);
                integral
            };
            integrals.iter_mut().zip(row).for_each(|(sum, l)| *sum += integral * l);
        }
        integrals
    }
}

fn dot(a: &[DoubleDouble], b: &[DoubleDouble]) -> DoubleDouble {
    a.iter().zip(b).fold(DoubleDouble::ZERO, |sum, (a, b)| sum + *a * *b)
}

/// The Lagrange polynomials in powers of x, from those in Legendre polynomials.
fn powers(lagrange: &[Nodes; NODES]) -> [Nodes; NODES] {
    let mut powers = [[0.0; NODES]; NODES];
    // Coefficients of the Legendre polynomials, by their recursion.
    let (mut before, mut p) = ([0.0; NODES], [0.0; NODES]);
    p[0] = 1.0;
    for (k, row) in lagrange.iter().enumerate() {
        for (power, coefficient) in powers.iter_mut().zip(p) {
            power.iter_mut().zip(row).for_each(|(power, l)| *power += coefficient * l);
        }
        let (factor, of_before) = ((2 * k + 1) as f64, k as f64);
        let mut next = [0.0; NODES];
        for i in 0..NODES {
            let raised = if i > 0 { p[i - 1] } else { 0.0 };
            next[i] = (factor * raised - of_before * before[i]) / (k + 1) as f64;
        }
        (before, p) = (p, next);
    }
    powers
}

impl Table {
    fn new(stretching: Stretching) -> Self {
        let rule = Rule::get();
        let (one, half) = (DoubleDouble::from(1.0), DoubleDouble::from(0.5));
        let along = rule.x.map(|x| stretching.at((one + x) * half, (one - x) * half));
        let (times, paces) = (along.map(|(phi, _)| phi.value()), along.map(|(_, slope)| slope.value()));
        let rates: [Nodes; NODES] =
            std::array::from_fn(|l| std::array::from_fn(|m| (rule.integrals[m][l] * along[l].1).value()));
        let of_rate: [DoubleDouble; NODES] = std::array::from_fn(|l| rule.weights[l] * along[l].1);
        Self {
            times,
            paces,
            // Within a step, sums of rounded products are exact enough.
            positions: rates.map(|column| combine(&rates, &column)),
            rates,
            of_rate: of_rate.map(DoubleDouble::value),
            of_position: std::array::from_fn(|l| (of_rate[l] * (one - along[l].0)).value()),
            tail: [1, 2].map(|k| std::array::from_fn(|l| rule.lagrange[NODES - k][l] * paces[l])),
        }
    }
}

/// `sum_l columns[l] values[l]`.
#[inline]
pub fn combine(columns: &[Nodes; NODES], values: &Nodes) -> Nodes {
    let mut sums = [0.0; NODES];
    for (column, value) in columns.iter().zip(values) {
        for (sum, c) in sums.iter_mut().zip(column) {
            *sum += c * value;
        }
    }
    sums
}

/// `sum_l weights[l] values[l]`.
#[inline]
pub fn weighted(weights: &Nodes, values: &Nodes) -> f64 {
    let mut sums = [0.0; 4];
    for (weights, values) in weights.chunks_exact(4).zip(values.chunks_exact(4)) {
        for (sum, (weight, value)) in sums.iter_mut().zip(weights.iter().zip(values)) {
            *sum += weight * value;
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Stretching; 4] = [Stretching::None, Stretching::AtStart(2), Stretching::AtStart(4), Stretching::AtEnd];

    /// A force that grows with a power of the time since the start of the step, or falls with one till its end.
    fn force(stretching: Stretching, power: f64) -> (Nodes, f64, f64) {
        let table = stretching.table();
        let at_end = stretching == Stretching::AtEnd;
        let values = table.times.map(|t| libm::pow(if at_end { 1.0 - t } else { t }, power));
        let once = 1.0 / (power + 1.0);
        let twice = if at_end { 1.0 / (power + 2.0) } else { once / (power + 2.0) };
        (values, once, twice)
    }

    #[test]
    fn integrates_what_the_stretching_makes_smooth() {
        for stretching in ALL {
            let powers: &[f64] =
                if stretching == Stretching::None { &[0.0, 1.0, 9.0, 28.0] } else { &[0.0, 1.0, 1.5, 2.5] };
            for &power in powers {
                let (values, once, twice) = force(stretching, power);
                let table = stretching.table();
                let (rate, position) = (weighted(&table.of_rate, &values), weighted(&table.of_position, &values));
                assert!((rate - once).abs() < 2e-16, "{stretching:?}, {power}: {rate}");
                assert!((position - twice).abs() < 2e-16, "{stretching:?}, {power}: {position}");
            }
        }
    }

    #[test]
    fn positions_and_rates_at_the_nodes() {
        for stretching in ALL {
            let table = stretching.table();
            let (rates, positions) = (combine(&table.rates, &table.times), combine(&table.positions, &table.times));
            for (m, t) in table.times.iter().enumerate() {
                assert!((rates[m] - t * t / 2.0).abs() < 2e-16, "{stretching:?}, node {m}");
                assert!((positions[m] - t * t * t / 6.0).abs() < 2e-16, "{stretching:?}, node {m}");
            }
        }
    }

    #[test]
    fn integrals_up_to_any_time() {
        for stretching in ALL {
            let table = stretching.table();
            let values: Nodes = std::array::from_fn(|m| table.times[m] * table.times[m] * table.paces[m]);
            for part in [0.0, 1e-3, 0.4, 0.99, 1.0] {
                let integral = weighted(&Rule::get().integrals(stretching.inverse(part)), &values);
                assert!((integral - part * part * part / 3.0).abs() < 1e-15, "{stretching:?}, {part}: {integral}");
            }
        }
    }

    #[test]
    fn a_polynomial_in_powers() {
        let values = Stretching::None.table().times.map(|c| 1.0 - c * c * c);
        let coefficients = Rule::get().powers.map(|row| weighted(&row, &values));
        for c in [0.0, 0.1, 0.5, 1.0] {
            let value = crate::solver::series::value(&coefficients, 2.0 * c - 1.0);
            assert!((value - (1.0 - c * c * c)).abs() < 1e-10, "{value} at {c}");
        }
    }
}
