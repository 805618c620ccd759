//! What a run shows at its current time, in doubles or dual numbers, and its derivatives.

use serde::{Deserialize, Serialize};

use super::arc::Place;
use super::contact::ContactLaw;
use super::cradle::{BallModel, Cradle};
use crate::forecast::{Forecast, NEVER};
use crate::solver::dual::{Dual, Scalar};

/// Number of periods of the first ball within which the next onset is looked for.
pub const ONSET_PERIODS: f64 = 1000.0;

/// Highest derivative of an input that is taken into account.
pub const MAX_INPUT_DERIVATIVE: usize = 3;

/// Highest time derivative of an output that is offered.
pub const MAX_OUTPUT_DERIVATIVE: usize = 3;

/// A cradle in a state, and what follows from state and inputs, for every method of solution. Balls and contacts are
/// counted from 0; contact `i` lies between balls `i` and `i + 1`.
pub trait Chain<S: Scalar = f64> {
    /// The coefficients of its equations.
    fn cradle(&self) -> &Cradle<S>;
    /// Position (m) and velocity (m/s) of ball `i` along its path.
    fn state_of(&self, i: usize) -> (S, S);
    /// Acceleration of ball `i` by the external forces and the support, m/s2.
    fn forcing_of(&self, i: usize) -> S;
    /// Overlap of contact `i`, m; negative while apart.
    fn overlap(&self, i: usize) -> S;
    /// Force of contact `i`, pushing its balls apart, N.
    fn force(&self, i: usize) -> S;

    /// Whether contact `i` is closed.
    fn in_contact(&self, i: usize) -> bool {
        self.overlap(i).value() > 0.0
    }

    /// The overlap of contact `i` that stores its elastic energy, m.
    fn elastic_overlap(&self, i: usize) -> S {
        self.overlap(i)
    }

    /// Rate of the overlap of contact `i`, m/s.
    fn overlap_rate(&self, i: usize) -> S {
        self.cradle().pair(i).overlap_rate([self.state_of(i), self.state_of(i + 1)])
    }

    /// Acceleration of the overlap of contact `i`, m/s2.
    fn overlap_acceleration(&self, i: usize) -> S {
        let states = [i, i + 1].map(|ball| self.state_of(ball));
        self.cradle()
            .pair(i)
            .overlap_acceleration(states, [i, i + 1].map(|ball| along_path(self, ball, &place(self, ball))))
    }

    /// Position of ball `i` from its rest position, relative to the support, m.
    fn x(&self, i: usize) -> S {
        place(self, i).x
    }

    /// Velocity of ball `i` relative to the support, m/s.
    fn v(&self, i: usize) -> S {
        self.state_of(i).1 * place(self, i).cos
    }

    /// Angle of pendulum `i`, rad.
    fn angle(&self, i: usize) -> S {
        self.state_of(i).0 / self.cradle().balls[i].length
    }

    /// Height of ball `i` above its rest position, m.
    fn y(&self, i: usize) -> S {
        place(self, i).y
    }

    /// Acceleration of ball `i` relative to the support, m/s2.
    fn a(&self, i: usize) -> S {
        let (ball, (_, u)) = (&self.cradle().balls[i], self.state_of(i));
        let place = place(self, i);
        along_path(self, i, &place) * place.cos - u / ball.length * place.sin * u
    }

    /// Tension of the string of ball `i` on an arc, N.
    fn tension(&self, i: usize) -> S {
        tension(self, i, &place(self, i))
    }

    /// Kinetic energy of ball `i`, J.
    fn kinetic_energy(&self, i: usize) -> S {
        let (_, v) = self.state_of(i);
        S::from(0.5) * self.cradle().balls[i].mass * v * v
    }

    /// Energy of ball `i` in the field of gravity, J.
    fn gravity_energy(&self, i: usize) -> S {
        let ball = &self.cradle().balls[i];
        ball.mass * ball.potential(self.state_of(i).0)
    }

    /// Elastic energy of contact `i`, J.
    fn contact_energy(&self, i: usize) -> S {
        self.cradle().contacts[i].elastic_energy(self.elastic_overlap(i))
    }

    /// Kinetic, gravity and contact energy of all balls, J.
    fn total_energy(&self) -> S {
        let Cradle { balls, contacts, .. } = self.cradle();
        let of_balls: S = (0..balls.len()).map(|i| self.kinetic_energy(i) + self.gravity_energy(i)).sum();
        of_balls + (0..contacts.len()).map(|i| self.contact_energy(i)).sum()
    }

    /// Sum of mass times velocity, N.s.
    fn momentum(&self) -> S {
        self.cradle().balls.iter().enumerate().map(|(i, ball)| ball.mass * self.v(i)).sum()
    }

    /// Horizontal force of the pendulums and the drag on the support, N.
    fn support_force(&self) -> S {
        (0..self.cradle().balls.len()).map(|i| on_support(self, i)[0]).sum()
    }

    /// Vertical force on the support, upwards, N: minus the weight of the balls while they hang at rest.
    fn support_force_vertical(&self) -> S {
        (0..self.cradle().balls.len()).map(|i| on_support(self, i)[1]).sum()
    }

    /// Power dissipated by drag and contacts at this instant, W.
    fn dissipation(&self) -> S {
        let Cradle { balls, contacts, .. } = self.cradle();
        let of_ball = |(i, ball): (usize, &BallModel<S>)| {
            let (_, v) = self.state_of(i);
            S::from(2.0) * ball.gamma * ball.mass * v * v
        };
        let of_contact = |(i, law): (usize, &ContactLaw<S>)| {
            let excess = self.force(i) - law.elastic_force(self.elastic_overlap(i));
            excess * self.overlap_rate(i)
        };
        balls.iter().enumerate().map(of_ball).sum::<S>() + contacts.iter().enumerate().map(of_contact).sum()
    }

    /// Power of the external forces and of the moving support at this instant, W.
    fn external_power(&self) -> S {
        let of_ball = |(i, ball): (usize, &BallModel<S>)| ball.mass * self.forcing_of(i) * self.v(i);
        self.cradle().balls.iter().enumerate().map(of_ball).sum()
    }
}

/// A run at its current time: all results.
pub trait Results: Chain {
    /// Length of the last step, s; 0 where values over a step are those of this instant.
    fn step_length(&self) -> f64 {
        0.0
    }

    /// Integral of the force of contact `i` over the last step, N.s.
    fn impulse_of_step(&self, _i: usize) -> f64 {
        0.0
    }

    /// Integral of the horizontal force on the support over the last step, N.s.
    fn support_impulse_of_step(&self) -> f64 {
        0.0
    }

    /// Mean force of contact `i` over the last step, N.
    fn force_mean(&self, i: usize) -> f64 {
        let length = self.step_length();
        if length == 0.0 { self.force(i) } else { self.impulse_of_step(i) / length }
    }

    /// Mean of the horizontal force on the support over the last step, N.
    fn support_force_mean(&self) -> f64 {
        let length = self.step_length();
        if length == 0.0 { self.support_force() } else { self.support_impulse_of_step() / length }
    }

    /// Largest force of contact `i` in the last step, N.
    fn force_peak(&self, i: usize) -> f64;
    /// Integral of the force of contact `i` since the start, N.s.
    fn impulse(&self, i: usize) -> f64;
    /// Onsets and releases of contact `i`.
    fn record(&self, i: usize) -> Record;
    /// The total energy at the start, J.
    fn energy_at_start(&self) -> f64;
    /// Energy dissipated by drag and contacts since the start, J.
    fn dissipated_energy(&self) -> f64;
    /// Work of the external forces and of the moving support since the start, J.
    fn external_work(&self) -> f64;
    /// First onset of any contact strictly after the current time, as far as a limited search finds it.
    fn next_onset(&self) -> Forecast;
    /// Work counters since the start.
    fn work(&self) -> WorkCounters;

    /// Onsets of contact `i` so far.
    fn pulses(&self, i: usize) -> u64 {
        self.record(i).pulses
    }

    /// Last onset of contact `i`, s; minus [`NEVER`] before the first.
    fn last_onset(&self, i: usize) -> f64 {
        self.record(i).onset
    }

    /// Last release of contact `i`, s; minus [`NEVER`] before the first.
    fn last_release(&self, i: usize) -> f64 {
        self.record(i).release
    }

    /// The energy error since the start, J.
    fn energy_residual(&self) -> f64 {
        (self.total_energy() - self.energy_at_start()) + (self.dissipated_energy() - self.external_work())
    }
}

/// The place of ball `i` on its path.
fn place<S: Scalar>(chain: &(impl Chain<S> + ?Sized), i: usize) -> Place<S> {
    chain.cradle().balls[i].place(chain.state_of(i).0)
}

/// Acceleration of ball `i` along its path, m/s2; its place is `at`.
#[inline]
fn along_path<S: Scalar>(chain: &(impl Chain<S> + ?Sized), i: usize, at: &Place<S>) -> S {
    let (ball, (_, u), [force, _]) = (&chain.cradle().balls[i], chain.state_of(i), pushed(chain, i));
    force / ball.mass + chain.forcing_of(i) * at.cos - ball.gravity * at.restoring - S::from(2.0) * ball.gamma * u
}

/// Tension of the string of ball `i` on an arc, N; its place is `at`.
fn tension<S: Scalar>(chain: &(impl Chain<S> + ?Sized), i: usize, at: &Place<S>) -> S {
    let (ball, (_, u)) = (&chain.cradle().balls[i], chain.state_of(i));
    let without_contacts = ball.gravity * at.cos + u * u / ball.length + chain.forcing_of(i) * at.sin;
    ball.mass * without_contacts + pushed(chain, i)[1]
}

/// Sums of the contact forces on ball `i` along its path and away from its pivot, N.
fn pushed<S: Scalar>(chain: &(impl Chain<S> + ?Sized), i: usize) -> [S; 2] {
    let cradle = chain.cradle();
    let from_left = if i > 0 { chain.force(i - 1) } else { S::default() };
    let from_right = if i < cradle.contacts.len() { chain.force(i) } else { S::default() };
    let (mut sum, own) = ([S::default(); 2], place(chain, i));
    for (force, j) in [(from_left, i.wrapping_sub(1)), (-from_right, i)] {
        // Without a force no direction is needed.
        if force != S::default() {
            let [left, right] = [j, j + 1].map(|k| if k == i { own } else { place(chain, k) });
            let [along, outward] = cradle.pair(j).parts_of(i - j, [&left, &right]);
            sum[0] += force * along;
            sum[1] += force * outward;
        }
    }
    sum
}

/// Horizontal and upward force of ball `i` on the support, N: by the tension of its string and the drag.
fn on_support<S: Scalar>(chain: &(impl Chain<S> + ?Sized), i: usize) -> [S; 2] {
    let (ball, (s, u)) = (&chain.cradle().balls[i], chain.state_of(i));
    if !ball.on_arc {
        return [ball.support_force(s, u), -ball.mass * ball.gravity];
    }
    let at = ball.place(s);
    let (tension, drag) = (tension(chain, i, &at), S::from(2.0) * ball.gamma * ball.mass * u);
    [tension * at.sin + drag * at.cos, drag * at.sin - tension * at.cos]
}

/// Onsets and releases of a contact.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Record {
    /// Onsets so far.
    pub pulses: u64,
    /// Last onset, s; minus [`NEVER`] before the first.
    pub onset: f64,
    /// Last release, s; minus [`NEVER`] before the first.
    pub release: f64,
}

impl Default for Record {
    fn default() -> Self {
        Self { pulses: 0, onset: -NEVER, release: -NEVER }
    }
}

/// Work counters since the start; they saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct WorkCounters {
    /// Integration steps accepted in contact phases.
    pub steps: u64,
    /// Evaluations of the contact forces or, by some methods, of their Taylor series; a closed form counts as one.
    pub evaluations: u64,
    /// Onsets, releases and switchings of contact laws handled.
    pub events: u64,
}

/// Declares [`Differential`] with the names of the results; first those that follow from the state and the inputs.
macro_rules! differential {
    (
        of_balls: $($ball:ident)*; of_contacts: $($contact:ident)*; totals: $($total:ident)*;
        others_of_contacts: $($other:ident)*; others: $($number:ident)*;
    ) => {
        /// Derivatives of the results. Either time derivatives, of one order, of all real outputs; or derivatives along
        /// one direction in the space of inputs, states and parameters, also of the states of model exchange and their
        /// time derivatives. The units are those of the variables over that of the time or of the direction.
        #[derive(Clone, Debug)]
        pub struct Differential {
            $(#[doc = concat!("Of `", stringify!($ball), "` of each ball.")]
            pub $ball: Vec<f64>,)*
            $(#[doc = concat!("Of `", stringify!($contact), "` of each contact.")]
            pub $contact: Vec<f64>,)*
            $(#[doc = concat!("Of `", stringify!($other), "` of each contact.")]
            pub $other: Vec<f64>,)*
            $(#[doc = concat!("Of `", stringify!($total), "`.")]
            pub $total: f64,)*
            $(#[doc = concat!("Of `", stringify!($number), "`.")]
            pub $number: f64,)*
        }

        impl Differential {
            /// This value as every derivative.
            pub fn all(balls: usize, value: f64) -> Self {
                let [balls, contacts] = [balls, balls.saturating_sub(1)].map(|count| vec![value; count]);
                Self {
                    $($ball: balls.clone(),)*
                    $($contact: contacts.clone(),)*
                    $($other: contacts.clone(),)*
                    $($total: value,)*
                    $($number: value,)*
                }
            }

            /// The weights of a linear `sum` of the derivatives.
            pub(crate) fn weights(balls: usize, sum: impl Fn(&Self) -> f64) -> Self {
                let (mut unit, mut weights) = (Self::all(balls, 0.0), Self::all(balls, 0.0));
                let with = |number: fn(&mut Self, usize) -> &mut f64, i: usize, unit: &mut Self| {
                    *number(unit, i) = 1.0;
                    let found = sum(unit);
                    *number(unit, i) = 0.0;
                    found
                };
                $((0..balls).for_each(|i| weights.$ball[i] = with(|unit, i| &mut unit.$ball[i], i, &mut unit));)*
                for j in 0..balls.saturating_sub(1) {
                    $(weights.$contact[j] = with(|unit, j| &mut unit.$contact[j], j, &mut unit);)*
                    $(weights.$other[j] = with(|unit, j| &mut unit.$other[j], j, &mut unit);)*
                }
                $(weights.$total = with(|unit, _| &mut unit.$total, 0, &mut unit);)*
                $(weights.$number = with(|unit, _| &mut unit.$number, 0, &mut unit);)*
                weights
            }

            /// The weighted sum; a derivative without weight need not be a number.
            pub(crate) fn dot(&self, weights: &Self) -> f64 {
                let sum = |of: &[f64], by: &[f64]| {
                    of.iter().zip(by).filter(|(_, by)| **by != 0.0).map(|(of, by)| of * by).sum::<f64>()
                };
                $(sum(&self.$ball, &weights.$ball) +)* $(sum(&self.$contact, &weights.$contact) +)*
                $(sum(&self.$other, &weights.$other) +)* $(sum(&[self.$total], &[weights.$total]) +)*
                $(sum(&[self.$number], &[weights.$number]) +)* 0.0
            }

            /// The derivatives for these balls, the contacts between them, and the whole cradle.
            pub(crate) fn of_balls(&self, balls: std::ops::Range<usize>) -> Self {
                let contacts = balls.start..balls.end - 1;
                Self {
                    $($ball: self.$ball[balls.clone()].to_vec(),)*
                    $($contact: self.$contact[contacts.clone()].to_vec(),)*
                    $($other: self.$other[contacts.clone()].to_vec(),)*
                    $($total: self.$total,)*
                    $($number: self.$number,)*
                }
            }

            /// Derivatives, along the tangent of `chain`, of the outputs that follow from its state and inputs; 0 for
            /// the others.
            pub(crate) fn along(chain: &dyn Chain<Dual>) -> Self {
                let [balls, contacts] = [chain.cradle().balls.len(), chain.cradle().contacts.len()];
                Self {
                    $($ball: (0..balls).map(|i| chain.$ball(i).tangent()).collect(),)*
                    $($contact: (0..contacts).map(|i| chain.$contact(i).tangent()).collect(),)*
                    $($total: chain.$total().tangent(),)*
                    ..Self::all(balls, 0.0)
                }
            }
        }
    };
}

differential! {
    of_balls: x v angle y a;
    of_contacts: force overlap overlap_rate;
    totals: total_energy momentum support_force support_force_vertical dissipation external_power;
    others_of_contacts: impulse force_mean force_peak;
    others: support_force_mean next_onset period dissipated_energy external_work;
}
