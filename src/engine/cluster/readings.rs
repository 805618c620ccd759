//! Integrals read within a segment, at any part of it, are those of short segments up to there.

use proptest::collection::vec;
use proptest::prelude::*;

use super::{Cluster, Control, StepHistory, WindowContact};
use crate::engine::flight::{Ball, Flight, RunningIntegrals};
use crate::model::{BallModel, ContactLaw, Damping, Mode};

/// The most balls, and the short segments that one is compared with.
const MOST: usize = 5;
const SHORT: usize = 3;
const MOST_SEGMENTS: usize = 100;

/// What may differ, over the size of the integral, over what the motion is measured by that velocities are known by, up to that time where
/// it is early in the segment, and over the integral of the whole segment.
const ALLOWED: f64 = 1e-12;
const KNOWN: f64 = 1e-12;
const OF_WHOLE: f64 = 1e-15;
const EARLY: f64 = 0.05;

/// A row of balls at the start of a segment.
#[derive(Clone, Debug)]
struct Row {
    balls: Vec<Ball>,
    flights: Vec<Flight>,
    contacts: Vec<WindowContact>,
    laws: Vec<ContactLaw>,
}

/// What has gathered from the start of a segment on: integrals of the position of each ball, the losses of the balls and of the contacts
/// with the energy by the inputs, and impulses of the contacts.
type Gathered = [Vec<f64>; 3];

impl Row {
    fn cluster(&self) -> Cluster {
        let all = 0..self.balls.len();
        let (flights, contacts) = (self.flights.clone(), self.contacts.clone());
        Cluster::new(all.clone(), all, 0.0.into(), flights, contacts, StepHistory::default())
    }

    /// What `cluster` gathers within `tau` (s).
    fn gathered(&self, cluster: &Cluster, tau: f64) -> Gathered {
        let mut gathered = Gathered::default();
        let [positions, energies, impulses] = &mut gathered;
        for (i, ball) in self.balls.iter().enumerate() {
            let integrals = cluster.integrals(i, &RunningIntegrals::default(), ball, tau);
            positions.push(integrals.x_integral);
            energies.extend([integrals.drag_loss, integrals.work]);
        }
        for (j, law) in self.laws.iter().enumerate() {
            impulses.push(cluster.impulse(j, tau));
            energies.push(cluster.contact_loss(j, law, tau));
        }
        gathered
    }

    /// The same by short segments; `None` if something switches before, or it takes many.
    fn gathered_shortly(&self, tau: f64, control: &Control) -> Option<Gathered> {
        let (mut cluster, mut control, mut rest) = (self.cluster(), *control, tau);
        control.longest = tau / SHORT as f64;
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
    fn scales(&self, tau: f64) -> [f64; 3] {
        let elastic: f64 = self.laws.iter().zip(&self.contacts).map(|(law, c)| law.elastic_energy(c.overlap)).sum();
        let speeds = self.balls.iter().zip(&self.flights).map(|(ball, flight)| {
            let pushed = flight.forcing.iter().rev().fold(0.0, |sum, f| (sum + f.abs()) * tau);
            (ball.mass, flight.v.abs() + pushed)
        });
        let (momentum, kinetic) = speeds.fold((0.0, 0.0), |(p, e), (mass, v)| (p + mass * v, e + 0.5 * mass * v * v));
        let farthest = self.flights.iter().fold(0.0, |most: f64, flight| most.max(flight.x.abs()));
        [farthest * tau, kinetic + elastic, momentum + (2.0 * elastic * self.mass()).sqrt()]
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
    let pendulum = (
        prop_oneof![Just(0.0), 1.0..100.0],
        prop_oneof![Just(0.0), decades(-3.0, 0.0)],
        prop_oneof![Just(1.0), 0.9..1.1],
    );
    let law = (decades(6.0, 10.0), prop_oneof![Just(1.0), Just(1.5), Just(2.0), Just(3.0), 1.0..5.0], dampings());
    (vec(ball, 2..=MOST), vec(overlap, MOST - 1), pendulum, law, -0.1..0.1).prop_map(
        |(balls, overlaps, (omega2, gamma, ratio), (stiffness, exponent, damping), first)| {
            let law = ContactLaw { stiffness, overlap_ref: 1e-6, exponent, clearance: 1e-7, damping };
            let count = balls.len() - 1;
            let mut row = Row { balls: Vec::new(), flights: Vec::new(), contacts: Vec::new(), laws: vec![law; count] };
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
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(2002),
        ..ProptestConfig::default()
    })]

    #[test]
    fn integrals_within_a_segment_are_those_of_short_ones(row in rows(), part in decades(-9.0, 0.0)) {
        let control = Control::new(1e-12);
        let cluster = row.started(control);
        let tau = part * cluster.length.min(1.0);
        if tau > 0.0 && let Some(shortly) = row.gathered_shortly(tau, &control) {
            let most = |all: &[f64]| all.iter().fold(0.0, |most: f64, sum| most.max(sum.abs()));
            let (whole, scales) = (row.gathered(&cluster, cluster.length), row.scales(if part < EARLY { tau } else { cluster.length }));
            for (k, (read, sums)) in row.gathered(&cluster, tau).iter().zip(&shortly).enumerate() {
                let allowed = ALLOWED * most(sums) + KNOWN * scales[k] + OF_WHOLE * most(&whole[k]);
                for (read, sum) in read.iter().zip(sums) {
                    prop_assert!((read - sum).abs() <= allowed, "{read:e} {sum:e} {allowed:e} at {part:e}: {row:?}");
                }
            }
        }
    }
}
