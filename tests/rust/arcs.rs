//! Pendulums on arcs, against formulas and against linear ones.

use cradle_host::{Host, fmi2Error, fmi2OK};
use newtons_cradle::engine::{Engine, EngineError, Fault, Results, Simulation, Unrecorded};
use newtons_cradle::model::{ContactModel, Inputs, Parameters, PendulumModel, SolverMethod};

/// So many of five balls lifted by an angle (degrees).
fn lifted(balls: usize, count: usize, degrees: f64) -> Parameters {
    let mut p = Parameters { pendulum: PendulumModel::Circular, ..Parameters::default_for(balls) };
    p.x_start = (0..balls).map(|i| if i < count { -p.length * degrees.to_radians().sin() } else { 0.0 }).collect();
    p
}

fn run(p: &Parameters, time: f64) -> Engine {
    let mut engine = Engine::new(p, &Inputs::zero(p.balls()), 0.0).unwrap();
    engine.advance(time, &mut Unrecorded).unwrap();
    engine
}

/// `2 pi / (omega M(1, cos(angle / 2)))`, with the arithmetic-geometric mean M (Gauss).
fn period(p: &Parameters, angle: f64) -> f64 {
    let (mut a, mut b) = (1.0, (0.5 * angle).cos());
    while f64::abs(a - b) > 1e-15 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    2.0 * std::f64::consts::PI / ((p.gravity / p.length).sqrt() * a)
}

#[test]
fn the_period_is_that_of_the_pendulum() {
    for degrees in [1.0, 30.0, 80.0, 89.9] {
        let p = lifted(1, 1, degrees);
        // That of the rounded start.
        let angle = run(&p, 1e-300).angle(0);
        for swings in [0.25, 10.25, 100.25] {
            let time = swings * period(&p, angle);
            let engine = run(&p, time);
            let late = engine.x(0) / engine.v(0);
            assert!(late.abs() < 1e-15 * time, "{degrees} degrees: late by {late:e} after {swings} swings");
            assert!(engine.energy_residual().abs() < 2e-14 * engine.total_energy());
        }
    }
}

#[test]
fn small_swings_are_linear() {
    // With contacts whose outcome does not hang on the last digits.
    let hertz = Parameters { contact_model: ContactModel::Hertz, dead_band: 26e-9, ..lifted(5, 2, 1.0) };
    let linear = Parameters { contact_model: ContactModel::PowerLaw, dead_band: 2.6e-9, ..hertz.clone() };
    for p in [linear, hertz] {
        let off = [1e-5, 1e-6].map(|amplitude| {
            let x_start = p.x_start.iter().map(|x| amplitude * x.signum() * x.abs().ceil()).collect();
            let p = Parameters { x_start, ..p.clone() };
            let (arcs, lines) = (run(&p, 3.0), run(&Parameters { pendulum: PendulumModel::Linear, ..p.clone() }, 3.0));
            let speed = amplitude * (p.gravity / p.length).sqrt();
            let off =
                |i: usize| f64::max((arcs.x(i) - lines.x(i)).abs() / amplitude, (arcs.v(i) - lines.v(i)).abs() / speed);
            (0..5).map(off).fold(0.0, f64::max)
        });
        assert!(off[1] < 1e-12 && (50.0..200.0).contains(&(off[0] / off[1])), "{off:?}");
    }
}

/// Ten minutes; with a dead band such that impacts come one after the other. Each is nearly the same as the one before,
/// so that their rounding adds up.
#[test]
fn long_runs_keep_their_energy() {
    for (count, degrees, allowed) in [(1, 30.0, 2e-14), (2, 30.0, 1e-13), (1, 80.0, 2.5e-13)] {
        let p = Parameters { contact_model: ContactModel::Hertz, dead_band: 1e-3, ..lifted(5, count, degrees) };
        let engine = run(&p, 600.0);
        let residual = engine.energy_residual() / engine.total_energy();
        assert!(residual.abs() < allowed, "{count} lifted by {degrees} degrees: {residual:e}");
        assert!((0..4).all(|i| engine.pulses(i) > 300));
    }
}

#[test]
fn heights_angles_and_forces_on_the_support() {
    let mut p = lifted(2, 1, 60.0);
    (p.v_start, p.gap) = (vec![0.3, -0.2], vec![0.1]);
    let engine = run(&p, 1e-300);
    let (angle, u) = (-60f64.to_radians(), 0.3 / 60f64.to_radians().cos());
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-14 * b.abs().max(1.0), "{a}, not {b}");
    close(engine.angle(0), angle);
    close(engine.y(0), 0.5 * p.length);
    close(engine.kinetic_energy(0), 0.5 * u * u);
    close(engine.gravity_energy(0), 0.5 * 9.81 * p.length);
    let tension = 9.81 * angle.cos() + u * u / p.length;
    let beside = 9.81 + 0.2 * 0.2 / p.length;
    close(engine.support_force(), tension * angle.sin());
    close(engine.support_force_vertical(), -tension * angle.cos() - beside);
    close(engine.a(0), -9.81 * angle.sin() * angle.cos() - u * u / p.length * angle.sin());
    let (width, height) = (0.1 + 2.0 * p.radius - p.length * angle.sin(), 0.5 * p.length);
    close(engine.overlap(0), 2.0 * p.radius - p.dead_band - width.hypot(height));
}

#[test]
fn what_cannot_swing_is_refused_or_ends_the_run() {
    let start = |p: &Parameters| Simulation::new(p, &Inputs::zero(p.balls()), 0.0).unwrap_err().to_string();
    let p = lifted(2, 1, 30.0);
    let expect = |p: Parameters, text: &str| assert!(start(&p).contains(text), "{}", start(&p));
    expect(
        Parameters { x_start: vec![0.0, 1.962], ..p.clone() },
        "x_start[2] = 1.962 m lies beyond its pendulum; allowed: -1.962 to 1.962 m",
    );
    expect(Parameters { contact_model: ContactModel::Rigid, ..p.clone() }, "contact.model = rigid is not available");
    expect(Parameters { method: SolverMethod::Bdf, ..p.clone() }, "solver.method must be eventDriven (1)");
    expect(Parameters { gap: vec![-0.07], ..p.clone() }, "no distance between the centres of balls 1 and 2");
    let ends = |p: &Parameters, inputs: &Inputs| {
        let mut run = Engine::new(p, inputs, 0.0).unwrap();
        run.advance(10.0, &mut Unrecorded).unwrap_err()
    };
    // Fast enough for a full turn.
    let fast = Parameters { v_start: vec![0.0, 20.0], ..p.clone() };
    let EngineError::OffArc { time, ball: 1, fault: Fault::Horizontal } = ends(&fast, &Inputs::zero(2)) else {
        panic!("it swings on")
    };
    let until = run(&fast, time * (1.0 - 1e-12));
    assert!((until.angle(1).to_degrees() - 90.0).abs() < 1e-8);
    // Pushed back over the pivot by twice its weight.
    let pushed = Inputs { force: vec![20.0, 0.0], support_acceleration: 0.0 };
    let lifted = Parameters { x_start: vec![-1.9, 0.0], gap: vec![1.0], ..p };
    assert_eq!(ends(&lifted, &pushed), EngineError::OffArc { time: 0.0, ball: 0, fault: Fault::Slack });
}

#[test]
fn a_host_sees_the_error_and_the_last_values() {
    let host = Host::new();
    host.give(&[("pendulum.model", 2.0), ("v_start[5]", 20.0)]);
    host.start();
    assert_eq!(host.step(0.0, 0.05), fmi2OK);
    assert_eq!(host.step(0.05, 1.0), fmi2Error);
    assert!(host.get("angle[5]") > 0.4);
}
