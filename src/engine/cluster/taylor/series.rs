//! The motions and forces of a window as power series of the time, with their dense output. The coefficients come from
//! `recurrences` or from `radau`.

use super::arcs::ArcSeries;
use crate::engine::cluster::window::{DenseOutput, OverlapSeries, Switch, Window, sign_after_clip};
use crate::engine::flight::{Forcing, Rounding, degree};
use crate::engine::{Forecast, Peak};
use crate::model::{BallModel, ContactLaw, Mode};
use crate::solver::quadrature::{self, POINTS};
use crate::solver::series::{self, MOST};
use crate::solver::{MAX_FORCE_ORDER, crossing};

/// Parts of a segment at which a contact that has closed from rest is checked.
const PARTS: [f64; 3] = [1.0 / 64.0, 1.0 / 8.0, 1.0];

/// Coefficients of the motions and forces of a window, as functions of the time since the start over `unit`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Series {
    /// Order of the velocities; displacements have one more.
    pub(crate) order: usize,
    /// Number of coefficients in a row.
    pub(crate) stride: usize,
    /// Unit of time of the series, s, near their radius of convergence, so that high powers do not overflow.
    pub(crate) unit: f64,
    /// For each ball: displacement since the start of the segment, m.
    pub(crate) displacements: Vec<f64>,
    /// For each contact: overlap, m.
    pub(crate) overlaps: Vec<f64>,
    /// For each contact: elastic force, and the unclipped force of the law, N; zero where the contact is open.
    pub(crate) elastic: Vec<f64>,
    pub(crate) forces: Vec<f64>,
    /// For each contact: the coefficient of its dashpot, N.s/m, or 0 if its damping force is another one.
    dashpots: Vec<f64>,
    /// The geometry, where balls move on arcs.
    pub(super) arcs: ArcSeries,
    /// Number of last terms from which the convergence is estimated.
    pub(super) terms: usize,
    /// How long the series converge to the tolerance, s.
    pub(crate) converges_for: f64,
}

impl Series {
    pub(crate) fn row<'a>(&self, rows: &'a [f64], j: usize) -> &'a [f64] {
        &rows[j * self.stride..][..self.order + 2]
    }

    /// Displacement of ball `i` since the start, m.
    pub(crate) fn displacement(&self, i: usize) -> &[f64] {
        self.row(&self.displacements, i)
    }

    /// Overlap of contact `j`, m.
    pub(crate) fn overlap_row(&self, j: usize) -> &[f64] {
        self.row(&self.overlaps, j)
    }

    /// Elastic force of contact `j`, N; zero while it is open.
    pub(crate) fn elastic_row(&self, j: usize) -> &[f64] {
        &self.row(&self.elastic, j)[..self.order]
    }

    /// Force of contact `j` by its law without clipping, N; zero while it is open.
    pub(crate) fn force_row(&self, j: usize) -> &[f64] {
        &self.row(&self.forces, j)[..self.order]
    }

    /// Coefficients of the derivative of a row by time.
    pub(crate) fn rate(&self, row: &[f64]) -> Vec<f64> {
        row.iter().enumerate().skip(1).map(|(k, c)| k as f64 * *c / self.unit).collect()
    }

    /// Overlap of contact `j` (m) and its rate (m/s) at the scaled time `s`.
    pub(crate) fn overlap_at(&self, j: usize, s: f64) -> (f64, f64) {
        let row = self.overlap_row(j);
        self.arcs.overlap(j, series::value(row, s), series::derivative(row, s) / self.unit)
    }

    /// Rate of the series in the row of contact `j`, for this overlap (m) and its rate (m/s).
    pub(crate) fn rate_of_row(&self, j: usize, overlap: f64, rate: f64) -> f64 {
        self.arcs.rate_of_row(j, overlap, rate)
    }

    /// Begins rows of this order and unit of time (s) with only the state at the start.
    pub(crate) fn begin(&mut self, window: &Window<'_>, order: usize, unit: f64) {
        (self.order, self.stride, self.unit, self.converges_for) = (order, order + 2, unit, unit);
        let (stride, balls, contacts) = (self.stride, window.models.len(), window.contacts.len());
        self.displacements.clear();
        self.displacements.resize(balls * stride, 0.0);
        for rows in [&mut self.overlaps, &mut self.elastic, &mut self.forces] {
            rows.clear();
            rows.resize(contacts * stride, 0.0);
        }
        self.dashpots.clear();
        self.dashpots.extend(window.laws.iter().map(ContactLaw::damping_coefficient));
        for i in 0..balls {
            self.displacements[i * stride + 1] = window.flights[i].v * unit;
        }
        for j in 0..contacts {
            self.overlaps[j * stride] = window.contacts[j].overlap;
            self.overlaps[j * stride + 1] = window.overlap_rate(j) * unit;
        }
        self.arcs.begin(window, stride, &self.displacements, &mut self.overlaps);
    }

    /// Sets the elastic force of contact `j`, and its force without clipping, to these polynomials of the scaled time,
    /// N.
    pub(crate) fn set_forces(&mut self, j: usize, elastic: &[f64], force: &[f64]) {
        let at = j * self.stride;
        self.elastic[at..at + elastic.len()].copy_from_slice(elastic);
        self.forces[at..at + force.len()].copy_from_slice(force);
    }
}

impl Series {
    /// Deflection and height (m), as series, of ball `i`, which begins at `start` (m) along its path.
    pub(crate) fn places(&self, i: usize, ball: &BallModel, start: f64) -> [Vec<f64>; 2] {
        let (mut path, place) = (self.displacement(i).to_vec(), ball.place(start));
        if !ball.on_arc {
            path[0] = start;
            let square = (0..path.len()).map(|k| 0.5 * series::product_term(&path, &path, k) / ball.length);
            return [path.clone(), square.collect()];
        }
        let [sin, cos] = self.directions(i);
        let mut places = [(1.0, sin), (-1.0, cos)]
            .map(|(sign, row)| row.iter().map(|c| sign * ball.length * c).collect::<Vec<f64>>());
        (places[0][0], places[1][0]) = (place.x, place.y);
        places
    }

    /// Sine and cosine of the angle of ball `i` on an arc.
    pub(crate) fn directions(&self, i: usize) -> [&[f64]; 2] {
        [&self.arcs.sin, &self.arcs.cos].map(|rows| self.row(rows, i))
    }

    /// Component of the direction of the closed contact `j` away from the pivot of its ball `i`, as a series.
    pub(crate) fn outward(&self, j: usize, i: usize) -> Vec<f64> {
        let [nx, ny] = [0, 1].map(|k| self.row(&self.arcs.direction[k], j));
        let [sin, cos] = self.directions(i);
        (0..sin.len()).map(|k| series::product_term(nx, sin, k) - series::product_term(ny, cos, k)).collect()
    }

    fn with_change_of_rate(&self, row: &[f64], tau: f64) -> (f64, f64) {
        let (value, change) = series::value_and_change_of_derivative(row, tau / self.unit);
        (value, change / self.unit)
    }

    /// When `sign` times `row` rises above `sign` times `level`, before `until` (s).
    fn crossing(&self, row: &[f64], sign: f64, level: f64, until: f64) -> Forecast {
        self.switching(crossing::first_positive(row, sign, level, until / self.unit), until)
    }

    /// A switching at the scaled time `s`, if there is one and it comes before `until` (s).
    fn switching(&self, s: Option<f64>, until: f64) -> Forecast {
        match s.map(|s| s * self.unit) {
            None => Forecast::Never,
            Some(tau) if tau >= until => Forecast::Never,
            Some(tau) => Forecast::At(tau), // Also NaN, to be noticed.
        }
    }

    fn onset(&self, j: usize, window: &Window, until: f64, rounding: &Rounding) -> Forecast {
        let (row, position_rounding, end) = (self.overlap_row(j), rounding.position, until / self.unit);
        let onset = self.crossing(row, 1.0, 0.0, until);
        let is_deep = || {
            series::value_by_lanes(row, end) > position_rounding
                || crossing::first_positive(row, 1.0, position_rounding, end).is_some()
        };
        // The front of an arriving wave has yet to reach a ball in touch and at rest, which may take longer than this
        // segment to be pressed any deeper.
        let at_rest = rounding.is_rest(row[0], row[1] / self.unit);
        let wave = || at_rest && self.overlaps.chunks_exact(self.stride).any(|d| d[0] + d[1] > position_rounding);
        // The front is not there yet while closing the contact would change velocities by no more than rounding.
        let matters = || {
            let (law, mass, (overlap, change_of_rate)) =
                (&window.laws[j], window.reduced_mass(j), self.overlap(j, until));
            change_of_rate + law.elastic_force(overlap) * until / mass > rounding.velocity
        };
        if onset != Forecast::Never && (is_deep() || wave() && matters()) { onset } else { Forecast::Never }
    }

    fn release(&self, j: usize, until: f64, rounding: &Rounding) -> Forecast {
        let (row, level) = (self.overlap_row(j), rounding.no_overlap());
        if row[0] <= level && rounding.is_rest(row[0], row[1] / self.unit) {
            return self.release_from_rest(row, level, until, rounding);
        }
        self.crossing(row, -1.0, level, until)
    }

    /// When a closed contact at rest opens before `until` (s): when its balls have parted by more than rounding or, if
    /// they are pressed before that, when their overlap falls below `level` (m) again.
    fn release_from_rest(&self, row: &[f64], level: f64, until: f64, rounding: &Rounding) -> Forecast {
        let (end, drift) = (until / self.unit, rounding.position.max(rounding.velocity * until));
        let parted = crossing::first_positive(row, -1.0, -drift, end);
        let pressed = PARTS.into_iter().map(|part| part * end).find(|&s| series::value_by_lanes(row, s) > level);
        if parted.is_some_and(|parted| pressed.is_none_or(|pressed| parted <= pressed)) {
            return self.switching(parted, until);
        }
        let Some(pressed) = pressed else { return Forecast::Never };
        let about: [f64; MOST] = series::about(row, pressed);
        let fall = crossing::first_positive(&about[..row.len()], -1.0, level, end - pressed);
        self.switching(fall.map(|s| pressed + s), until)
    }

    fn clip(&self, j: usize, window: &Window, until: f64, rounding: &Rounding) -> Forecast {
        let (law, mode) = (&window.laws[j], window.contacts[j].mode);
        let (row, end) = (self.overlap_row(j), until / self.unit);
        if end <= 0.0 {
            return Forecast::Never;
        }
        // The overlap does not vanish within this unit of time, so coefficients of its powers stay in range.
        let unit = end.min(1.0);
        let scaled = |row: &[f64]| -> Vec<f64> {
            row.iter().scan(1.0, |power, c| Some(*c * std::mem::replace(power, *power * unit))).collect()
        };
        let (pressing, threshold) = match law.sign_of_force() {
            Some(sign) => {
                let fastest = row[1].abs() + series::bound_of_change_of_derivative(row, end);
                if mode == Mode::Pressing && sign.by_rate * fastest < (1.0 - 1e-9) * sign.least() * self.unit {
                    return Forecast::Never;
                }
                let left_out = mode == Mode::Pressing && self.elastic_row(j).iter().all(|c| *c == 0.0);
                let threshold = sign.error_bound(row[0], rounding.position, rounding.velocity);
                (sign.series(&scaled(row), &scaled(&self.rate(row)), left_out), threshold)
            }
            None => (scaled(self.force_row(j)), law.unclipped_force(rounding.position, rounding.velocity)),
        };
        let sign = sign_after_clip(mode);
        let first = |level: f64| crossing::first_positive(&pressing, sign, level, end / unit);
        let clip = first(sign * threshold).and_then(|_| first(0.0));
        self.switching(clip.map(|s| s * unit), until)
    }

    /// `integral a b` over the first `tau` (s) of a segment: b is the rate of the series in a row; the function `a` is
    /// given some scaled times and the rates there, by the scaled time.
    fn integral_by_rate(
        &self,
        row: &[f64],
        tau: f64,
        a: impl Fn(&[f64; POINTS], &[f64; POINTS]) -> [f64; POINTS],
    ) -> f64 {
        quadrature::of_samples(tau / self.unit, |places| {
            let rates = series::sample_derivative(row, places);
            let a = a(places, &rates);
            std::array::from_fn(|p| a[p] * rates[p])
        })
    }

    /// `integral b^2` over the first `tau` (s) of a segment, for the rate b of the series in a row.
    fn squared_rate_integral(&self, row: &[f64], tau: f64) -> f64 {
        self.integral_by_rate(row, tau, |_, rates| *rates) / self.unit
    }
}

impl DenseOutput for Series {
    fn moved(&self, j: usize, tau: f64) -> (f64, f64) {
        self.with_change_of_rate(self.displacement(j), tau)
    }

    fn displacement_integral(&self, j: usize, tau: f64) -> f64 {
        self.unit * series::integral_by_lanes(self.displacement(j), tau / self.unit)
    }

    fn overlap(&self, j: usize, tau: f64) -> (f64, f64) {
        if self.arcs.is_open(j) {
            let (overlap, rate) = self.overlap_at(j, tau / self.unit);
            return (overlap, rate - self.overlap_at(j, 0.0).1);
        }
        self.with_change_of_rate(self.overlap_row(j), tau)
    }

    fn overlap_series(&self, j: usize, tau: f64) -> Option<OverlapSeries> {
        let mut coefficients = series::about(self.overlap_row(j), tau / self.unit);
        let mut scale = 1.0;
        for c in &mut coefficients {
            *c *= scale;
            scale /= self.unit;
        }
        Some(coefficients)
    }

    fn impulse(&self, j: usize, tau: f64) -> f64 {
        self.unit * series::integral_by_lanes(self.force_row(j), tau / self.unit)
    }

    fn peak(&self, j: usize, from: f64, to: f64, known: f64) -> Option<Peak> {
        let (row, end) = (self.force_row(j), to / self.unit);
        if series::bound(row, end) < known {
            return None;
        }
        let (place, force) = crossing::maximum(row, from / self.unit, end);
        Some(Peak { force, time: if place == end { to } else { self.unit * place } })
    }

    fn squared_velocity_integral(&self, j: usize, tau: f64) -> f64 {
        self.squared_rate_integral(self.displacement(j), tau)
    }

    fn work(&self, j: usize, forcing: &Forcing, tau: f64) -> f64 {
        if degree(forcing) == 0 {
            return forcing[0] * self.moved(j, tau).0;
        }
        let mut unit = 1.0;
        let mut scaled = [0.0; MAX_FORCE_ORDER + 1];
        for (k, p) in forcing.iter().enumerate() {
            scaled[k] = p * unit * INVERSE_FACTORIAL[k];
            unit *= self.unit;
        }
        self.integral_by_rate(self.displacement(j), tau, |places, _| series::sample(&scaled, places))
    }

    fn contact_loss(&self, j: usize, tau: f64) -> f64 {
        // A difference of forces would lose digits of weak dashpots.
        if self.dashpots[j] != 0.0 {
            return self.dashpots[j] * self.squared_rate_integral(self.overlap_row(j), tau);
        }
        self.integral_by_rate(self.overlap_row(j), tau, |places, _| {
            series::sample_terms(self.force_row(j), self.elastic_row(j), places, |force, elastic| force - elastic)
        })
    }

    fn first(&self, switch: Switch, j: usize, window: &Window, until: f64, rounding: &Rounding) -> Forecast {
        match switch {
            Switch::Onset => self.onset(j, window, until, rounding),
            Switch::Release => self.release(j, until, rounding),
            Switch::Clip => self.clip(j, window, until, rounding),
        }
    }
}

/// `1 / k!`.
pub(crate) const INVERSE_FACTORIAL: [f64; MAX_FORCE_ORDER + 1] = [1.0, 1.0, 0.5, 1.0 / 6.0];

/// Enters the integral of a polynomial `rate` of the scaled time into this row, behind its constant term.
pub(crate) fn integrate(row: &mut [f64], rate: &[f64], unit: f64) {
    for (k, (term, rate)) in row[1..].iter_mut().zip(rate).enumerate() {
        *term = rate * unit / (k + 1) as f64;
    }
}
