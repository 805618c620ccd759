//! A cluster, followed from switching to switching; see "Clusters" in docs/theory.md. Its state has displacements since
//! the start of the segment, and overlaps, because differences of positions do not resolve overlaps of 1e-8 m.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::gauss;
use super::modes::Modes;
use super::natural;
use super::radau;
use super::step_control::{Control, Method, Problem, StepHistory};
use super::taylor::{Series, velocity_scale};
use super::window::{DenseOutput, OverlapSeries, Switch, Window, WindowContact};
use crate::engine::flight::{
    Ball, Flight, Rounding, RunningIntegrals, integrals_of_inputs, places, shifted, start_by_centre,
};
use crate::engine::{EngineError, Forecast, Peak};
use crate::model::{BallModel, ContactLaw, Cradle, Mode, Pair};
use crate::solver::{DoubleDouble, MAX_FORCE_ORDER, Stretching};

/// Time scales of the fastest mode in which the first window by modes is searched for switchings.
const FIRST_HORIZON: f64 = 32.0;

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Cluster {
    /// Balls that touch another ball of the cluster.
    pub members: Range<usize>,
    /// Members and spectators.
    #[serde(skip)]
    pub window: Range<usize>,
    pub start: DoubleDouble,
    /// The balls of the window at the start of the segment.
    pub flights: Vec<Flight>,
    /// The contacts of the window, from `window.start` on, at the start of the segment.
    pub contacts: Vec<WindowContact>,
    /// Rates of the overlaps at the start, m/s, and components of the directions of the contacts along the paths.
    #[serde(skip)]
    rates: Vec<f64>,
    #[serde(skip)]
    along: Vec<[f64; 2]>,
    /// The method that describes the motion, and the working memory of every method.
    #[serde(skip)]
    method: Method,
    #[serde(skip)]
    series: Series,
    #[serde(skip)]
    gauss: Box<gauss::GaussStep>,
    #[serde(skip)]
    modes: Modes,
    /// The step history from here on, and at the start of the current segment.
    #[serde(skip)]
    pub history: StepHistory,
    pub history_before: StepHistory,
    /// Evaluations of contact forces for the current segment.
    #[serde(skip)]
    pub evaluations: u64,
    /// Length of the current segment, s.
    #[serde(skip)]
    pub length: f64,
    /// The switching at its end: contact and kind.
    #[serde(skip)]
    pub switch: Option<(usize, Switch)>,
}

impl Cluster {
    /// Begins a cluster of the balls `members`, with the other balls of `window` as spectators, in the memory of
    /// another cluster. Flights and contacts come later; then [`Self::expand`] computes the motion, with the history of
    /// earlier segments.
    pub fn renew(&mut self, members: Range<usize>, window: Range<usize>, start: DoubleDouble, history: StepHistory) {
        (self.members, self.window, self.start, self.history) = (members, window, start, history);
        self.flights.clear();
        self.contacts.clear();
    }

    /// Contacts of the window, as indices of the cradle.
    pub fn window_contacts(&self) -> Range<usize> {
        self.window.start..self.window.end - 1
    }

    /// The key of the cluster in the event queue: its first contact between members.
    pub fn key(&self) -> usize {
        self.members.start
    }

    pub fn end(&self) -> DoubleDouble {
        self.start + self.length
    }

    /// Fails if a ball or a contact of the window has left the range of doubles at the start of the segment.
    pub fn check_finite(&self) -> Result<(), EngineError> {
        let (time, first) = (self.start.value(), self.window.start);
        if let Some(ball) = self.flights.iter().position(|flight| !flight.is_finite()) {
            return Err(EngineError::NotFinite { time, ball: first + ball });
        }
        let contact = self.contacts.iter().position(|contact| !contact.overlap.is_finite());
        contact.map_or(Ok(()), |contact| Err(EngineError::ContactNotFinite { time, contact: first + contact }))
    }

    fn output(&self) -> &dyn DenseOutput {
        match self.method {
            Method::Modes => &self.modes,
            Method::Gauss => self.gauss.as_ref(),
            Method::Series | Method::Radau | Method::PairImpact => &self.series,
        }
    }

    /// Evaluations of closed forms that the search for the end of the segment has taken.
    pub fn searched(&self) -> u64 {
        self.output().searched()
    }

    /// Displacement of ball `i` of the window since the start of the segment (m) and velocity (m/s), `tau` after it.
    pub fn moved(&self, i: usize, tau: f64) -> (f64, f64) {
        let j = i - self.window.start;
        let (displacement, change) = self.output().moved(j, tau);
        (displacement, self.flights[j].v + change)
    }

    /// How time is stretched in the segment, so that forces are smooth.
    pub fn stretching(&self) -> Stretching {
        if self.method == Method::Gauss { self.gauss.stretching() } else { Stretching::None }
    }

    /// Overlap (m) and its rate (m/s) in contact `i` of the window, `tau` after the start of the segment.
    pub fn overlap(&self, i: usize, tau: f64) -> (f64, f64) {
        let j = i - self.window.start;
        let (overlap, change) = self.output().overlap(j, tau);
        (overlap, self.rates[j] + change)
    }

    /// Coefficients of the overlap of contact `i` of the window as a power series of the time (s) from `tau` after the
    /// start of the segment on; `None` if the equations give them as well.
    pub fn overlap_series(&self, i: usize, tau: f64) -> Option<OverlapSeries> {
        self.output().overlap_series(i - self.window.start, tau)
    }

    /// The first contact, by its index in the cradle, whose balls had changed sides at the start of the segment. Such a
    /// contact has a component along a path that is not positive.
    pub fn crossed(&self, cradle: &Cradle) -> Option<usize> {
        let crossed = |&j: &usize| {
            let places = || [j, j + 1].map(|i| self.flights[i].x);
            self.along[j].iter().any(|part| *part <= 0.0) && cradle.pair(self.window.start + j).changed_sides(places())
        };
        (0..self.along.len()).find(crossed).map(|j| self.window.start + j)
    }

    pub fn mode(&self, i: usize) -> Mode {
        self.contacts[i - self.window.start].mode
    }

    /// Impulse of contact `i` from the start of the segment to `tau`, N.s.
    pub fn impulse(&self, i: usize, tau: f64) -> f64 {
        match self.mode(i) {
            Mode::Pressing => self.output().impulse(i - self.window.start, tau),
            Mode::Open | Mode::Clipped => 0.0,
        }
    }

    /// The largest force of contact `i` between these times (s); all times count from the start of the segment. `None`
    /// if it presses with less than the force `known` (N), or not at all.
    pub fn peak(&self, i: usize, from: f64, to: f64, known: f64) -> Option<Peak> {
        match self.mode(i) {
            Mode::Pressing if from < to => self.output().peak(i - self.window.start, from, to, known),
            _ => None,
        }
    }

    /// The larger of `known` (N) and the largest force of contact `i` between these times, N.
    pub fn largest_force(&self, i: usize, from: f64, to: f64, known: f64) -> f64 {
        self.peak(i, from, to, known).map_or(known, |peak| peak.force.max(known))
    }

    /// Energy that contact `i` dissipates from the start of the segment to `tau`, J.
    pub fn contact_loss(&self, i: usize, law: &ContactLaw, tau: f64) -> f64 {
        match self.mode(i) {
            Mode::Pressing if !law.is_elastic() => self.output().contact_loss(i - self.window.start, tau),
            // The energy left in the spring is lost.
            Mode::Clipped => {
                let before = self.contacts[i - self.window.start].overlap;
                law.elastic_energy(before) - law.elastic_energy(self.overlap(i, tau).0)
            }
            _ => 0.0,
        }
    }

    /// The running integrals of member `i` at `tau`, from `integrals` at the start of the segment.
    pub fn integrals(&self, i: usize, integrals: &RunningIntegrals, ball: &Ball, tau: f64) -> RunningIntegrals {
        let j = i - self.window.start;
        let flight = &self.flights[j];
        let mut integrals = *integrals;
        let BallModel { gamma, mass, omega2, .. } = ball.model;
        if ball.model.on_arc {
            integrals.add(&integrals_of_inputs(&ball.model, flight, tau, &|t| self.output().moved(j, t).0));
        } else {
            integrals.support += omega2 * (flight.x * tau + self.output().displacement_integral(j, tau));
            if flight.forcing != [0.0; MAX_FORCE_ORDER + 1] {
                integrals.work += mass * self.output().work(j, &flight.forcing, tau);
            }
            if gamma > 0.0 {
                integrals.support += 2.0 * gamma * self.output().moved(j, tau).0;
            }
        }
        if gamma > 0.0 {
            integrals.drag_loss += 2.0 * gamma * mass * self.output().squared_velocity_integral(j, tau);
        }
        integrals
    }

    /// Moves the start of the segment to `tau` (s) later. The spectators follow their flights.
    pub fn move_start(&mut self, tau: f64, balls: &[Ball], laws: &[ContactLaw]) {
        self.start += tau;
        for j in 0..self.contacts.len() {
            self.contacts[j].overlap = self.output().overlap(j, tau).0;
        }
        for j in 0..self.flights.len() {
            let i = self.window.start + j;
            self.flights[j] = if self.members.contains(&i) {
                let (flight, (displacement, change)) = (self.flights[j], self.output().moved(j, tau));
                Flight { x: flight.x + displacement, v: flight.v + change, forcing: shifted(&flight.forcing, tau) }
            } else {
                balls[i].flight_at(self.start)
            };
        }
        self.align(&balls[self.window.clone()], &laws[self.window_contacts()]);
    }

    /// Fits positions of balls in contact to the overlaps, about their centre of mass: see "Clusters" in
    /// docs/theory.md.
    fn align(&mut self, balls: &[Ball], laws: &[ContactLaw]) {
        let mut first = 0;
        for end in 0..balls.len() {
            if self.contacts.get(end).is_some_and(|contact| contact.mode != Mode::Open) {
                continue;
            }
            if first < end {
                let (balls, flights) = (&balls[first..=end], &mut self.flights[first..=end]);
                let (contacts, laws) = (&self.contacts[first..end], &laws[first..end]);
                if balls[0].model.on_arc {
                    align_along_arcs(flights, balls, contacts, laws, &self.along[first..end]);
                } else {
                    let masses = balls.iter().map(|ball| ball.model.mass);
                    let contacts = contacts.iter().zip(laws);
                    let places = places(contacts.map(|(contact, law)| contact.overlap + law.clearance));
                    let start = start_by_centre(masses.zip(flights.iter().map(|flight| flight.x)).zip(places.clone()));
                    flights.iter_mut().zip(places).for_each(|(flight, place)| flight.x = start + place);
                }
            }
            first = end + 1;
        }
    }

    /// Describes the motion from the start of the segment on and finds where the segment ends.
    pub fn expand(&mut self, balls: &[Ball], cradle: &Cradle, control: &Control) {
        let (flights, contacts) = (std::mem::take(&mut self.flights), std::mem::take(&mut self.contacts));
        let (balls, models) = (&balls[self.window.clone()], &cradle.balls[self.window.clone()]);
        let laws = &cradle.contacts[self.window_contacts()];
        let window = Window { flights: &flights, models, balls, contacts: &contacts, laws };
        self.along.clear();
        self.along.extend((0..laws.len()).map(|j| window.parts_along(j)));
        self.rates.clear();
        let rate = |(j, [left, right]): (usize, &[f64; 2])| flights[j].v * left - flights[j + 1].v * right;
        self.rates.extend(self.along.iter().enumerate().map(rate));
        let rounding = flights.iter().zip(balls).map(|(flight, ball)| flight.rounding(&ball.oscillator));
        let rounding = rounding.fold(Rounding::default(), Rounding::max);
        self.history_before = self.history;
        let speed = velocity_scale(&window);
        let local_error = control.local_error(speed);
        let error = self.describe(&Problem { window: &window, control, rounding, speed, local_error });
        self.switch = None;
        // Switchings within the error of a step are as unreal as those by rounding.
        let rounding = Rounding { velocity: rounding.velocity.max(error), ..rounding };
        for j in 0..laws.len() {
            match self.first_switch(j, &window, self.length, &rounding) {
                (Forecast::At(tau), switch) => {
                    (self.length, self.switch) = (tau, Some((self.window.start + j, switch)))
                }
                (Forecast::NotBefore(tau), _) => (self.length, self.switch) = (tau, None),
                (Forecast::Never, _) => {}
            }
        }
        if self.switch.is_some() {
            (self.history.quiet, self.history.patience) = (0, StepHistory::default().patience);
        } else {
            self.history.quiet = self.history.quiet.saturating_add(1);
        }
        (self.flights, self.contacts) = (flights, contacts);
    }

    /// The first switching of contact `j` of the `window` before `until` (s), by more than `rounding`.
    fn first_switch(&self, j: usize, window: &Window, until: f64, rounding: &Rounding) -> (Forecast, Switch) {
        let first = |switch: Switch, until: f64| self.output().first(switch, j, window, until, rounding);
        let mode = window.contacts[j].mode;
        if mode == Mode::Open {
            return (first(Switch::Onset, until), Switch::Onset);
        }
        let release = first(Switch::Release, until);
        if window.laws[j].clips() {
            let until = if let Forecast::At(tau) | Forecast::NotBefore(tau) = release { tau } else { until };
            let clip = first(Switch::Clip, until);
            if clip != Forecast::Never {
                return (clip, Switch::Clip);
            }
        }
        (release, Switch::Release)
    }

    /// Describes the motion by the first method that applies, for as long as the description holds. Returns its error
    /// in the velocities, m/s.
    fn describe(&mut self, problem: &Problem) -> f64 {
        let Self { method, series, gauss, modes, history, evaluations, .. } = self;
        let &Problem { window, control, speed, local_error, .. } = problem;
        *evaluations = window.contacts.iter().filter(|contact| contact.mode != Mode::Open).count() as u64;
        let linear = window.is_linear();
        // Linear contacts: closed forms until the next switching, after some segments by series.
        let modes_serve = linear && control.allows(Method::Modes);
        let series_first = if modes_serve { natural::series_before_modes(window) } else { None };
        // Number of segments by modes so far; `Some(None)` while series come first.
        let windows = series_first.map(|series| history.quiet.checked_sub(series));
        if let Some(Some(windows)) = windows
            && let Some(found) = Modes::new(window)
        {
            // The horizon of the search for switchings grows while nothing happens.
            let (time, longest) = (found.shortest_time(), control.longest);
            let first = if time < longest { FIRST_HORIZON * time } else { 1.0 };
            self.length = (first * libm::exp2(windows.min(60) as f64)).min(longest);
            (*modes, *method, *evaluations) = (found, Method::Modes, 1);
            return 0.0;
        }
        // Contacts that are stiff compared to the pace of the motion, or closed for long: steps follow the slow motion.
        // For linear contacts explicit steps do not pay, because their series cost little.
        let by_series = linear && control.allows(Method::Series);
        let by_gauss = !by_series && control.allows(Method::Gauss) && gauss::applies_to(window, speed);
        let gain = if by_gauss { radau::GAIN_OVER_GAUSS } else { radau::GAIN_OVER_SERIES };
        if windows != Some(None)
            && control.allows(Method::Radau)
            && radau::follow(series, history, problem, gain, evaluations)
        {
            (self.length, *method) = (series.converges_for, Method::Radau);
            return local_error;
        }
        // Nonlinear contacts: explicit steps from one branch point of their forces to the next.
        let before = history.explicit_length;
        if by_gauss && let Some(step) = gauss.follow(problem, before, evaluations) {
            ((self.length, history.explicit_length), *method) = (step, Method::Gauss);
            return local_error;
        }
        // Linear contacts, a start from rest, stiff damping: series keep balls that nothing has moved exactly at rest.
        series.expand_window(problem);
        (self.length, history.explicit_length, *method) = (series.converges_for, series.converges_for, Method::Series);
        local_error
    }
}

/// Fits positions to overlaps as [`Cluster::align`] does, for a row of balls on arcs. `along` has the components of the
/// contacts' directions along the paths. Each contact gets the overlap that it lacks by a Lagrange
/// multiplier, which moves its balls as an impulse would.
///
/// With the missing overlaps e, the matrix of the parts `D = (l_1, -r_1; 0, l_2, -r_2; ...)`, and the masses M, the
/// multipliers p solve `D M^-1 D' p = e` and move the balls by `M^-1 D' p`.
fn align_along_arcs(
    flights: &mut [Flight],
    balls: &[Ball],
    contacts: &[WindowContact],
    laws: &[ContactLaw],
    along: &[[f64; 2]],
) {
    // A multiplier increases the overlap of its contact by `share` and reduces that of the next one: Gaussian
    // elimination.
    let moves = |j: usize| [0, 1].map(|k| along[j][k] / balls[j + k].model.mass);
    let beside = |j: usize| along[j][0] * moves(j - 1)[1];
    let mut rows: Vec<[f64; 2]> = Vec::with_capacity(contacts.len());
    for (j, [left, right]) in along.iter().enumerate() {
        let pair = Pair { balls: [&balls[j].model, &balls[j + 1].model], law: &laws[j] };
        let lacks = contacts[j].overlap - pair.overlap([flights[j].x, flights[j + 1].x]);
        let ([l, r], last) = (moves(j), rows.last());
        let [less, more] =
            last.map_or([0.0; 2], |[share, lacks]| [beside(j), *lacks].map(|own| own * beside(j) / share));
        rows.push([left * l + right * r - less, lacks + more]);
    }
    let mut multiplier = 0.0;
    for (j, [share, lacks]) in rows.into_iter().enumerate().rev() {
        let by_next = if j + 1 < along.len() { beside(j + 1) * multiplier } else { 0.0 };
        multiplier = (lacks + by_next) / share;
        let [l, r] = moves(j);
        (flights[j].x, flights[j + 1].x) = (flights[j].x + multiplier * l, flights[j + 1].x - multiplier * r);
    }
}
