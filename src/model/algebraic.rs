//! The outputs that follow from the state and the inputs at one time, for any method, in doubles or dual numbers.

use super::arc::{Line, Place};
use super::contact::ContactLaw;
use super::cradle::{BallModel, Cradle};
use super::results::Differential;
use crate::solver::dual::{Dual, Scalar};

/// A cradle in a state. Balls and contacts are counted from 0; contact `i` is that of balls `i` and `i + 1`.
pub(crate) trait Chain<S: Scalar = f64> {
    /// The coefficients of its equations.
    fn cradle(&self) -> &Cradle<S>;
    /// Position (m) and velocity (m/s) of ball `i`, along its path.
    fn state_of(&self, i: usize) -> (S, S);
    /// Overlap of contact `i`, m.
    fn overlap_of(&self, i: usize) -> S;
    /// Force of contact `i`, N.
    fn force_of(&self, i: usize) -> S;
    /// Acceleration of ball `i` by the external forces and the support, m/s2.
    fn forcing_of(&self, i: usize) -> S;
}

/// The place of ball `i` on its path.
fn place<S: Scalar>(chain: &dyn Chain<S>, i: usize) -> Place<S> {
    chain.cradle().balls[i].place(chain.state_of(i).0)
}

/// The sum of the contact forces on ball `i` along its path, and that away from the pivot, N.
fn pushed<S: Scalar>(chain: &dyn Chain<S>, i: usize) -> [S; 2] {
    let contacts = &chain.cradle().contacts;
    let from_left = if i > 0 { chain.force_of(i - 1) } else { S::default() };
    let from_right = if i < contacts.len() { chain.force_of(i) } else { S::default() };
    if !chain.cradle().balls[i].on_arc {
        return [from_left - from_right, S::default()];
    }
    let (mut sum, own) = ([S::default(); 2], place(chain, i));
    for (force, j) in [(from_left, i.wrapping_sub(1)), (-from_right, i)] {
        // Balls far apart need no direction.
        if force != S::default() {
            let [left, right] = [j, j + 1].map(|k| if k == i { own } else { place(chain, k) });
            let line = Line::new(&left, &right, contacts[j].pivots);
            sum[0] += force * line.along(&own);
            sum[1] += force * line.outward(&own);
        }
    }
    sum
}

/// Horizontal and vertical force, upwards, of ball `i` on the support, N: by the tension of its string and the drag.
fn on_support<S: Scalar>(chain: &dyn Chain<S>, i: usize) -> [S; 2] {
    let (ball, (s, u)) = (&chain.cradle().balls[i], chain.state_of(i));
    if !ball.on_arc {
        return [ball.support_force(s, u), -ball.mass * ball.gravity];
    }
    let Place { sin, cos, .. } = ball.place(s);
    let pull = ball.gravity * cos + u * u / ball.length + chain.forcing_of(i) * sin;
    let (tension, drag) = (ball.mass * pull + pushed(chain, i)[1], S::from(2.0) * ball.gamma * ball.mass * u);
    [tension * sin + drag * cos, drag * sin - tension * cos]
}

// The functions of `Results`, which has their units.

pub(crate) fn x<S: Scalar>(chain: &dyn Chain<S>, i: usize) -> S {
    place(chain, i).x
}

pub(crate) fn v<S: Scalar>(chain: &dyn Chain<S>, i: usize) -> S {
    chain.state_of(i).1 * place(chain, i).cos
}

pub(crate) fn angle<S: Scalar>(chain: &dyn Chain<S>, i: usize) -> S {
    chain.state_of(i).0 / chain.cradle().balls[i].length
}

pub(crate) fn y<S: Scalar>(chain: &dyn Chain<S>, i: usize) -> S {
    place(chain, i).y
}

pub(crate) fn a<S: Scalar>(chain: &dyn Chain<S>, i: usize) -> S {
    let (ball, (s, u)) = (&chain.cradle().balls[i], chain.state_of(i));
    let [force, _] = pushed(chain, i);
    if !ball.on_arc {
        return ball.acceleration(s, u, force, chain.forcing_of(i));
    }
    let Place { sin, cos, .. } = ball.place(s);
    let gravity = ball.gravity * sin;
    let along = force / ball.mass + chain.forcing_of(i) * cos - gravity - S::from(2.0) * ball.gamma * u;
    along * cos - u * u / ball.length * sin
}

pub(crate) fn kinetic_energy<S: Scalar>(chain: &dyn Chain<S>, i: usize) -> S {
    let (_, v) = chain.state_of(i);
    S::from(0.5) * chain.cradle().balls[i].mass * v * v
}

pub(crate) fn gravity_energy<S: Scalar>(chain: &dyn Chain<S>, i: usize) -> S {
    let (ball, (x, _)) = (&chain.cradle().balls[i], chain.state_of(i));
    if ball.on_arc {
        return ball.mass * ball.gravity * ball.place(x).y;
    }
    S::from(0.5) * ball.mass * ball.omega2 * x * x
}

pub(crate) fn contact_energy<S: Scalar>(chain: &dyn Chain<S>, i: usize) -> S {
    chain.cradle().contacts[i].elastic_energy(chain.overlap_of(i))
}

pub(crate) fn total_energy<S: Scalar>(chain: &dyn Chain<S>) -> S {
    let Cradle { balls, contacts, .. } = chain.cradle();
    let of_ball = |(i, ball): (usize, &BallModel<S>)| {
        if ball.on_arc {
            return kinetic_energy(chain, i) + gravity_energy(chain, i);
        }
        let (x, v) = chain.state_of(i);
        S::from(0.5) * ball.mass * (v * v + ball.omega2 * x * x)
    };
    balls.iter().enumerate().map(of_ball).sum::<S>() + (0..contacts.len()).map(|i| contact_energy(chain, i)).sum()
}

pub(crate) fn momentum<S: Scalar>(chain: &dyn Chain<S>) -> S {
    chain.cradle().balls.iter().enumerate().map(|(i, ball)| ball.mass * v(chain, i)).sum()
}

pub(crate) fn support_force<S: Scalar>(chain: &dyn Chain<S>) -> S {
    (0..chain.cradle().balls.len()).map(|i| on_support(chain, i)[0]).sum()
}

pub(crate) fn support_force_vertical<S: Scalar>(chain: &dyn Chain<S>) -> S {
    (0..chain.cradle().balls.len()).map(|i| on_support(chain, i)[1]).sum()
}

pub(crate) fn overlap_rate<S: Scalar>(chain: &dyn Chain<S>, i: usize) -> S {
    chain.cradle().pair(i).overlap_rate([chain.state_of(i), chain.state_of(i + 1)])
}

pub(crate) fn dissipation<S: Scalar>(chain: &dyn Chain<S>) -> S {
    let Cradle { balls, contacts, .. } = chain.cradle();
    let of_ball = |(i, ball): (usize, &BallModel<S>)| {
        let (_, v) = chain.state_of(i);
        S::from(2.0) * ball.gamma * ball.mass * v * v
    };
    let of_contact = |(i, law): (usize, &ContactLaw<S>)| {
        let excess = chain.force_of(i) - law.elastic_force(chain.overlap_of(i));
        excess * overlap_rate(chain, i)
    };
    balls.iter().enumerate().map(of_ball).sum::<S>() + contacts.iter().enumerate().map(of_contact).sum()
}

pub(crate) fn external_power<S: Scalar>(chain: &dyn Chain<S>) -> S {
    let of_ball = |(i, ball): (usize, &BallModel<S>)| ball.mass * chain.forcing_of(i) * v(chain, i);
    chain.cradle().balls.iter().enumerate().map(of_ball).sum()
}

impl Differential {
    /// Derivatives of these outputs by the state of `chain` and the inputs.
    pub(crate) fn along(chain: &dyn Chain<Dual>) -> Self {
        let Cradle { balls, contacts, .. } = chain.cradle();
        let of_balls = |value: &dyn Fn(usize) -> Dual| (0..balls.len()).map(|i| value(i).tangent()).collect();
        let of_contacts = |value: &dyn Fn(usize) -> Dual| (0..contacts.len()).map(|i| value(i).tangent()).collect();
        Self {
            x: of_balls(&|i| x(chain, i)),
            v: of_balls(&|i| v(chain, i)),
            angle: of_balls(&|i| angle(chain, i)),
            y: of_balls(&|i| y(chain, i)),
            a: of_balls(&|i| a(chain, i)),
            force: of_contacts(&|i| chain.force_of(i)),
            overlap: of_contacts(&|i| chain.overlap_of(i)),
            overlap_rate: of_contacts(&|i| overlap_rate(chain, i)),
            energy: total_energy(chain).tangent(),
            momentum: momentum(chain).tangent(),
            support_force: support_force(chain).tangent(),
            support_force_vertical: support_force_vertical(chain).tangent(),
            dissipation: dissipation(chain).tangent(),
            external_power: external_power(chain).tangent(),
            ..Self::zero(balls.len())
        }
    }
}

/// Implements those functions of [`Results`](super::Results) that the state and the inputs of a [`Chain`] determine,
/// with the `energy_at_start`.
macro_rules! algebraic_results {
    ($self:ident, $energy_at_start:expr) => {
        algebraic_results!($self, $self, $energy_at_start);

        fn force(&$self, i: usize) -> f64 {
            $self.force_of(i)
        }

        fn overlap(&$self, i: usize) -> f64 {
            $self.overlap_of(i)
        }

        fn in_contact(&$self, i: usize) -> bool {
            $self.overlap_of(i) > 0.0
        }

        fn force_mean(&$self, i: usize) -> f64 {
            if $self.step_length() == 0.0 { $self.force(i) } else { $self.impulse_of_step(i) / $self.step_length() }
        }

        fn support_force_mean(&$self) -> f64 {
            let length = $self.step_length();
            if length == 0.0 { $self.support_force() } else { $self.support_impulse_of_step() / length }
        }
    };
    ($self:ident, $chain:expr, $energy_at_start:expr) => {
        algebraic_results! {
            $self, $chain; x(i) v(i) angle(i) y(i) a(i) overlap_rate(i) kinetic_energy(i) gravity_energy(i)
            contact_energy(i) total_energy() momentum() support_force() support_force_vertical() dissipation()
            external_power()
        }

        fn energy_residual(&$self) -> f64 {
            ($self.total_energy() - $energy_at_start) + ($self.dissipated_energy() - $self.external_work())
        }
    };
    ($self:ident, $chain:expr; $($name:ident($($i:ident)?))*) => {
        $(fn $name(&$self $(, $i: usize)?) -> f64 {
            algebraic::$name($chain $(, $i)?)
        })*
    };
}
pub(crate) use algebraic_results;
