//! The Gauss-Legendre nodes, and integrals of the polynomials through values at them.

use std::sync::LazyLock;

use crate::solver::double_double::DoubleDouble;

pub const NODES: usize = 16;

/// One value per node.
pub type Nodes = [f64; NODES];

/// Number of pairs of mirrored nodes.
const PAIRS: usize = NODES / 2;
type Pairs = [f64; PAIRS];

/// The rule that all tables share.
pub static RULE: LazyLock<Rule> = LazyLock::new(Rule::new);

/// Nodes, weights and Lagrange polynomials. Aligned for instructions that load two numbers at once.
#[derive(Debug)]
#[repr(align(16))]
pub struct Rule {
    /// The nodes on [-1, 1].
    pub(super) x: [DoubleDouble; NODES],
    /// The weights of the nodes on [0, 1].
    pub(super) weights: [DoubleDouble; NODES],
    /// The weights of the pairs, and the distance of their first nodes from the middle.
    of_pairs: Pairs,
    off_middle: Pairs,
    /// The matrices `Q` and `Q Q`, in halves.
    once: Halves,
    twice: Halves,
    /// Coefficient of the Legendre polynomial k in the Lagrange polynomial of node l, at `[k][l]`.
    pub(super) lagrange: [Nodes; NODES],
    /// Coefficient of `x^k`, `x = 2 c - 1`, in the Lagrange polynomial of node l, at `[k][l]`, good for ten digits.
    pub powers: [Nodes; NODES],
}

/// Contributions of the even and the odd part of values at the nodes to integrals up to the nodes of the first half: a
/// column for the sum or difference of each pair.
type Halves = [[Pairs; PAIRS]; 2];

/// The Legendre polynomials at a place.
type Legendre = [DoubleDouble; NODES + 1];

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
            // Newton's method, from the estimate of Abramowitz and Stegun, 22.16.6.
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
        // The integral of a Legendre polynomial is half the difference of its neighbours over 2 k + 1. Those of even
        // degree are even functions.
        let integrals = |l: usize, m: usize, parity: usize| {
            let degrees = (parity..NODES).step_by(2);
            let terms = degrees.map(|k| {
                let below = if k > 0 { p[m][k - 1] } else { -one };
                (p[m][k + 1] - below) * half * p[l][k]
            });
            (weights[l] * terms.fold(zero, |sum, term| sum + term)).value()
        };
        let halves = |parity: usize| std::array::from_fn(|l| std::array::from_fn(|m| integrals(l, m, parity)));
        let once = [0, 1].map(halves);
        let lagrange =
            std::array::from_fn(|k| std::array::from_fn(|l| (number(2 * k + 1) * weights[l] * p[l][k]).value()));
        let of_pairs = std::array::from_fn(|l| weights[l].value());
        let off_middle = std::array::from_fn(|l| -0.5 * x[l].value());
        let powers = powers(&lagrange);
        let mut rule = Self { x, weights, of_pairs, off_middle, once, twice: once, lagrange, powers };
        for l in 0..PAIRS {
            for (parity, sign) in [1.0, -1.0].into_iter().enumerate() {
                let mut values = [0.0; NODES];
                (values[l], values[NODES - 1 - l]) = (0.5, 0.5 * sign);
                let twice = rule.integrate(&rule.integrate(&values));
                rule.twice[parity][l].copy_from_slice(&twice[..PAIRS]);
            }
        }
        rule
    }

    /// Integrals, from 0 to the nodes, of the polynomial with these `values` at the nodes.
    #[inline(always)]
    pub fn integrate(&self, values: &Nodes) -> Nodes {
        let [sums, differences] = parts(values);
        let (even, odd) = (combine(&self.once[0], &sums), combine(&self.once[1], &differences));
        let total = weighted(&self.of_pairs, &sums);
        mirrored(|m| [even[m] + odd[m], (total - even[m]) + odd[m]])
    }

    /// The transposed of [`Self::integrate`]: what each value adds to the sum of the integrals times `weights`.
    #[inline(always)]
    pub(super) fn integrate_back(&self, weights: &Nodes) -> Nodes {
        let [sums, differences] = parts(weights);
        let of_second: f64 = weights[PAIRS..].iter().sum();
        mirrored(|l| {
            let even = weighted(&self.once[0][l], &differences) + of_second * self.of_pairs[l];
            let odd = weighted(&self.once[1][l], &sums);
            [even + odd, even - odd]
        })
    }

    /// Double integrals, from 0 to the nodes, of the polynomial with these `values` at the nodes.
    #[inline(always)]
    pub(super) fn integrate_twice(&self, values: &Nodes) -> Nodes {
        let [sums, differences] = parts(values);
        let (even, odd) = (combine(&self.twice[0], &sums), combine(&self.twice[1], &differences));
        let total = weighted(&self.of_pairs, &sums);
        let of_odd = weighted(&self.of_pairs, &std::array::from_fn(|l| self.off_middle[l] * differences[l]));
        mirrored(|m| [even[m] + odd[m], (even[m] + total * self.off_middle[m]) + (of_odd - odd[m])])
    }

    /// Integrals from 0 to `c` of the Lagrange polynomials.
    pub fn integrals(&self, c: f64) -> Nodes {
        let x = 2.0 * c - 1.0;
        let mut integrals = [0.0; NODES];
        // By `k (k + 1) P_k = -((1 - x^2) P_k')'` the integrals keep their digits near the ends. `before` and `slope`
        // are the derivatives of the last two polynomials.
        let (mut before, mut slope) = (0.0, 1.0);
        for (k, row) in self.lagrange.iter().enumerate() {
            let integral = if k == 0 {
                c
            } else {
                let k = k as f64;
                let integral = -2.0 * c * (1.0 - c) * slope / (k * (k + 1.0));
                (before, slope) = (slope, ((2.0 * k + 1.0) * x * slope - (k + 1.0) * before) / k);
                integral
            };
            integrals.iter_mut().zip(row).for_each(|(sum, l)| *sum += integral * l);
        }
        integrals
    }
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

/// Sums and differences of the values of pairs.
#[inline(always)]
fn parts(values: &Nodes) -> [Pairs; 2] {
    let pair = |l: usize| (values[l], values[NODES - 1 - l]);
    [std::array::from_fn(|l| pair(l).0 + pair(l).1), std::array::from_fn(|l| pair(l).0 - pair(l).1)]
}

/// Values at all nodes from the two values of each pair.
#[inline(always)]
fn mirrored(pair: impl Fn(usize) -> [f64; 2]) -> Nodes {
    let mut values = [0.0; NODES];
    for m in 0..PAIRS {
        [values[m], values[NODES - 1 - m]] = pair(m);
    }
    values
}

/// `sum_l columns[l] values[l]`.
#[inline(always)]
pub fn combine<const N: usize>(columns: &[[f64; N]; N], values: &[f64; N]) -> [f64; N] {
    let mut sums = [0.0; N];
    for (column, value) in columns.iter().zip(values) {
        for (sum, c) in sums.iter_mut().zip(column) {
            *sum += value * c;
        }
    }
    sums
}

/// `sum_l weights[l] values[l]`.
#[inline(always)]
pub fn weighted<const N: usize>(weights: &[f64; N], values: &[f64; N]) -> f64 {
    let mut sums = [0.0; 4];
    let ((of_four, last), (values, others)) = (weights.as_chunks::<4>(), values.as_chunks::<4>());
    for (weights, values) in of_four.iter().zip(values) {
        for (sum, (weight, value)) in sums.iter_mut().zip(weights.iter().zip(values)) {
            *sum += value * weight;
        }
    }
    last.iter().zip(others).fold((sums[0] + sums[2]) + (sums[1] + sums[3]), |sum, (weight, value)| sum + value * weight)
}
