//! Balls that touch at the start within rounding: overlaps and rates hardly show which contacts close, and when.

use newtons_cradle::engine::{Engine, Results};
use newtons_cradle::model::{Inputs, Parameters};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner, contextualize_config};

use super::config;
use super::conservation::energy_scale;
use super::cradles::{Case, decades, ended_early, laws, lose, loss_ratios};
use super::methods::agrees_with_adams;
use crate::runs::{self, assert_energy, cradle, run_under, started};

/// The most balls of a cradle, and how many most of them have.
const MOST: usize = 40;
const FEW: usize = 8;

/// Contact times that a run lasts at most where forces press: without damping, pressed balls ring for ever.
const RINGING: f64 = 300.0;

/// How the start positions of balls that touch follow from how far they rest apart: what rounds them.
#[derive(Clone, Copy, Debug)]
enum Row {
    /// Multiples of the distance, from this one on.
    Multiples(u8),
    /// Sums of distances from this position (m).
    Sums(f64),
    /// Multiples of a distance that leaves about this overlap (m).
    Overlapping(f64),
}

impl Row {
    /// Positions (m) of `n` balls with this `distance` (m) between neighbours.
    fn positions(self, n: usize, distance: f64) -> Vec<f64> {
        match self {
            Self::Multiples(first) => (0..n).map(|i| -((usize::from(first) + i) as f64 * distance)).collect(),
            Self::Sums(start) => (0..n).scan(start, |x, _| Some(std::mem::replace(x, *x - distance))).collect(),
            Self::Overlapping(overlap) => (0..n).map(|i| -(i as f64 * (distance - overlap))).collect(),
        }
    }
}

fn rows() -> impl Strategy<Value = Row> {
    prop_oneof![
        2 => (0..3u8).prop_map(Row::Multiples),
        2 => prop_oneof![Just(0.0), -1e-3..1e-3, -0.5..0.5].prop_map(Row::Sums),
        1 => decades(-24.0, -18.0).prop_map(Row::Overlapping),
    ]
}

/// `plain`, or a third of the time `value`.
fn seldom<T: Clone + std::fmt::Debug + 'static>(
    plain: T,
    value: impl Strategy<Value = T> + 'static,
) -> impl Strategy<Value = T> {
    prop_oneof![2 => Just(plain), 1 => value]
}

/// Up to two values, each with the ball it is for.
fn of_some_balls(value: impl Strategy<Value = f64>) -> impl Strategy<Value = Vec<(usize, f64)>> {
    vec((0..MOST, value, any::<bool>()), 0..3).prop_map(|some| {
        some.into_iter().map(|(i, value, negative)| (i, if negative { -value } else { value })).collect()
    })
}

/// Rows of balls that touch, some of which move or are pressed.
fn touching(most: usize) -> impl Strategy<Value = Case> {
    let ones = vec![1.0; MOST];
    let balls = (prop_oneof![3 => 2..=FEW, 1 => FEW..=most], prop_oneof![Just(0.0), Just(9.81)], decades(-2.0, 1.0));
    let ratios = (
        seldom(vec![1.0; MOST], vec(0.5..2.0, MOST)),
        prop_oneof![4 => Just(ones.clone()), 1 => vec(0.9..1.1, MOST)],
        prop_oneof![4 => Just(ones.clone()), 1 => vec(0.5..2.0, MOST)],
    );
    let exponent = prop_oneof![
        4 => prop_oneof![Just(1.0), Just(1.5), Just(2.0), Just(2.5), Just(3.0)],
        1 => 1.0..4.0,
    ];
    let gap = prop_oneof![4 => Just(0.0), 1 => decades(-8.0, -4.0)];
    let contacts = (decades(4.0, 11.0), exponent, prop_oneof![Just(0.0), decades(-9.0, -4.0)], gap);
    let losses =
        (laws(), prop_oneof![Just(0.0), decades(-3.0, 0.3)], prop_oneof![4 => Just(0.0), 1 => decades(-3.0, 0.0)]);
    let losses = (losses, loss_ratios(MOST));
    let speed = prop_oneof![4 => decades(-3.0, 0.0), 1 => decades(-30.0, -3.0)];
    let pushed =
        (of_some_balls(speed), seldom(0.0, decades(-2.0, 1.0)), seldom(Vec::new(), of_some_balls(decades(-2.0, 1.0))));
    let time = prop_oneof![3 => 0.01..0.5, 1 => 0.5..3.0];
    (balls, ratios, contacts, losses, rows(), pushed, time).prop_map(
        move |((n, gravity, mass), ratios, contacts, losses, row, (moving, ends, forces), time)| {
            let (stiffness, exponent, dead_band, gap) = contacts;
            let mut p = Parameters::default_for(n);
            (p.gravity, p.mass) = (gravity, mass);
            p.mass_ratio = ratios.0[..n].to_vec();
            p.length_ratio = ratios.1[..n].to_vec();
            p.stiffness_ratio = ratios.2[..n - 1].to_vec();
            (p.stiffness, p.exponent, p.dead_band) = (stiffness * mass, exponent, dead_band);
            p.gap.fill(gap);
            lose(&mut p, losses.0, stiffness);
            p.loss_ratio = losses.1[..n - 1].to_vec();
            p.x_start = row.positions(n, gap + dead_band);
            p.v_start = vec![0.0; n];
            moving.iter().for_each(|(i, v)| p.v_start[i % n] = *v);
            let mut inputs = Inputs::zero(n);
            (inputs.force[0], inputs.force[n - 1]) = (ends * mass, -ends * mass);
            forces.iter().for_each(|(i, force)| inputs.force[i % n] += force * mass);
            let mut case = Case { p, inputs, time };
            if case.driven() || (gravity > 0.0 && ratios.1 != ones) {
                case.time = case.time.min(RINGING / stiffness.sqrt());
            }
            case
        },
    )
}

/// How far rounding lets balls move, and how fast, where nothing else moves them: m/s, and in units of the largest
/// position.
const SLOW: f64 = 1e-12;
const DEEP: f64 = 4.0 * f64::EPSILON;

/// The energy (J) of contacts as deep as rounding: they may be open or closed all the same.
fn energy_of_rounding(p: &Parameters) -> f64 {
    let depth = DEEP * p.x_start.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    p.balls() as f64 * p.stiffness * p.overlap_ref.powi(2) * (depth / p.overlap_ref).powf(p.exponent + 1.0)
}

/// Runs a case in so many steps, and looks after its energy.
fn follow(case: &Case, steps: u32, allowed: f64) -> Result<(), TestCaseError> {
    let (mut engine, mut scale) = (case.start()?, case.mass() * SLOW * SLOW);
    for point in 0..=steps {
        engine.advance(case.time * f64::from(point) / f64::from(steps), &mut Vec::new()).map_err(ended_early)?;
        keeps_its_energy(&engine, &case.p, &mut scale, allowed)?;
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(400))]

    #[test]
    fn touching_rows_run_to_their_end(case in touching(MOST)) {
        follow(&case, 20, 1e-11)?;
    }
}

/// Only work and losses have changed the energy, within rounding of the largest `scale` (J) so far.
fn keeps_its_energy(engine: &Engine, p: &Parameters, scale: &mut f64, allowed: f64) -> Result<(), TestCaseError> {
    *scale = scale.max(energy_scale(engine, p.balls()));
    let (off, allowed) = (engine.energy_residual().abs(), allowed * *scale + energy_of_rounding(p));
    prop_assert!(off <= allowed, "energy off by {off:e} of {scale:e} J at {}", engine.time());
    Ok(())
}

/// Starts, and some milliseconds of what follows: balls apart or overlapping by next to nothing, side by side or nearly
/// so, pressed, with losses that are far beyond critical.
fn awkward_starts() -> impl Strategy<Value = Case> {
    let nothing = || prop::sample::select(vec![0.0, 0.0, 1e-22, -1e-22, 1e-17, 1e-12, -1e-12]);
    let rates = prop::sample::select(vec![0.0, 0.0, 0.0, 1e-17, 1e-9, -1e-9]);
    let overdamped = prop_oneof![Just(1.0), decades(0.0, 3.0)];
    let pressed = prop_oneof![3 => Just(0.0), 1 => decades(-9.0, -5.0)];
    (touching(MOST), vec((nothing(), rates), MOST), overdamped, pressed).prop_map(
        |(mut case, nudges, overdamped, pressed)| {
            let p = &mut case.p;
            for (i, (nudge, rate)) in nudges.into_iter().take(p.balls()).enumerate() {
                p.x_start[i] += nudge - i as f64 * pressed;
                p.v_start[i] += rate;
            }
            for coefficient in [&mut p.damping, &mut p.hunt_crossley, &mut p.relaxation_time] {
                *coefficient *= overdamped;
            }
            p.restitution = libm::pow(p.restitution, overdamped).max(1e-6);
            case.time = case.time.min(0.05).min(RINGING / (p.stiffness / p.mass).sqrt());
            case
        },
    )
}

/// 5,000 cases, or ten times as many as the environment asks for.
#[test]
fn touching_rows_keep_their_energy_from_awkward_starts() {
    let config = contextualize_config(config(500));
    let mut runner = TestRunner::new(Config { cases: 10 * config.cases, ..config });
    if let Err(failure) = runner.run(&awkward_starts(), |case| follow(&case, 5, 1e-12)) {
        panic!("{failure}");
    }
}

/// The highest derivative of a force that a case sets.
const ORDER: usize = 3;

proptest! {
    #![proptest_config(config(100))]

    /// Forces that are polynomials of the time, from one communication point to the next, some of which begin at 0.
    #[test]
    fn touching_rows_run_to_their_end_under_varying_forces(
        case in touching(FEW),
        forces in vec(vec(-1.0..1.0, FEW), ORDER),
    ) {
        let time = case.time.min(RINGING * (case.p.mass / case.p.stiffness).sqrt());
        let (mut engine, n) = (case.start()?, case.p.balls());
        let (mut scale, span) = (case.mass() * SLOW * SLOW, time / 20.0);
        for point in 0..20 {
            let force = |order: usize, i: usize| case.p.mass * forces[(point + order) % ORDER][i];
            let derivative = |order: usize| {
                let mut inputs = Inputs::zero(n);
                inputs.force = (0..n).map(|i| force(order, i) / span.powi(order as i32)).collect();
                inputs
            };
            let mut inputs = case.inputs.clone();
            if point % 4 != 0 {
                inputs.force.iter_mut().enumerate().for_each(|(i, value)| *value += force(0, i));
            }
            engine.hold(&inputs, &[derivative(1), derivative(2), derivative(3)]).unwrap();
            engine.advance(span * (point + 1) as f64, &mut Vec::new()).map_err(ended_early)?;
            keeps_its_energy(&engine, &case.p, &mut scale, 1e-11)?;
        }
    }
}

proptest! {
    #![proptest_config(config(20))]

    #[test]
    fn touching_rows_move_as_by_adams(case in touching(FEW)) {
        agrees_with_adams(case)?;
    }
}

/// Four balls side by side, carried along by the support: what drag takes from them is a small part of what it takes on
/// the whole of a step of Gauss collocation, which is much longer than what is read of it.
#[test]
fn touching_balls_lose_to_drag_what_their_equations_say() {
    let (drag, acceleration, time) = (0.0019096320351125679, 2.5_f64, 1e-3_f64);
    let row =
        "gravity=0 contact.exponent=3 contact.deadBand=1.7922e-6 contact.stiffness=319211632.7866216 v_start=1e-17";
    let mut p = cradle(4, &format!("{row} pendulum.drag={drag}"));
    p.x_start = Row::Multiples(0).positions(4, 1.7922e-6);
    let inputs = Inputs { support_acceleration: acceleration, ..Inputs::zero(4) };
    let engine = run_under(&p, &inputs, time);
    // `drag v^2`, with `v = (1 - exp(-drag t)) a / drag` for a mass of 1 kg by its series.
    let expected = 4.0 * drag * acceleration.powi(2) * time.powi(3) / 3.0
        * (1.0 - 0.75 * drag * time + 0.35 * (drag * time).powi(2));
    let off = (engine.dissipated_energy() / expected - 1.0).abs();
    assert!(off < 1e-12, "{} {expected}: {off:e}", engine.dissipated_energy());
}

#[test]
fn touching_lossy_balls_balance_their_energy() {
    for (n, exponent) in [(5, 1.43), (9, 1.2)] {
        let contacts = "contact.dampingLaw=viscoelastic contact.relaxationTime=2.1912927399663294e-8 \
                        contact.stiffness=1876871.5348316086 pendulum.drag=1.13655423662179";
        let moving =
            "x_start[2]=1e-22 x_start[3]=1e-12 x_start[4]=1e-22 v_start[3]=1e-9 v_start[4]=-1.6527422435455263";
        let mut engine = started(&runs::touching(n, &format!("{contacts} contact.exponent={exponent} {moving}")));
        for point in 1..=30 {
            engine.advance(1e-4 * f64::from(point), &mut Vec::new()).unwrap();
            assert_energy(&engine, 1e-14, &format!("{n} balls, p = {exponent}, at {}", engine.time()));
        }
    }
}
