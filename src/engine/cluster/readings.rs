//! What is read within a segment, at any part of it, is what another method makes of it by short segments up to there.

use proptest::collection::vec;
use proptest::prelude::*;

use super::{Cluster, Control, Method, StepHistory, WindowContact};
use crate::engine::flight::{Ball, Flight, RunningIntegrals};
use crate::model::{BallModel, ContactLaw, Damping, Mode};

/// The most balls, and the short segments that one is compared with.
const MOST: usize = 5;
const SHORT: usize = 3;
const MOST_SEGMENTS: usize = 100;

/// What may differ, over the size of what is read, over what the motion is measured by that velocities are known by, up
/// to that time where it is early in the segment, and over the integral of the whole segment.
const ALLOWED: f64 = 1e-12;
const KNOWN: f64 = 1e-12;
const OF_WHOLE: f64 = 1e-15;
const EARLY: f64 = 0.05;

/// Of what is read, integrals come first: they are known as well early in a segment.
const INTEGRALS: usize = 3;

/// A row of balls at the start of a segment.
#[derive(Clone, Debug)]
struct Row {
    balls: Vec<Ball>,
    flights: Vec<Flight>,
    contacts: Vec<WindowContact>,
    laws: Vec<ContactLaw>,
    /// Segments since the last switching.
    quiet: u32,
}

/// What has gathered from the start of a segment on: integrals of the position of each ball, the energy by the inputs
/// with the losses by drag and by the contacts, impulses of the contacts, displacements of the balls, and changes of
/// their velocities.
type Gathered = [Vec<f64>; 5];

impl Row {
    fn cluster(&self) -> Cluster {
        let all = 0..self.balls.len();
        let (flights, contacts) = (self.flights.clone(), self.contacts.clone());
        let history = StepHistory { quiet: self.quiet, ..StepHistory::default() };
        Cluster::new(all.clone(), all, 0.0.into(), flights, contacts, history)
    }

    /// What `cluster` gathers within `tau` (s).
    fn gathered(&self, cluster: &Cluster, tau: f64) -> Gathered {
        let mut gathered = Gathered::default();
        let [positions, energies, impulses, displacements, changes] = &mut gathered;
        let (mut drag_loss, mut contact_loss) = (0.0, 0.0);
        for (i, ball) in self.balls.iter().enumerate() {
            let integrals = cluster.integrals(i, &RunningIntegrals::default(), ball, tau);
            positions.push(integrals.x_integral);
            energies.push(integrals.work);
            drag_loss += integrals.drag_loss;
            let (displacement, v) = cluster.moved(i, tau);
            displacements.push(displacement);
            changes.push(v - cluster.flights[i].v);
        }
        for (j, law) in self.laws.iter().enumerate() {
            impulses.push(cluster.impulse(j, tau));
            contact_loss += cluster.contact_loss(j, law, tau);
        }
        // A method may enter the losses of a group at one of its balls.
        energies.extend([drag_loss, contact_loss]);
        gathered
    }

    /// The same by short segments of another method than `forbidden`, if there is one; `None` if something switches
    /// before, or it takes many.
    fn gathered_shortly(&self, tau: f64, control: &Control, forbidden: Method) -> Option<Gathered> {
        let (mut cluster, mut control, mut rest) = (self.cluster(), *control, tau);
        (control.longest, control.forbidden) = (tau / SHORT as f64, Some(forbidden));
        let mut sums = self.gathered(&self.started(control), 0.0);
        for _ in 0..MOST_SEGMENTS {
            cluster.expand(&self.balls, &self.laws, &control);
            if cluster.length < rest && cluster.switch.is_some() {
                return None;
            }
            let length = cluster.length.min(rest);
            let more = self.gathered(&cluster, length);
            sums.iter_mut().flatten().zip(more.iter().flatten()).for_each(|(sum, more)| *sum += more);
            cluster.move_start(length, &self.balls, &self.laws);
            rest -= length;
            if rest <= 1e-14 * tau {
                return Some(sums);
            }
        }
        None
    }

    /// The motion in the units of what gathers within `tau` (s).
    fn scales(&self, tau: f64) -> [f64; 5] {
        let elastic: f64 = self.laws.iter().zip(&self.contacts).map(|(law, c)| law.elastic_energy(c.overlap)).sum();
        let speeds = self.balls.iter().zip(&self.flights).map(|(ball, flight)| {
            let pushed = flight.forcing.iter().rev().fold(0.0, |sum, f| (sum + f.abs()) * tau);
            (ball.mass, flight.v.abs() + pushed)
        });
        let (momentum, kinetic) = speeds.fold((0.0, 0.0), |(p, e), (mass, v)| (p + mass * v, e + 0.5 * mass * v * v));
        let farthest = self.flights.iter().fold(0.0, |most: f64, flight| most.max(flight.x.abs()));
        let momentum = momentum + (2.0 * elastic * self.mass()).sqrt();
        let lightest = self.balls.iter().fold(f64::INFINITY, |least, ball| least.min(ball.mass));
        [farthest * tau, kinetic + elastic, momentum, momentum / lightest * tau, momentum / lightest]
    }

    fn mass(&self) -> f64 {
        self.balls.iter().map(|ball| ball.mass).sum()
    }

    fn started(&self, control: Control) -> Cluster {
        let mut cluster = self.cluster();
        cluster.expand(&self.balls, &self.laws, &control);
        cluster
    }
}

fn decades(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low..high).prop_map(|exponent| 10f64.powf(exponent))
}

fn dampings() -> impl Strategy<Value = Damping> {
    prop_oneof![
        2 => Just(Damping::None),
        1 => decades(0.0, 4.0).prop_map(|c| Damping::KelvinVoigt { c, pull: true }),
        1 => decades(0.0, 4.0).prop_map(|c| Damping::KelvinVoigt { c, pull: false }),
        1 => decades(-4.0, 0.0).prop_map(|alpha| Damping::HuntCrossley { alpha }),
        1 => decades(-10.0, -5.0).prop_map(|relaxation| Damping::Viscoelastic { relaxation }),
    ]
}

/// Rows that have just come to touch, that press, and that do so in part, at rest or not.
fn rows() -> impl Strategy<Value = Row> {
    let forcing = prop_oneof![
        Just([0.0; 4]),
        (-3.0..3.0).prop_map(|f| [f, 0.0, 0.0, 0.0]),
        [-1.0..1.0, -1e3..1e3, -1e6..1e6, -1e9..1e9]
    ];
    let speed = prop_oneof![Just(0.0), -1.0..1.0];
    let ball = (prop_oneof![Just(1.0), 0.3..3.0], speed, forcing);
    let overlap = prop_oneof![2 => Just(0.0), 2 => 0.0..1e-6, 1 => -1e-7..0.0];
    let overlaps = prop_oneof![vec(overlap, MOST - 1), vec(1e-8..1e-6, MOST - 1)];
    let pendulum = (
        prop_oneof![Just(0.0), 1.0..100.0],
        prop_oneof![Just(0.0), decades(-3.0, 0.0)],
        prop_oneof![Just(1.0), 0.9..1.1],
    );
    let law = (
        decades(6.0, 10.0),
        prop_oneof![4 => Just(1.0), 1 => Just(1.5), 1 => Just(2.0), 1 => Just(3.0), 1 => 1.0..5.0],
        dampings(),
    );
    let quiet = prop_oneof![Just(0), Just(100)];
    (vec(ball, 2..=MOST), overlaps, pendulum, law, -0.1..0.1, quiet).prop_map(
        |(balls, overlaps, (omega2, gamma, ratio), (stiffness, exponent, damping), first, quiet)| {
            let law = ContactLaw { stiffness, overlap_ref: 1e-6, exponent, clearance: 1e-7, damping };
            let count = balls.len() - 1;
            // So long after a switching no contact is only just in touch.
            let quiet = if overlaps[..count].contains(&0.0) { 0 } else { quiet };
            let (laws, contacts) = (vec![law; count], Vec::new());
            let mut row = Row { balls: Vec::new(), flights: Vec::new(), contacts, laws, quiet };
            let mut x = first;
            for (i, (mass, v, forcing)) in balls.into_iter().enumerate() {
                let omega2 = if i == 1 { ratio * omega2 } else { omega2 };
                let flight = Flight { x, v, forcing };
                row.balls.push(Ball::new(&BallModel { mass, omega2, gamma }, 0.0.into(), flight));
                row.flights.push(flight);
                x -= overlaps.get(i).unwrap_or(&0.0) + law.clearance;
            }
            for (overlap, pair) in overlaps.into_iter().zip(row.flights.windows(2)) {
                let rate = pair[0].v - pair[1].v;
                let mode = if overlap < 0.0 || (overlap == 0.0 && rate < 0.0) {
                    Mode::Open
                } else {
                    law.mode_when_closed(overlap, rate)
                };
                row.contacts.push(WindowContact { overlap, mode });
            }
            row
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 512,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(2002),
        ..ProptestConfig::default()
    })]

    #[test]
    fn a_segment_tells_what_short_ones_by_another_method_do(row in rows(), part in decades(-9.0, 0.0)) {
        let control = Control::new(1e-12);
        let cluster = row.started(control);
        let tau = part * cluster.length.min(1.0);
        if tau > 0.0 && let Some(shortly) = row.gathered_shortly(tau, &control, cluster.method()) {
            let most = |all: &[f64]| all.iter().fold(0.0, |most: f64, sum| most.max(sum.abs()));
            let whole = row.gathered(&cluster, cluster.length);
            let (early, of_whole) = (row.scales(tau), row.scales(cluster.length));
            for (k, (read, sums)) in row.gathered(&cluster, tau).iter().zip(&shortly).enumerate() {
                let scale = if part < EARLY && k < INTEGRALS { early[k] } else { of_whole[k] };
                let allowed = ALLOWED * most(sums) + KNOWN * scale + OF_WHOLE * most(&whole[k]);
                for (read, sum) in read.iter().zip(sums) {
                    prop_assert!((read - sum).abs() <= allowed, "{read:e} {sum:e} {allowed:e} at {part:e}: {row:?}");
                }
            }
        }
    }
}
