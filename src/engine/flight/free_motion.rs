//! The motion of a ball that touches nothing, in closed form from its state at its anchor and the inputs.

use serde::{Deserialize, Serialize};

use crate::solver::{BASIS, DoubleDouble, MAX_FORCE_ORDER, Oscillator, Steady, all_finite, hypotenuse};

/// Longest step on an arc, s: the step of a ball that does not move.
pub(super) const LONGEST_FLIGHT_STEP: f64 = 1e6;

/// Acceleration by the inputs, as derivatives at the anchor: `forcing[j]` in m/s^(2+j).
pub(crate) type Forcing = [f64; MAX_FORCE_ORDER + 1];

/// Highest derivative of the forcing that is not zero.
#[inline]
pub(crate) fn degree(forcing: &Forcing) -> usize {
    // Most inputs are constant: one comparison instead of three.
    if forcing[1..].iter().fold(0.0, |sum, p| sum + p.abs()) == 0.0 {
        return 0;
    }
    (1..=MAX_FORCE_ORDER).rev().find(|&j| forcing[j] != 0.0).unwrap_or(0)
}

/// The shortest time (s) in which the forcing or one of its derivatives changes by its own size; infinite if none
/// changes.
pub(crate) fn time_of_change(forcing: &Forcing) -> f64 {
    let sizes = forcing.iter().map(|derivative| derivative.abs()).enumerate().filter(|(_, size)| *size > 0.0);
    let time = |((j, before), (k, size)): ((usize, f64), (usize, f64))| libm::pow(before / size, 1.0 / (k - j) as f64);
    sizes.clone().zip(sizes.skip(1)).map(time).fold(f64::INFINITY, f64::min)
}

/// The forcing `tau` (s) after the anchor, m/s2.
#[inline(never)] // inlined, its copies would be a hundredth of the library
pub(crate) fn forcing_at(forcing: &Forcing, tau: f64) -> f64 {
    (0..=degree(forcing)).rev().fold(0.0, |sum, k| forcing[k] + sum * tau / (k + 1) as f64)
}

/// Integral of the forcing over the first `tau` (s), m/s.
pub(crate) fn integral_of(forcing: &Forcing, tau: f64) -> f64 {
    (0..forcing.len()).rev().fold(0.0, |sum, k| (forcing[k] + sum) * tau / (k + 1) as f64)
}

/// The forcing, expanded about a time `tau` (s) later.
pub(crate) fn shifted(forcing: &Forcing, tau: f64) -> Forcing {
    let mut later = *forcing;
    if degree(forcing) == 0 {
        return later;
    }
    for (j, later) in later.iter_mut().enumerate() {
        let mut power = 1.0;
        for (k, &p) in forcing.iter().enumerate().skip(j + 1) {
            power *= tau / (k - j) as f64;
            *later += p * power;
        }
    }
    later
}

/// Contact-free motion from an anchor on, in closed form.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Flight {
    /// Position at the anchor, m.
    pub x: f64,
    /// Velocity at the anchor, m/s.
    pub v: f64,
    /// Acceleration by the inputs from the anchor on.
    pub forcing: Forcing,
}

/// Running integrals of a ball.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct RunningIntegrals {
    /// Impulse on the support by the pendulum and the drag, over the mass, m/s; on an arc, by the inputs. Its value
    /// over a step is a difference, also late in a run.
    pub support: DoubleDouble,
    /// Energy lost to drag, J.
    pub drag_loss: f64,
    /// Work of the inputs, J.
    pub work: f64,
}

impl RunningIntegrals {
    pub fn is_finite(&self) -> bool {
        all_finite([self.support.value(), self.drag_loss, self.work])
    }

    pub fn add(&mut self, more: &Self) {
        self.support += more.support;
        self.drag_loss += more.drag_loss;
        self.work += more.work;
    }
}

/// Smallest overlap that counts, over the rounding of the positions.
const NO_OVERLAP: f64 = 1e-10;

/// Rounding of positions (m) and velocities (m/s).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rounding {
    pub position: f64,
    pub velocity: f64,
}

impl Rounding {
    pub fn max(self, other: Self) -> Self {
        Self { position: self.position.max(other.position), velocity: self.velocity.max(other.velocity) }
    }

    /// Overlap (m) that counts as none. It is far below rounding, or contacts that only damping opens would never open.
    pub fn no_overlap(&self) -> f64 {
        NO_OVERLAP * self.position
    }

    /// Whether balls with this overlap (m) and rate (m/s) are at rest side by side, within rounding. Their contact then
    /// keeps its mode until the motion decides: see "Clusters" in `docs/theory.md`.
    pub fn is_rest(&self, overlap: f64, rate: f64) -> bool {
        overlap >= -self.position && rate.abs() <= self.velocity
    }
}

impl Flight {
    pub fn is_finite(&self) -> bool {
        let [a, b, c, d] = self.forcing;
        all_finite([self.x, self.v, a, b, c, d])
    }

    /// Displacement (m) `tau` after the anchor, and velocity (m/s).
    #[inline]
    pub fn at(&self, o: &Oscillator, tau: DoubleDouble) -> (f64, f64) {
        if degree(&self.forcing) == 0 {
            let u: [f64; 3] = o.basis(tau);
            (self.displacement(o, &u), self.velocity(o, &u))
        } else {
            let u: [f64; BASIS] = o.basis(tau);
            (self.displacement(o, &u), self.velocity(o, &u))
        }
    }

    /// Rounding of positions and velocities over a swing.
    pub fn rounding(&self, o: &Oscillator) -> Rounding {
        let swing = if o.omega() > 0.0 { self.v.abs() / o.omega() } else { 0.0 };
        let (x, v) = (self.x.abs() + swing, self.v.abs() + o.omega() * self.x.abs());
        Rounding { position: 2.0 * f64::EPSILON * x, velocity: 2.0 * f64::EPSILON * v }
    }

    /// Displacement since the anchor, m, from the oscillator's functions at that time.
    pub fn displacement<const N: usize>(&self, o: &Oscillator, u: &[f64; N]) -> f64 {
        self.response(o, u, 1)
    }

    /// Integral of the displacement since the anchor, m.s.
    pub fn displacement_integral<const N: usize>(&self, o: &Oscillator, u: &[f64; N]) -> f64 {
        self.response(o, u, 2)
    }

    /// Velocity, m/s.
    pub fn velocity<const N: usize>(&self, o: &Oscillator, u: &[f64; N]) -> f64 {
        self.response(o, u, 0)
    }

    /// The displacement integrated `level - 1` times: `v U_level + A U_(level+1) + f_1 U_(level+2) + ...`. If the
    /// forcing is constant, fewer functions than [`BASIS`] suffice.
    #[inline]
    fn response<const N: usize>(&self, o: &Oscillator, u: &[f64; N], level: usize) -> f64 {
        debug_assert!(N == BASIS || degree(&self.forcing) == 0);
        let free = self.v * u[level] + (self.forcing[0] - o.omega2() * self.x) * u[level + 1];
        if N < BASIS {
            return free;
        }
        free + (1..=degree(&self.forcing)).map(|j| self.forcing[j] * u[level + 1 + j]).sum::<f64>()
    }

    /// Acceleration `tau` after the anchor, m/s2, for this displacement and velocity.
    pub fn acceleration(&self, o: &Oscillator, tau: f64, displacement: f64, v: f64) -> f64 {
        forcing_at(&self.forcing, tau) - o.omega2() * self.x - o.omega2() * displacement - 2.0 * o.gamma() * v
    }

    /// The work of `forcing` on this motion per unit of mass since the anchor, m2/s2:
    /// `integral f v = f D - f' I_1 + f'' I_2 - ...` with the repeated integrals `I_k` of the displacement D.
    pub fn work<const N: usize>(&self, forcing: &Forcing, o: &Oscillator, tau: f64, u: &[f64; N]) -> f64 {
        if N < BASIS || degree(forcing) == 0 {
            return if forcing[0] == 0.0 { 0.0 } else { forcing[0] * self.displacement(o, u) };
        }
        let later = shifted(forcing, tau);
        let terms = (0..=degree(forcing)).map(|j| later[j] * self.response(o, u, j + 1));
        terms.enumerate().map(|(j, term)| if j % 2 == 0 { term } else { -term }).sum()
    }

    /// Bound of the absolute derivative of `order` 3 or 4 of the position from `t` to `t + span` (s after the anchor).
    ///
    /// Under a forcing that varies, `sqrt(a^2 + omega^2 v^2)` grows at most by the integral of the rate of the forcing.
    pub fn derivative_bound(&self, o: &Oscillator, t: f64, span: f64, order: i32) -> f64 {
        let a = self.acceleration(o, 0.0, 0.0, self.v);
        if degree(&self.forcing) == 0 {
            return o.derivative_bound(self.v, a, t, order);
        }
        let end = t + span;
        let (mut rate, mut curvature, mut power) = (0.0, 0.0, 1.0);
        for j in 1..=degree(&self.forcing) {
            rate += self.forcing[j].abs() * power;
            curvature += self.forcing.get(j + 1).map_or(0.0, |forcing| forcing.abs() * power);
            power *= end / j as f64;
        }
        let swing = hypotenuse(a * a + o.omega2() * self.v * self.v, a, o.omega() * self.v);
        let amplitude = swing + rate * end;
        let third = rate + o.pace() * amplitude;
        let grown = if order == 3 { third } else { curvature + o.omega2() * amplitude + 2.0 * o.gamma() * third };
        // Early on the bound by growth is the tighter one; once drag has damped the start, the motion follows the
        // forcing.
        if o.gamma() > 0.0
            && let Some(steady) = Steady::new(o, self.v, a, &self.forcing)
        {
            return grown.min(steady.derivative_bound(o, t, end, order));
        }
        grown
    }
}
