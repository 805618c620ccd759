//! Random cradles, and the runs of the properties.

use newtons_cradle::engine::{Engine, EngineError, Pulse};
use newtons_cradle::model::{ContactModel, DampingLaw, Inputs, Parameters, PendulumModel, hertz_stiffness};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::runs::state;

/// The most balls of a random cradle.
const MOST: usize = 6;

/// What random cradles of a property have besides unlike balls, gaps, losses and inputs, each of these about half of
/// the time.
#[derive(Clone, Copy)]
pub struct Family {
    /// Pre-compressed contacts, with a stiffness at which they can be followed for seconds.
    pub pressed: bool,
    /// Rigid contacts.
    pub rigid: bool,
    /// Pendulums on arcs.
    pub arcs: bool,
    /// Exponents from 1 to 5, half of them whole or a whole number and a half: those that Gauss collocation and the
    /// closed form are for.
    pub powers: bool,
}

/// Compliant contacts on lines.
pub const ANY: Family = Family { pressed: false, rigid: false, arcs: false, powers: false };

/// The same on arcs.
pub const ARCS: Family = Family { arcs: true, ..ANY };

/// The same with rigid contacts, on lines and on arcs.
pub fn rigid() -> impl Strategy<Value = Case> {
    let rigid = Family { rigid: true, ..ANY };
    prop_oneof![cradles(rigid), cradles(Family { arcs: true, ..rigid })]
}

/// A random cradle, its inputs, and how long to follow it.
#[derive(Clone, Debug)]
pub struct Case {
    pub p: Parameters,
    pub inputs: Inputs,
    /// s.
    pub time: f64,
}

/// 10 to a power between `low` and `high`.
pub fn decades(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low..high).prop_map(|exponent| 10f64.powf(exponent))
}

/// Exponents of the force law: linear, Hertz's, whole ones, and any between.
pub fn exponents() -> impl Strategy<Value = f64> {
    prop_oneof![Just(1.0), Just(1.5), (2..=10u8).prop_map(f64::from), 1.0..10.0]
}

/// `value` or `plain`, each half of the time.
fn or<T: Clone + std::fmt::Debug + 'static>(plain: T, value: impl Strategy<Value = T> + 'static) -> BoxedStrategy<T> {
    prop_oneof![Just(plain), value].boxed()
}

pub fn laws() -> impl Strategy<Value = DampingLaw> {
    use DampingLaw::{ConstantRestitution, HuntCrossley, KelvinVoigt, KelvinVoigtNoPull, Viscoelastic};
    prop::sample::select(vec![KelvinVoigt, KelvinVoigtNoPull, HuntCrossley, Viscoelastic, ConstantRestitution])
}

/// Gives contacts of this stiffness over mass (1/s2) a law, with coefficients in units of the critical damping, of the
/// inverse of 1 m/s, and of the time of a linear contact, or a restitution with twice as large a decrement, and the
/// pendulums a drag over mass (1/s).
pub fn lose(p: &mut Parameters, (law, damping, drag): (DampingLaw, f64, f64), stiffness: f64) {
    (p.damping_law, p.drag) = (law, drag * p.mass);
    (p.damping, p.hunt_crossley) = (damping * p.mass * (2.0 * stiffness).sqrt(), damping);
    p.relaxation_time = damping * (2.0 / stiffness).sqrt();
    p.restitution = libm::exp(-2.0 * damping);
}

/// Loss ratios of contacts, some of which are elastic.
pub fn loss_ratios(contacts: usize) -> BoxedStrategy<Vec<f64>> {
    or(vec![1.0; contacts], vec(prop_oneof![Just(0.0), Just(1.0), 0.1..3.0], contacts))
}

/// Random cradles of 2 to 6 balls whose largest speeds are of the order of 1 m/s.
pub fn cradles(family: Family) -> impl Strategy<Value = Case> {
    let ones = || vec![1.0; MOST];
    let pendulums = (2..=MOST, or(0.0, 0.5..20.0), 0.2..3.0, decades(-2.0, 1.0));
    let ratios = (
        or(ones(), vec(decades(-1.0, 1.0), MOST)),
        or(ones(), vec(0.7..1.4, MOST)),
        or(ones(), vec(decades(-2.0, 2.0), MOST)),
    );
    let spheres = (or(ones(), vec(0.5..2.0, MOST)), or(ones(), vec(decades(-0.5, 0.5), MOST)), any::<bool>());
    let stiffness = if family.pressed { decades(3.0, 6.0).boxed() } else { decades(5.0, 11.0).boxed() };
    let gap = if family.pressed { (-1e-5..1e-6).boxed() } else { (0.0..1e-4).boxed() };
    let dead_band = if family.pressed { Just(0.0).boxed() } else { or(0.0, decades(-9.0, -3.0)) };
    let exponent = if family.powers {
        prop_oneof![(2..=10u8).prop_map(|p| 0.5 * f64::from(p)), 1.0..5.0].boxed()
    } else {
        exponents().boxed()
    };
    let contacts = (stiffness, exponent, dead_band, or(vec![0.0; MOST], vec(gap, MOST)));
    let losses = ((laws(), or(0.0, decades(-3.0, 0.3)), or(0.0, decades(-3.0, 0.3))), loss_ratios(MOST));
    let lifted = prop_oneof![2 => Just(0.0), 1 => -1.0..0.0, 1 => 0.0..1.0];
    let start = (decades(-3.0, -0.5), vec(lifted, MOST), or(vec![0.0; MOST], vec(-1.0..1.0, MOST)));
    let inputs = (or(vec![0.0; MOST], vec(-1.0..1.0, MOST)), or(0.0, -1.0..1.0));
    let restitution = or(1.0, prop_oneof![Just(0.0), 0.0..1.0, 0.8..1.0]);
    let model = (Just(family.rigid), restitution, Just(family.arcs));
    (pendulums, (ratios, spheres), contacts, losses, start, inputs, (0.1..3.0, model)).prop_map(
        |(pendulums, (ratios, spheres), contacts, losses, start, inputs, (time, (rigid, restitution, arcs)))| {
            let (n, gravity, length, mass) = pendulums;
            let mut p = Parameters::default_for(n);
            (p.gravity, p.length, p.mass) = (gravity, length, mass);
            p.mass_ratio = ratios.0[..n].to_vec();
            p.length_ratio = ratios.1[..n].to_vec();
            p.stiffness_ratio = ratios.2[..n - 1].to_vec();
            (p.radius_ratio, p.young_modulus_ratio) = (spheres.0[..n].to_vec(), spheres.1[..n].to_vec());
            (p.stiffness, p.exponent, p.dead_band) = (contacts.0 * mass, contacts.1, contacts.2);
            p.gap = contacts.3[..n - 1].to_vec();
            lose(&mut p, losses.0, contacts.0);
            p.loss_ratio = losses.1[..n - 1].to_vec();
            let (amplitude, mut x, v) = start;
            x.truncate(n);
            x.sort_by(f64::total_cmp);
            p.x_start = x.iter().map(|x| amplitude * x).collect();
            p.v_start = v[..n].to_vec();
            let mut held = Inputs::zero(n);
            held.force = inputs.0[..n].iter().map(|f| f * mass).collect();
            held.support_acceleration = inputs.1;
            let mut case = Case { p, inputs: held, time };
            if rigid {
                (case.p.contact_model, case.p.restitution) = (ContactModel::Rigid, restitution);
            } else {
                case.soften();
            }
            if arcs {
                case.p.pendulum = PendulumModel::Circular;
                // Soft contacts are deep.
                let softest = case.p.stiffness_ratio.iter().fold(f64::INFINITY, |least, ratio| least.min(*ratio));
                case.p.radius = if !rigid && softest * case.p.stiffness < 1e8 * mass { 5.0 } else { 0.05 };
            }
            if spheres.2 && !rigid && case.p.exponent == 1.5 {
                case.as_spheres();
            }
            case
        },
    )
}

/// A run that ended early has failed, unless a ball on an arc was lifted or swung too high, or rigid balls stay in
/// contact that do not swing as one.
pub fn ended_early(error: EngineError) -> TestCaseError {
    match error {
        EngineError::OffArc { .. } | EngineError::NoArc(_) => TestCaseError::reject(error.to_string()),
        _ => TestCaseError::fail(error.to_string()),
    }
}

impl Case {
    /// Contacts of Hertz in place of the power law: with ratios of 1 they have the same stiffness.
    fn as_spheres(&mut self) {
        let p = &mut self.p;
        p.contact_model = ContactModel::Hertz;
        let unit = hertz_stiffness([1.0; 2], p.poisson_ratio, [p.radius; 2]);
        p.young_modulus = p.stiffness / p.overlap_ref.sqrt() / unit;
    }

    /// Inputs press balls together, and without damping contacts that stay closed ring for ever: a run of seconds takes
    /// `time sqrt(k / m)` segments, each of its own, since at every one of them a contact may open. Softer contacts do
    /// the same in a time that tests have.
    fn soften(&mut self) {
        if self.p.stiffness > 1e6 * self.p.mass && self.driven() {
            self.p.stiffness *= 1e-5;
            self.p.damping *= 1e-5f64.sqrt();
        }
    }

    /// The engine at the start.
    pub fn start(&self) -> Result<Engine, TestCaseError> {
        Engine::new(&self.p, &self.inputs, 0.0).map_err(ended_early)
    }

    /// The engine at the end, and all pulses.
    pub fn run(&self) -> Result<(Engine, Vec<Pulse>), TestCaseError> {
        let (mut engine, mut pulses) = (self.start()?, Vec::new());
        engine.advance(self.time, &mut pulses).map_err(ended_early)?;
        Ok((engine, pulses))
    }

    /// Positions and velocities at the end.
    pub fn state(&self) -> Result<(Vec<f64>, Vec<f64>), TestCaseError> {
        Ok(state(&self.run()?.0, self.p.balls()))
    }

    /// The largest shift that the rounding of the start positions can cause in the positions (m) and velocities (m/s)
    /// at the end, which are `(x, v)`: properties that compare two runs cannot be had better than a hundred times that.
    pub fn spread(&self, (x, v): &(Vec<f64>, Vec<f64>)) -> Result<(f64, f64), TestCaseError> {
        let reach = x.iter().chain(&self.p.x_start).fold(1e-3, |most: f64, x| most.max(x.abs()));
        let mut spread = (0.0, 0.0);
        for variant in 1..4usize {
            let mut shifted = self.clone();
            let shift = |i: usize| {
                let sign = if (i * variant + i / 2).is_multiple_of(2) { 1.0 } else { -1.0 };
                sign * variant as f64 * f64::EPSILON
            };
            if self.p.contact_model == ContactModel::Rigid {
                // Balls that touch go on doing so: how impacts follow each other does not depend continuously on gaps.
                shifted.p.x_start.iter_mut().for_each(|x| *x *= 1.0 + shift(variant));
                shifted.p.v_start.iter_mut().enumerate().for_each(|(i, v)| *v *= 1.0 + shift(i));
                shifted.inputs.force.iter_mut().enumerate().for_each(|(i, force)| *force *= 1.0 + shift(i));
                shifted.inputs.support_acceleration *= 1.0 + shift(variant);
            } else {
                shifted.p.x_start.iter_mut().enumerate().for_each(|(i, x)| *x += shift(i) * reach);
            }
            let (shifted_x, shifted_v) = shifted.state()?;
            spread = (f64::max(spread.0, distance(x, &shifted_x)), f64::max(spread.1, distance(v, &shifted_v)));
        }
        Ok(spread)
    }

    /// Whether inputs act.
    pub fn driven(&self) -> bool {
        self.inputs.support_acceleration != 0.0 || self.inputs.force.iter().any(|f| *f != 0.0)
    }

    /// Sum of the masses, kg.
    pub fn mass(&self) -> f64 {
        self.p.mass_ratio.iter().sum::<f64>() * self.p.mass
    }
}

/// Largest difference of two vectors.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}
