//! Slow motion on arcs: against strong drag or damping, and without gravity.

use newtons_cradle::engine::{Chain, Engine, Results, Unrecorded};
use newtons_cradle::model::{Inputs, Parameters, PendulumModel};

use crate::runs::{assert_energy, cradle};

/// Strong drag and damping on arcs: steps follow the slow motion, which for small angles is that on lines.
#[test]
fn creeping_on_arcs_costs_little() {
    let amplitude = 1e-4;
    for (balls, settings) in [
        (1, "pendulum.drag=1e3"),
        (5, "pendulum.drag=2e9"),
        (5, "pendulum.drag=1e18 pendulum.lengthRatio=1,1,1.5,1,0.1"),
        (2, "contact.damping=5e6"),
        (5, "contact.model=hertz contact.damping=1e7 contact.deadBand=0"),
        (5, "contact.model=hertz contact.damping=1e7 ball.massRatio=1,2,1,0.5,1"),
        (3, "contact.exponent=3 contact.damping=1e9 pendulum.drag=1"),
    ] {
        let start = cradle(balls, &format!("x_start=0 x_start[1]=-{amplitude} contact.deadBand=1e-8 {settings}"));
        let [line, arc] = [PendulumModel::Linear, PendulumModel::Circular].map(|pendulum| {
            let p = Parameters { pendulum, ..start.clone() };
            let mut engine = Engine::new(&p, &Inputs::zero(balls), 0.0).unwrap();
            engine.advance_within(20.0, 1_000_000, &mut Unrecorded).unwrap();
            assert!(engine.time() == 20.0 && engine.work().steps < 1000, "{settings}: {:?}", engine.work());
            assert_energy(&engine, 1e-13, settings);
            engine
        });
        let off = (0..balls).map(|i| (line.x(i) - arc.x(i)).abs() / amplitude).fold(0.0, f64::max);
        assert!(off < 1e-7, "{settings}: {off:e}");
    }
}

/// Overdamped contacts that hardly anything presses any more: overlaps far below the rounding of the balls' motion, on
/// lines and arcs, of pendulums that are equal, or differ by their drag or their length.
#[test]
fn creeping_overlaps_below_rounding_cost_little() {
    let stiff = "contact.deadBand=0 contact.damping=2e6 contact.stiffness=1e9 ball.mass=0.07";
    for (balls, settings) in [
        (2, "v_start=0.08,-0.04"),
        (2, "v_start=-0.04,0.08 pendulum.lengthRatio=1,1.1 contact.damping=1.7e6 contact.stiffness=1.7e11"),
        (3, "x_start=-0.3,-0.3,0 v_start=0.1,0,-2"),
        (
            3,
            "x_start=-0.3,-0.3,0 v_start=0.1,-0.09,0.06 ball.massRatio=26,26,35 pendulum.drag=5e-3 contact.damping=7e6",
        ),
        (3, "v_start=0.026,0.094,0.028 pendulum.lengthRatio=1,1.18,1 contact.damping=1.5e5 contact.stiffness=1.6e11"),
    ] {
        for pendulum in ["linear", "circular"] {
            let p = cradle(balls, &format!("pendulum.model={pendulum} x_start=0 {stiff} {settings}"));
            let mut engine = Engine::new(&p, &Inputs::zero(balls), 0.0).unwrap();
            engine.advance_within(2.0, 1_000_000, &mut Unrecorded).unwrap();
            let work = engine.work();
            assert!(engine.time() == 2.0 && work.steps < 1000, "{pendulum} {settings}: {work:?}");
            assert_energy(&engine, 1e-13, settings);
        }
    }
}

/// A ball creeps to where a force holds it: `b L angle' = F cos(angle) - m g sin(angle)`, with an inertia that is less
/// than the square of `m omega / b`.
#[test]
fn creeping_under_a_force_has_its_closed_form() {
    for (drag, force, share, start) in [
        (1e6, 9.81, 1e-4, 0.785),
        (1e6, 9.81, 8.0, 0.785),
        (1e6, 981.0, 3.0, 0.2),
        (1e8, 9.81, 1e-8, 0.785),
        (1e8, 9810.0, 3.0, 0.3),
        (1e11, 1.0, 0.5, 1.5),
    ] {
        let p = cradle(1, &format!("pendulum.model=circular pendulum.drag={drag} x_start={}", 1.962 * f64::sin(start)));
        let mut inputs = Inputs::zero(1);
        inputs.force[0] = force;
        let mut run = Engine::new(&p, &inputs, 0.0).unwrap();
        let (start, held, strength) = (run.angle(0), f64::atan2(force, p.gravity), f64::hypot(force, p.gravity));
        let time = share * drag * p.length / strength;
        run.advance(time, &mut Unrecorded).unwrap();
        let expected = held + 2.0 * f64::atan(f64::tan(0.5 * (start - held)) * f64::exp(-share));
        let off = (run.angle(0) - expected).abs() / (start - expected).abs().max(1e-3);
        assert!(off < 1e-10, "{drag:e} {force} {share}: {off:e}");
    }
}

/// Series that could hold for ever are renewed as well.
#[test]
fn creeping_balls_meet_after_millions_of_seconds() {
    let p =
        cradle(2, "pendulum.model=circular gravity=0 contact.deadBand=0 x_start[1]=-0.1 x_start[2]=0 v_start[1]=1e-8");
    let mut run = Engine::new(&p, &Inputs::zero(2), 0.0).unwrap();
    run.advance(2e7, &mut Unrecorded).unwrap();
    assert_eq!(run.pulses(0), 1);
    assert!((run.last_onset(0) - 1e7).abs() < 1e5, "{}", run.last_onset(0));
}
