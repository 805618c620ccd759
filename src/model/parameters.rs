//! What a user can set: the parameters and the inputs of the cradle.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::enumeration::enumerations;

enumerations! {
    /// Force law of a contact, `contact.model`.
    ContactModel {
        PowerLaw = 1 "powerLaw" "F = k r (d/d_ref)^(p-1) d for an overlap d and a stiffness ratio r",
        Hertz "hertz" "F = K r d^(3/2), with K from the radii and elastic constants of two spheres (Hertz 1882)",
        Rigid "rigid" "no force law: instantaneous impacts of two balls with a coefficient of restitution",
    }

    /// Damping of a contact, `contact.dampingLaw`. All laws act only while the overlap is positive. Sources: the third,
    /// Hunt and Crossley (1975); the fourth, Kuwabara and Kono (1987) and Brilliantov et al. (1996); the last, for
    /// Hertz contacts, Tsuji et al. (1992).
    DampingLaw {
        KelvinVoigt = 1 "kelvinVoigt" "adds c times the overlap rate; may pull just before the balls part",
        KelvinVoigtNoPull "kelvinVoigtNoPull" "as kelvinVoigt, with the total force clipped at 0",
        HuntCrossley "huntCrossley" "multiplies the elastic force by 1 + alpha times the overlap rate, clipped at 0",
        Viscoelastic "viscoelastic" "adds A times the rate of the elastic force, clipped at 0",
        ConstantRestitution "constantRestitution" "two balls alone part at e times their speed of approach, e = restitution ^ lossRatio[i]",
    }

    /// How balls hang, `pendulum.model`.
    PendulumModel {
        Linear = 1 "linear" "on a line; the period does not depend on the amplitude",
        Circular "circular" "on arcs about the pivots, up to 90 degrees",
    }

    /// Method of solution, `solver.method`.
    SolverMethod {
        EventDriven = 1 "eventDriven" "exact flight between contacts, adaptive integration of the balls in contact",
        Bdf "bdf" "backward differentiation formulas of variable order and step for the whole chain",
        Adams "adams" "Adams-Moulton formulas of variable order and step for the whole chain",
        Rk4 "rk4" "classical Runge-Kutta method with fixed steps for the whole chain",
    }

    /// How contacts appear to a host that integrates the equations, `exchange.contacts`.
    ExchangedContacts {
        Resolved = 1 "resolved" "the host integrates the forces of every contact",
        Mapped "mapped" "an event follows the contacts to their end; the host integrates the flight between them",
    }
}

/// Defines the parameters, each with its default for `n >= 1` balls.
macro_rules! parameters {
    ($n:ident: $($(#[$doc:meta])* $field:ident: $type:ty = $default:expr,)*) => {
        /// All parameters of a cradle of `n` balls. Vectors over balls have length `n`, vectors over contacts `n - 1`.
        /// The ranges are those of the table of variables and hold for every value here.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        pub struct Parameters {
            $($(#[$doc])* pub $field: $type,)*
        }

        impl Parameters {
            /// The defaults for `n >= 1` balls: the first `max(1, min(2, n - 1))` start at x = -0.1 m.
            pub fn default_for($n: usize) -> Self {
                Self { $($field: $default,)* }
            }
        }
    };
}

parameters! {
    n:
    /// Gravity g, m/s2, >= 0; 0 gives free balls on a line.
    gravity: f64 = 9.81,
    /// Mass of a ball with ratio 1, kg, > 0.
    mass: f64 = 1.0,
    /// Mass of each ball over `mass`, 1, > 0.
    mass_ratio: Vec<f64> = vec![1.0; n],
    /// Radius of a ball with ratio 1, m, > 0 (Hertz contacts, arcs and drawing).
    radius: f64 = 0.0313,
    /// Radius of each ball over `radius`, 1, > 0.
    radius_ratio: Vec<f64> = vec![1.0; n],
    /// Young's modulus E of a ball with ratio 1, Pa, > 0 (Hertz contacts).
    young_modulus: f64 = 2.1e11,
    /// Young's modulus of each ball over `young_modulus`, 1, > 0.
    young_modulus_ratio: Vec<f64> = vec![1.0; n],
    /// Poisson's ratio nu of the balls, 1, 0 to 0.5 (Hertz contacts).
    poisson_ratio: f64 = 0.3,
    /// Length of a pendulum with ratio 1, m, > 0.
    length: f64 = 1.962,
    /// Length of each pendulum over `length`, 1, > 0.
    length_ratio: Vec<f64> = vec![1.0; n],
    /// Whether the balls move on a line or on arcs.
    pendulum: PendulumModel = PendulumModel::Linear,
    /// Viscous drag b on every ball, kg/s, >= 0.
    drag: f64 = 0.0,
    /// Which force law the contacts follow.
    contact_model: ContactModel = ContactModel::PowerLaw,
    /// Secant stiffness k at the reference overlap, N/m, > 0.
    stiffness: f64 = 1e10,
    /// Stiffness of each contact over `stiffness`, 1, > 0.
    stiffness_ratio: Vec<f64> = vec![1.0; n.saturating_sub(1)],
    /// Overlap d_ref at which the secant stiffness is `stiffness`, m, > 0.
    overlap_ref: f64 = 1e-6,
    /// Exponent p of the power law, 1, 1 to 10.
    exponent: f64 = 1.0,
    /// Distance, m, >= 0, that neighbours travel beyond their gap before the contact spring acts.
    dead_band: f64 = 2.6e-6,
    /// Gap of each contact at rest, m; negative where neighbours are pre-compressed.
    gap: Vec<f64> = vec![0.0; n.saturating_sub(1)],
    /// Which damping law the contacts follow.
    damping_law: DampingLaw = DampingLaw::KelvinVoigt,
    /// Damping c of the Kelvin-Voigt laws, N.s/m, >= 0.
    damping: f64 = 0.0,
    /// Factor alpha of the Hunt-Crossley law, s/m, >= 0.
    hunt_crossley: f64 = 0.0,
    /// Relaxation time A of the viscoelastic law, s, >= 0.
    relaxation_time: f64 = 0.0,
    /// Coefficient of restitution of rigid contacts and of the constantRestitution law, 1, 0 to 1.
    restitution: f64 = 1.0,
    /// Factor of the damping of each contact, 1, >= 0; the exponent of the coefficient of restitution.
    loss_ratio: Vec<f64> = vec![1.0; n.saturating_sub(1)],
    /// Horizontal position of each ball at the start time, m.
    x_start: Vec<f64> = lifted(n),
    /// Horizontal velocity of each ball at the start time, m/s.
    v_start: Vec<f64> = vec![0.0; n],
    /// Method of solution.
    method: SolverMethod = SolverMethod::EventDriven,
    /// Relative tolerance of the solver, 1, 1e-14 to 1e-3.
    tolerance: f64 = 1e-12,
    /// Step of [`SolverMethod::Rk4`], s, > 0.
    fixed_step: f64 = 1e-6,
    /// How contacts appear to a host that integrates the equations.
    exchange_contacts: ExchangedContacts = ExchangedContacts::Mapped,
}

/// Start positions: the first balls are pulled to the left.
fn lifted(n: usize) -> Vec<f64> {
    let count = n.saturating_sub(1).clamp(1, 2);
    (0..n).map(|i| if i < count { -0.1 } else { 0.0 }).collect()
}

impl Parameters {
    /// Number of balls n.
    pub fn balls(&self) -> usize {
        self.mass_ratio.len()
    }

    fn tunable_numbers(&self) -> [f64; 5] {
        [self.drag, self.damping, self.hunt_crossley, self.relaxation_time, self.restitution]
    }

    /// The tunable parameters: those that may change during a run.
    pub fn tunables(&self) -> Tunables {
        Tunables { numbers: self.tunable_numbers(), loss_ratio: self.loss_ratio.clone() }
    }

    /// Whether the tunable parameters equal those of `other`.
    pub fn is_tuned_as(&self, other: &Self) -> bool {
        self.tunable_numbers() == other.tunable_numbers() && self.loss_ratio == other.loss_ratio
    }

    /// Sets the tunable parameters.
    pub fn tune(&mut self, tunables: &Tunables) {
        [self.drag, self.damping, self.hunt_crossley, self.relaxation_time, self.restitution] = tunables.numbers;
        self.loss_ratio.clone_from(&tunables.loss_ratio);
    }

    /// Whether contacts with a loss ratio above 0 dissipate energy.
    pub fn contacts_lose(&self) -> bool {
        if self.contact_model == ContactModel::Rigid {
            return self.restitution < 1.0;
        }
        match self.damping_law {
            DampingLaw::KelvinVoigt | DampingLaw::KelvinVoigtNoPull => self.damping > 0.0,
            DampingLaw::HuntCrossley => self.hunt_crossley > 0.0,
            DampingLaw::Viscoelastic => self.relaxation_time > 0.0,
            DampingLaw::ConstantRestitution => self.restitution < 1.0,
        }
    }

    /// Number of contacts, n - 1.
    pub fn contacts(&self) -> usize {
        self.stiffness_ratio.len()
    }

    /// Radius of ball `i`, m.
    pub fn radius_of(&self, i: usize) -> f64 {
        self.radius * self.radius_ratio[i]
    }

    /// Every vector over balls or contacts.
    pub fn vectors_mut(&mut self) -> [&mut Vec<f64>; 9] {
        [
            &mut self.mass_ratio,
            &mut self.radius_ratio,
            &mut self.young_modulus_ratio,
            &mut self.length_ratio,
            &mut self.stiffness_ratio,
            &mut self.gap,
            &mut self.loss_ratio,
            &mut self.x_start,
            &mut self.v_start,
        ]
    }

    /// The parameters of the balls in `range` and of the contacts between them.
    pub fn part(&self, range: &Range<usize>) -> Self {
        let (mut part, balls) = (self.clone(), self.balls());
        for vector in part.vectors_mut() {
            // Vectors over contacts are shorter by one.
            vector.truncate(range.end + vector.len() - balls);
            vector.drain(..range.start);
        }
        part
    }
}

/// The tunable parameters, in the units of [`Parameters`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tunables {
    /// Drag b, damping c, Hunt and Crossley's alpha, relaxation time A, coefficient of restitution e.
    numbers: [f64; 5],
    loss_ratio: Vec<f64>,
}

impl Tunables {
    /// Number of values.
    #[expect(clippy::len_without_is_empty, reason = "there are always some")]
    pub fn len(&self) -> usize {
        self.numbers.len() + self.loss_ratio.len()
    }
}

/// The inputs of the cradle at one time, or their time derivatives of one order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Inputs {
    /// External force on each ball, N.
    pub force: Vec<f64>,
    /// Acceleration of the support, m/s2; positions are relative to it.
    pub support_acceleration: f64,
}

impl Inputs {
    /// No force on any of `n` balls, support at rest.
    pub fn zero(n: usize) -> Self {
        Self { force: vec![0.0; n], support_acceleration: 0.0 }
    }

    /// Whether all inputs are finite.
    pub fn is_finite(&self) -> bool {
        self.support_acceleration.is_finite() && self.force.iter().all(|force| force.is_finite())
    }

    /// The inputs `tau` (s) later, by Taylor's theorem with their `derivatives` from the first on.
    pub fn continued(&self, derivatives: &[Self], tau: f64) -> Self {
        let mut later = self.clone();
        let mut power = 1.0;
        for (k, derivative) in derivatives.iter().enumerate() {
            power *= tau / (k + 1) as f64;
            later.support_acceleration += power * derivative.support_acceleration;
            later.force.iter_mut().zip(&derivative.force).for_each(|(force, rate)| *force += power * rate);
        }
        later
    }
}
