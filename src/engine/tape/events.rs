//! What happens at one instant, linearised: a shift of the time itself, the jump of a force, the start of the last
//! step, the peak of a force.

use super::coefficients::{BEFORE, CLEARANCE, Coefficients, IMPULSE, LENGTH, MASS, OVERLAP, PEAK, STATE, TIME, V, X};
use super::nodes::ContactNodes;
use super::part::Part;
use crate::model::{Cradle, Linkage};

/// The overlap of a contact as a function of the state and of the coefficients.
#[derive(Debug)]
pub(super) struct Overlap {
    pub contact: usize,
    pub linkage: Linkage,
    /// Velocities of its balls, m/s; 0 for the overlap at the time at which the states of both hold.
    pub velocities: [f64; 2],
}

impl Overlap {
    /// The overlap between balls in these states (m, m/s).
    pub fn new(cradle: &Cradle, contact: usize, states: [(f64, f64); 2]) -> Self {
        let linkage = cradle.pair(contact).linkage(states.map(|(x, _)| x));
        Self { contact, linkage, velocities: states.map(|(_, v)| v) }
    }

    /// The overlap at the time at which the states of both balls hold, instead of at the common time.
    pub fn at_one_time(self) -> Self {
        Self { velocities: [0.0; 2], ..self }
    }

    /// Rate of the overlap, m/s.
    pub fn rate(&self) -> f64 {
        let ([left, right], [v, w]) = (self.linkage.along, self.velocities);
        left * v - right * w
    }

    pub fn change(&self, changes: &Coefficients, state: &[f64]) -> f64 {
        let (j, by) = (self.contact, &self.linkage.by[0]);
        let [l, r] = [0, 1].map(|k| {
            let of = &state[(j + k) * STATE..];
            of[X] - self.velocities[k] * of[TIME]
        });
        let [.., left_length, right_length, pivots] = changes.of_linkage(j);
        let numbers = [l, r, left_length, right_length, pivots];
        by.iter().zip(numbers).map(|(by, change)| by * change).sum::<f64>() - changes.of_ball(j)[CLEARANCE]
    }

    /// Adds the derivatives of a number by state and coefficients, from its derivative by the overlap.
    pub fn back(&self, by_overlap: f64, by_changes: &mut Coefficients, by_state: &mut [f64]) {
        let (j, by) = (self.contact, self.linkage.by[0].map(|by| by_overlap * by));
        for k in 0..2 {
            let of = &mut by_state[(j + k) * STATE..];
            of[X] += by[k];
            of[TIME] -= by[k] * self.velocities[k];
        }
        by_changes.add_of_linkage(j, &by);
        by_changes.of_ball_mut(j)[CLEARANCE] -= by_overlap;
    }
}

/// From here on the states of neighbours hold at a later time, or again at the common one.
///
/// If a contact closes later by a change `dt`, its force at a fixed time changes by its rate times `dt`: the angular
/// frequency of the contact, some 1e5 1/s, makes that far more than is left once the contact has opened. At times later
/// by `dt`, too, the force changes little. So neighbours that press on each other have a time of their own, from their
/// onset.
#[derive(Debug)]
pub(super) struct TimeShift {
    pub first: usize,
    /// For each ball that is moved in time: velocity (m/s) and acceleration (m/s2), and for the contact at its right
    /// the force (N) and the rate of the overlap (m/s).
    pub balls: Vec<Option<[f64; 4]>>,
    pub to: Time,
}

/// A time at which states hold.
#[derive(Debug)]
pub(super) enum Time {
    Common,
    /// The time at which this overlap vanishes.
    Onset(Overlap),
    /// The time of this ball.
    Of(usize),
}

impl Part for TimeShift {
    fn numbers(&self) -> usize {
        4 * self.balls.len() + 20
    }

    fn forward(&self, _: &Cradle, changes: &Coefficients, state: &mut [f64]) {
        let later = match &self.to {
            Time::Common => 0.0,
            Time::Onset(overlap) => -overlap.change(changes, state) / overlap.rate(),
            Time::Of(ball) => state[ball * STATE + TIME],
        };
        for (motion, state) in self.balls.iter().zip(state[self.first * STATE..].chunks_mut(STATE)) {
            if let Some([v, a, force, rate]) = motion {
                let shift = later - state[TIME];
                state[X] += v * shift;
                state[V] += a * shift;
                state[IMPULSE] += force * shift;
                state[OVERLAP] += rate * shift;
                state[TIME] = later;
            }
        }
    }

    fn backward(&self, _: &Cradle, by_changes: &mut Coefficients, by_state: &mut [f64]) {
        let mut by_later = 0.0;
        for (motion, by) in self.balls.iter().zip(by_state[self.first * STATE..].chunks_mut(STATE)) {
            if let Some([v, a, force, rate]) = motion {
                let by_shift = v * by[X] + a * by[V] + force * by[IMPULSE] + rate * by[OVERLAP];
                by_later += by[TIME] + by_shift;
                by[TIME] = -by_shift;
            }
        }
        match &self.to {
            Time::Common => {}
            Time::Onset(overlap) => overlap.back(-by_later / overlap.rate(), by_changes, by_state),
            Time::Of(ball) => by_state[ball * STATE + TIME] += by_later,
        }
    }
}

/// A contact presses from here on, with this overlap; without one at its own onset.
#[derive(Debug)]
pub(super) struct Closing {
    pub contact: usize,
    pub overlap: Option<Overlap>,
}

impl Part for Closing {
    fn numbers(&self) -> usize {
        20
    }

    fn forward(&self, _: &Cradle, changes: &Coefficients, state: &mut [f64]) {
        let overlap = self.overlap.as_ref().map_or(0.0, |overlap| overlap.change(changes, state));
        state[self.contact * STATE + OVERLAP] = overlap;
    }

    fn backward(&self, _: &Cradle, by_changes: &mut Coefficients, by_state: &mut [f64]) {
        let by_overlap = std::mem::take(&mut by_state[self.contact * STATE + OVERLAP]);
        if let Some(overlap) = &self.overlap {
            overlap.back(by_overlap, by_changes, by_state);
        }
    }
}

/// A contact closes or opens while its force is not 0.
#[derive(Debug)]
pub(super) struct Jump {
    pub contact: usize,
    /// Components of its direction along the paths of its balls.
    pub along: [f64; 2],
    /// Jump of the force over the rate of the overlap, N.s/m. A change of the overlap over that rate is the change of
    /// the time of the jump.
    pub growth: f64,
}

impl Jump {
    /// The changes of the impulse and of the two velocities, for a unit of change of the overlap.
    fn by_overlap(&self, cradle: &Cradle) -> [(usize, f64); 3] {
        let (j, [left, right]) = (self.contact, self.along);
        let on_ball = |i: usize, part: f64| (i * STATE + V, part * self.growth / cradle.balls[i].mass);
        [(j * STATE + IMPULSE, self.growth), on_ball(j, -left), on_ball(j + 1, right)]
    }
}

impl Part for Jump {
    fn numbers(&self) -> usize {
        4
    }

    fn forward(&self, cradle: &Cradle, _: &Coefficients, state: &mut [f64]) {
        let overlap = state[self.contact * STATE + OVERLAP];
        self.by_overlap(cradle).into_iter().for_each(|(number, by)| state[number] += by * overlap);
    }

    fn backward(&self, cradle: &Cradle, _: &mut Coefficients, by_state: &mut [f64]) {
        let by_overlap: f64 = self.by_overlap(cradle).into_iter().map(|(number, by)| by * by_state[number]).sum();
        by_state[self.contact * STATE + OVERLAP] += by_overlap;
    }
}

/// The last step begins, for one ball in this state (m, m/s) and the contact at its right.
#[derive(Debug)]
pub(super) struct LastStepBegins {
    pub ball: usize,
    pub state: (f64, f64),
}

impl LastStepBegins {
    /// The derivatives of the ball's momentum by position, velocity, mass and length.
    fn of_momentum(&self, cradle: &Cradle) -> [f64; 4] {
        let (model, (x, v)) = (&cradle.balls[self.ball], self.state);
        let place = model.place(x);
        let by_angle = -model.mass * v * place.sin;
        [by_angle / model.length, model.mass * place.cos, v * place.cos, -by_angle * x / (model.length * model.length)]
    }
}

impl Part for LastStepBegins {
    fn numbers(&self) -> usize {
        3
    }

    fn forward(&self, cradle: &Cradle, changes: &Coefficients, state: &mut [f64]) {
        let (of, at, [by_x, by_v, by_mass, by_length]) =
            (changes.of_ball(self.ball), self.ball * STATE, self.of_momentum(cradle));
        let change = by_x * state[at + X] + by_v * state[at + V] + by_mass * of[MASS] + by_length * of[LENGTH];
        if let Some(momentum) = state.last_mut() {
            *momentum += change;
        }
        (state[at + BEFORE], state[at + PEAK]) = (state[at + IMPULSE], 0.0);
    }

    fn backward(&self, cradle: &Cradle, by_changes: &mut Coefficients, by_state: &mut [f64]) {
        let (at, [by_x, by_v, by_mass, by_length]) = (self.ball * STATE, self.of_momentum(cradle));
        let by = by_state.last().copied().unwrap_or_default();
        by_state[at + IMPULSE] += std::mem::take(&mut by_state[at + BEFORE]);
        by_state[at + PEAK] = 0.0;
        by_state[at + X] += by * by_x;
        by_state[at + V] += by * by_v;
        let of = by_changes.of_ball_mut(self.ball);
        of[MASS] += by * by_mass;
        of[LENGTH] += by * by_length;
    }
}

/// The force of a contact at a time at which it exceeds all before it in the step.
#[derive(Debug)]
pub(super) struct PeakPart {
    pub contact: usize,
    /// The contact at that time.
    pub at: ContactNodes<1>,
    /// At an onset, derivative of the force by the overlap, which changes the time of the onset, N/m; otherwise 0.
    pub by_overlap: f64,
    /// By how much a later time lowers the force, N/s, at the end of a motion on the way to the peak; otherwise 0.
    pub by_time: f64,
}

impl Part for PeakPart {
    fn numbers(&self) -> usize {
        self.at.numbers()
    }

    fn forward(&self, cradle: &Cradle, changes: &Coefficients, state: &mut [f64]) {
        let j = self.contact;
        let of_coefficients =
            self.at.by_coefficients(&cradle.contacts[j], j, changes).map_or(0.0, |[force, ..]| force[0]);
        let [places, v] = [X, V].map(|number| [j, j + 1].map(|i| state[i * STATE + number]));
        let [overlap, later] = [OVERLAP, TIME].map(|number| state[j * STATE + number]);
        let of_motion = self.at.by_start(0, overlap, places).0 + self.at.by_moves(0, [[0.0; 2], v]).0;
        let of_time = self.by_overlap * overlap - self.by_time * later;
        state[j * STATE + PEAK] = of_motion + of_coefficients + of_time;
    }

    fn backward(&self, cradle: &Cradle, by_changes: &mut Coefficients, by_state: &mut [f64]) {
        let j = self.contact;
        let by_peak = std::mem::take(&mut by_state[j * STATE + PEAK]);
        let (by_overlap, by_places) = self.at.to_start(0, by_peak, [0.0; 2]);
        let [_, by_v] = self.at.to_moves(0, by_peak, [0.0; 2]);
        for k in 0..2 {
            by_state[(j + k) * STATE + X] += by_places[k];
            by_state[(j + k) * STATE + V] += by_v[k];
        }
        let by_contact = &mut by_state[j * STATE..];
        by_contact[OVERLAP] += by_overlap + self.by_overlap * by_peak;
        by_contact[TIME] -= self.by_time * by_peak;
        self.at.add_derivatives(&cradle.contacts[j], j, [&[by_peak], &[0.0], &[0.0]], by_changes);
    }
}
