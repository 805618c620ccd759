//! `contact.model = rigid`: impacts without duration, and balls that stay in contact.

use std::f64::consts::PI;

use newtons_cradle::engine::{Chain, Engine, Peak, Pulse, Results};
use newtons_cradle::model::{Inputs, Parameters, PendulumModel};

use crate::arcs::period;
use crate::runs::{assert_energy, started, state, touching};

/// `n` rigid balls without dead band at rest in touch, with more settings.
fn rigid(n: usize, settings: &str) -> Parameters {
    touching(n, &format!("contact.model=rigid {settings}"))
}

/// As many balls leave on one side as were lifted on the other, click after click, on lines and on arcs, and those that
/// fly side by side never touch. Waves that cross, as in the paper's Figure 3, pass through each other: nothing but the
/// order of the impacts shows that they met.
#[test]
fn rigid_as_many_balls_leave_as_were_lifted() {
    let rows = [(2, 1, 0), (5, 1, 0), (5, 2, 0), (5, 3, 0), (5, 4, 0), (13, 3, 0), (13, 3, 2)];
    for (arcs, (n, left, right)) in [false, true].into_iter().flat_map(|arcs| rows.map(|row| (arcs, row))) {
        let mut p = rigid(n, "");
        let (omega, angle) = ((p.gravity / p.length).sqrt(), 60f64.to_radians());
        let (mut amplitude, mut speed, mut half) = (0.1, 0.1 * omega, PI / omega);
        if arcs {
            p.pendulum = PendulumModel::Circular;
            (amplitude, speed) = (p.length * angle.sin(), 2.0 * p.length * omega * (0.5 * angle).sin());
            half = 0.5 * period(&p, angle);
        }
        p.x_start[..left].fill(-amplitude);
        p.x_start[n - right..].fill(amplitude);
        let (mut engine, within) = (started(&p), if arcs { 1e-12 } else { 1e-13 });
        let (mut sides, mut pulses) = ([left, right], Vec::new());
        for click in 1..=100 {
            // Half way between two clicks.
            engine.advance(f64::from(click) * half, &mut pulses).unwrap();
            sides.reverse();
            for i in 0..n {
                let away = f64::from(u8::from(i >= n - sides[1])) - f64::from(u8::from(i < sides[0]));
                assert!(
                    (engine.x(i) - amplitude * away).abs() < within,
                    "{arcs} {left} {right} {click} {i}: {}",
                    engine.x(i)
                );
            }
            // Each momentum has passed all balls that were not lifted along with it.
            let passes = click as usize * (left * (n - left) + right * (n - right));
            let passed: f64 = (0..n - 1).map(|i| engine.impulse(i)).sum();
            assert!((passed / (passes as f64 * speed) - 1.0).abs() < 1e-12, "{arcs} {left} {right} {click}: {passed}");
            assert!(right > 0 || pulses.len() == passes);
        }
        assert!(
            pulses
                .iter()
                .all(|pulse| pulse.release == pulse.onset && pulse.peak == (Peak { force: 0.0, time: pulse.onset }))
        );
        assert!(arcs || engine.dissipated_energy() < 1e-30);
        assert_energy(&engine, 1e-13, "as many");
    }
}

/// With losses all end up swinging together, and the impacts have an end.
#[test]
fn rigid_balls_with_losses_end_up_swinging_together() {
    for (restitution, dead_band) in [(0.9, 0.0), (0.9, 2.6e-6), (0.5, 0.0), (0.1, 2.6e-6), (0.0, 0.0), (0.0, 2.6e-6)] {
        let settings = format!("contact.restitution={restitution} contact.deadBand={dead_band} x_start[1]=-0.1");
        let mut engine = started(&rigid(5, &settings));
        engine.advance(590.0, &mut Vec::new()).unwrap();
        let events = engine.work().events;
        assert!(events < 100_000, "{restitution}: {events}");
        engine.advance(600.0, &mut Vec::new()).unwrap();
        // A fifth of the momentum each: a swing of a fifth of the amplitude.
        let omega = 5f64.sqrt();
        for i in 0..5 {
            let swing = engine.x(i).hypot(engine.v(i) / omega);
            assert!((swing - 0.02).abs() < 4.0 * dead_band + 1e-9, "{restitution} {dead_band}: {swing}");
            assert!((engine.v(i) - engine.v(0)).abs() < 4.0 * dead_band * omega + 1e-9);
        }
        assert_energy(&engine, 1e-13, "rigid");
        assert!((engine.dissipated_energy() - 0.8 * 0.025).abs() < 1e-6);
    }
}

/// Two balls pushed against each other bounce ever lower: an end of infinitely many impacts, then one body.
#[test]
fn rigid_chatter_ends() {
    for restitution in [0.2, 0.5, 0.9, 0.99] {
        let unequal = format!("contact.restitution={restitution} ball.massRatio[2]=3");
        let p = rigid(2, &format!("gravity=0 x_start[1]=-0.01 {unequal}"));
        let inputs = Inputs { force: vec![2.0, 0.0], ..Inputs::zero(2) };
        let mut engine = Engine::new(&p, &inputs, 0.0).unwrap();
        let fall = (2.0f64 * 0.01 / 2.0).sqrt();
        let end = fall * (1.0 + restitution) / (1.0 - restitution);
        let mut pulses = Vec::new();
        engine.advance(0.999 * end, &mut pulses).unwrap();
        assert_eq!(engine.force(0), 0.0);
        engine.advance(end + 1.0, &mut pulses).unwrap();
        assert!((engine.last_onset(0) / end - 1.0).abs() < 1e-5, "{restitution}: {} {end}", engine.last_onset(0));
        let bounces = (1e-9f64).ln() / restitution.ln();
        assert!((pulses.len() as f64) < 2.0 * bounces + 10.0, "{restitution}: {}", pulses.len());
        assert!((engine.force(0) - 1.5).abs() < 1e-14 && engine.v(0) == engine.v(1) && engine.overlap(0) == 0.0);
        assert!((engine.a(0) - 0.5).abs() < 1e-14 && (engine.a(1) - 0.5).abs() < 1e-14);
        // All that the relative motion had is lost.
        let lost = 0.5 * 0.75 * (2.0 * fall) * (2.0 * fall);
        assert!(engine.dissipated_energy() > 0.9 * lost && engine.last_release(0) < engine.last_onset(0));
        assert_energy(&engine, 1e-13, "rigid");
    }
}

/// Nothing but drag takes the bounces of elastic balls: the lower they are, the more of them follow each other, but not
/// for ever.
#[test]
fn rigid_elastic_chatter_ends() {
    let p = rigid(2, "gravity=0 x_start[1]=-0.01 pendulum.drag=2");
    let inputs = Inputs { force: vec![2.0, 0.0], ..Inputs::zero(2) };
    let mut engine = Engine::new(&p, &inputs, 0.0).unwrap();
    engine.advance(10.0, &mut Vec::new()).unwrap();
    let early = engine.pulses(0);
    engine.advance(600.0, &mut Vec::new()).unwrap();
    assert!(early > 1000 && engine.last_onset(0) < 30.0 && engine.pulses(0) < 400_000, "{early} {}", engine.pulses(0));
    assert!((engine.force(0) - 1.0).abs() < 1e-14 && engine.v(0) == engine.v(1) && engine.overlap(0) == 0.0);
    assert!((engine.v(0) - 0.5).abs() < 1e-14);
    assert_energy(&engine, 1e-13, "rigid");
}

/// Two balls on pendulums of unequal lengths, which press each other on one half of the swing.
const UNEQUAL: &str = "ball.massRatio[1]=2 pendulum.lengthRatio=0.8,1.1";

/// The squares of their frequencies (1/s2) alone, and the frequency (1/s) as a body.
fn frequencies() -> ([f64; 2], f64) {
    let [first, second] = [0.8, 1.1].map(|ratio| 9.81 / (1.962 * ratio));
    ([first, second], ((2.0 * first + second) / 3.0).sqrt())
}

#[test]
fn rigid_body_parts_where_its_contact_would_pull() {
    let mut engine = started(&rigid(2, &format!("contact.restitution=0.3 x_start=-0.1 {UNEQUAL}")));
    let ([first, second], omega) = frequencies();
    let (quarter, mut pulses) = (0.5 * PI / omega, Vec::new());
    // m1 m2 / (m1 + m2) times the difference of the accelerations that the balls would have alone.
    let force = |t: f64| 2.0 / 3.0 * (first - second) * 0.1 * (omega * t).cos();
    assert!((engine.force(0) - force(0.0)).abs() < 1e-15 && engine.pulses(0) == 1 && engine.last_onset(0) == 0.0);
    for share in [0.1, 0.5, 0.9] {
        let t = share * quarter;
        let (from, before) = (engine.time(), engine.impulse(0));
        engine.advance(t, &mut pulses).unwrap();
        assert!((engine.x(0) + 0.1 * (omega * t).cos()).abs() < 1e-15 && engine.overlap(0) == 0.0);
        assert!((engine.force(0) - force(t)).abs() < 1e-14);
        assert!((engine.impulse(0) - 2.0 / 3.0 * (first - second) * 0.1 * (omega * t).sin() / omega).abs() < 1e-14);
        assert!((engine.force_mean(0) * (t - from) - (engine.impulse(0) - before)).abs() < 1e-15);
        assert!((engine.force_peak(0) - force(from)).abs() < 1e-14);
        assert_energy(&engine, 1e-13, "rigid");
    }
    engine.advance(quarter + 1e-3, &mut pulses).unwrap();
    let [Pulse { onset, release, peak, .. }] = pulses[..] else { panic!("{pulses:?}") };
    assert!(onset == 0.0 && (release - quarter).abs() < 1e-12);
    assert!((peak.force - force(0.0)).abs() < 1e-14 && peak.time == 0.0);
    assert!(engine.overlap(0) < 0.0 && engine.force(0) == 0.0 && engine.next_onset().found().is_some());
    engine.advance(60.0, &mut pulses).unwrap();
    assert_energy(&engine, 1e-13, "rigid");
}

/// The largest constraint force lies within the step, where the body turns.
#[test]
fn rigid_largest_force_is_found_within_a_step() {
    let mut engine = started(&rigid(2, &format!("contact.restitution=0 v_start=-0.2 {UNEQUAL}")));
    let ([first, second], omega) = frequencies();
    let mut pulses = Vec::new();
    engine.advance(1.0, &mut pulses).unwrap();
    let peak = 2.0 / 3.0 * (first - second) * 0.2 / omega;
    assert!((engine.force_peak(0) - peak).abs() < 1e-14, "{} {peak}", engine.force_peak(0));
    engine.advance(2.0, &mut pulses).unwrap();
    let [Pulse { release, peak: found, .. }, ..] = pulses[..] else { panic!("{pulses:?}") };
    assert!((found.force - peak).abs() < 1e-14 && (release - PI / omega).abs() < 1e-12);
    assert!((found.time - 0.5 * PI / omega).abs() < 1e-14, "{found:?}");
}

/// A push on the first of five balls at rest presses all of them; a pull takes it away; what is held together comes
/// apart.
#[test]
fn rigid_balls_are_pressed_and_parted_by_inputs() {
    let mut engine = started(&rigid(5, "contact.restitution=0.5"));
    let mut pulses = Vec::new();
    let mut inputs = Inputs::zero(5);
    inputs.force[0] = 5.0;
    engine.hold(&inputs, &[]).unwrap();
    engine.advance(0.1, &mut pulses).unwrap();
    for i in 0..4 {
        assert!((engine.force(i) - (4.0 - i as f64)).abs() < 1e-13, "{i}: {}", engine.force(i));
        assert_eq!((engine.pulses(i), engine.last_onset(i), engine.in_contact(i)), (1, 0.0, true));
        assert!((engine.force_mean(i) - (4.0 - i as f64)).abs() < 1e-12);
    }
    assert!(pulses.is_empty());
    inputs.force[0] = -1.0;
    engine.hold(&inputs, &[]).unwrap();
    engine.advance(0.2, &mut pulses).unwrap();
    let releases: Vec<_> = pulses.iter().map(|pulse| (pulse.contact, pulse.release)).collect();
    assert_eq!(releases, [(0, 0.1), (1, 0.1), (2, 0.1), (3, 0.1)]);
    assert!(pulses.iter().all(|pulse| (pulse.impulse - 0.1 * (4.0 - pulse.contact as f64)).abs() < 1e-13));
    assert!(engine.overlap(0) < -1e-3 && engine.v(4) > 0.0);
    assert!((0..4).all(|i| !engine.in_contact(i)));
    assert_energy(&engine, 1e-13, "rigid");
}

/// Means over a microsecond have their digits after a day, too.
#[test]
fn rigid_body_mean_forces_keep_their_digits() {
    for settings in ["", UNEQUAL] {
        let p = rigid(2, &format!("{settings} pendulum.drag=0.5"));
        let inputs = Inputs { force: vec![0.3, -0.2], support_acceleration: 0.01 };
        let mut engine = Engine::new(&p, &inputs, 0.0).unwrap();
        engine.advance(86_400.0, &mut Vec::new()).unwrap();
        for k in 1..=5 {
            let before = [engine.force(0), engine.support_force()];
            engine.advance(86_400.0 + 1e-6 * f64::from(k), &mut Vec::new()).unwrap();
            let means = [engine.force_mean(0), engine.support_force_mean()];
            for ((mean, before), now) in means.iter().zip(before).zip([engine.force(0), engine.support_force()]) {
                assert!((mean - 0.5 * (before + now)).abs() < 1e-14, "{mean} {before} {now}");
            }
        }
        assert!(engine.in_contact(0) && engine.force(0) > 0.1);
    }
}

#[test]
fn rigid_ties_sharing_a_ball_keep_the_symmetry() {
    let settings = "contact.restitution=0.7 ball.massRatio[2]=3 x_start[1]=-0.1 x_start[3]=0.1";
    let mut engine = started(&rigid(3, settings));
    let click = 0.5 * PI / 5f64.sqrt();
    engine.advance(1.5 * click, &mut Vec::new()).unwrap();
    let (_, v) = state(&engine, 3);
    assert!(v[2] > 0.01 && v[1].abs() < 1e-16 && (v[0] + v[2]).abs() < 1e-16, "{v:?}");
    assert_eq!((engine.pulses(0), engine.pulses(1)), (1, 1));
}

#[test]
fn rigid_long_chains_and_long_runs_end() {
    let mut p = rigid(200, "contact.restitution=0.9");
    p.x_start[..20].fill(-0.1);
    let mut engine = started(&p);
    engine.advance(600.0, &mut Vec::new()).unwrap();
    assert_energy(&engine, 1e-13, "rigid");
    let spread = state(&engine, 200).1.windows(2).map(|v| (v[0] - v[1]).abs()).fold(0.0, f64::max);
    assert!(spread < 1e-3, "{spread:e}");
}

/// A push that fades parts the ball it acts on from the others about where it passes zero: the balls differ in what
/// drag does to them.
#[test]
fn rigid_body_parts_as_a_push_fades() {
    let settings = "contact.restitution=0 gravity=0 pendulum.drag=0.00874297034530852 \
                    x_start[1]=-0.00040523104503505965 ball.massRatio=4.04272261952834,1,1,5.72064286882788";
    let mut engine = started(&rigid(4, settings));
    let (mut push, mut rate) = (Inputs::zero(4), Inputs::zero(4));
    (push.force[0], rate.force[0]) = (0.7589485026071179, -7.48781640342273);
    engine.hold(&push, &[rate.clone()]).unwrap();
    let mut pulses = Vec::new();
    engine.advance(0.5, &mut pulses).unwrap();
    assert_eq!(pulses.iter().map(|pulse| pulse.contact).collect::<Vec<_>>(), [2, 0, 1]);
    let zero = -push.force[0] / rate.force[0];
    assert!((pulses[1].release - zero).abs() < 1e-4, "{} {zero}", pulses[1].release);
    assert_energy(&engine, 1e-13, "rigid");
}
