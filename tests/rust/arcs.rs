//! Pendulums on arcs, against formulas and against linear ones.

use cradle_host::{Host, fmi2OK};
use newtons_cradle::engine::{Chain, Engine, EngineError, Fault, Results, Simulation, Unrecorded};
use newtons_cradle::model::{ContactModel, Inputs, Parameters, PendulumModel, SolverMethod};

use crate::runs::{assert_energy, cradle, run};

/// So many of five balls lifted by an angle (degrees).
fn lifted(balls: usize, count: usize, degrees: f64) -> Parameters {
    let mut p = Parameters { pendulum: PendulumModel::Circular, ..Parameters::default_for(balls) };
    p.x_start = (0..balls).map(|i| if i < count { -p.length * degrees.to_radians().sin() } else { 0.0 }).collect();
    p
}

/// Of a pendulum on an arc: `2 pi / (omega M(1, cos(angle / 2)))`, with the arithmetic-geometric mean M (Gauss).
pub fn period(p: &Parameters, angle: f64) -> f64 {
    let (mut a, mut b) = (1.0, (0.5 * angle).cos());
    while f64::abs(a - b) > 1e-15 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    2.0 * std::f64::consts::PI / ((p.gravity / p.length).sqrt() * a)
}

/// Arcs differ from lines by the square of the amplitude.
#[test]
fn arcs_of_small_swings_are_linear() {
    // With contacts whose outcome does not hang on the last digits.
    let hertz = Parameters { contact_model: ContactModel::Hertz, dead_band: 26e-9, ..lifted(5, 2, 1.0) };
    let linear = Parameters { contact_model: ContactModel::PowerLaw, dead_band: 2.6e-9, ..hertz.clone() };
    let mass_ratio = vec![1.0, 1.5, 0.75, 1.25, 2.0];
    let rigid = Parameters { contact_model: ContactModel::Rigid, restitution: 0.9, mass_ratio, ..linear.clone() };
    let figure_6 = Parameters { stiffness: 2.9e14, dead_band: 1.46e-7, ..linear.clone() };
    for (p, small) in [(linear, 1e-6), (hertz, 1e-6), (rigid, 1e-6), (figure_6.clone(), 1e-5), (figure_6, 1e-4)] {
        let off = [10.0 * small, small].map(|amplitude| {
            let x_start = p.x_start.iter().map(|x| amplitude * x.signum() * x.abs().ceil()).collect();
            let p = Parameters { x_start, ..p.clone() };
            let (arcs, lines) = (run(&p, 3.0), run(&Parameters { pendulum: PendulumModel::Linear, ..p.clone() }, 3.0));
            let speed = amplitude * (p.gravity / p.length).sqrt();
            let off =
                |i: usize| f64::max((arcs.x(i) - lines.x(i)).abs() / amplitude, (arcs.v(i) - lines.v(i)).abs() / speed);
            (0..5).map(off).fold(0.0, f64::max)
        });
        assert!(off[1] < small.powi(2) && (80.0..120.0).contains(&(off[0] / off[1])), "{off:?}");
    }
}

/// Ten minutes; with a dead band such that impacts come one after the other. Each is nearly the same as the one before,
/// so that their rounding adds up.
#[test]
fn arcs_keep_the_energy_of_ten_minutes() {
    let runs = [(1, 30.0), (2, 30.0), (1, 80.0)];
    let models = [(ContactModel::Hertz, 2e-14), (ContactModel::Rigid, 5e-14)];
    for ((contact_model, allowed), (count, degrees)) in
        models.into_iter().flat_map(|model| runs.map(|run| (model, run)))
    {
        let p = Parameters { contact_model, dead_band: 1e-3, ..lifted(5, count, degrees) };
        let engine = run(&p, 600.0);
        assert_energy(&engine, allowed, &format!("{contact_model:?}, {count} lifted by {degrees} degrees"));
        assert!((0..4).all(|i| engine.pulses(i) > 300));
    }
}

/// Balls side by side that swing at 3 m/s and hit each other 30 degrees off the level: within a contact their line of
/// centres turns as much as anywhere. Twice in a swing, each time nearly the same: changes of the stiffness in its last
/// bits alone take the energy off by up to 1.5e-14.
#[test]
fn arcs_keep_the_energy_of_oblique_contacts() {
    let hertz = Parameters { contact_model: ContactModel::Hertz, dead_band: 0.0, ..lifted(5, 2, 40.0) };
    let soft = Parameters { contact_model: ContactModel::PowerLaw, exponent: 2.0, overlap_ref: 1.0, ..hertz.clone() };
    for p in [hertz, Parameters { stiffness: 1.9e10, ..soft }] {
        assert_energy(&run(&p, 300.0), 2e-14, &format!("{:?}", p.contact_model));
    }
}

/// Unequal balls with very stiff contacts, whose pulses overlap: each onset within another pulse is located by the
/// directions that all balls have then, whatever the length of the steps.
#[test]
fn arcs_onsets_within_pulses_do_not_depend_on_the_tolerance() {
    let text = "pendulum.model=circular gravity=59.8 pendulum.length=6.955 ball.mass=0.0605 ball.radius=0.0952 \
                ball.massRatio[1]=4.546 ball.massRatio[2]=0.1056 ball.massRatio[3]=0.2265 ball.massRatio[4]=8.631 \
                pendulum.lengthRatio[1]=0.7205 pendulum.lengthRatio[2]=0.6966 pendulum.lengthRatio[3]=1.591 \
                contact.stiffness=4.143e11 contact.overlapRef=9.532e-5 contact.exponent=3.369 contact.damping=1.2 \
                contact.deadBand=5.149e-6 x_start=0 x_start[1]=-0.01091";
    let at = |tolerance: f64| run(&cradle(4, &format!("{text} solver.tolerance={tolerance:e}")), 0.7);
    let [fine, coarse] = [1e-12, 1e-10].map(at);
    for ball in 0..4 {
        let off = (fine.state_of(ball).0 - coarse.state_of(ball).0).abs();
        assert!(off < 1e-13 * 0.01091, "ball {ball}: {off:e} m");
    }
}

/// Unequal pendulums swing together, pressed by almost nothing: the turn of their directions moves the time at which
/// two of them part.
#[test]
fn arcs_balls_part_under_tiny_forces() {
    let mut p = Parameters { dead_band: 0.0, gravity: 10.2, radius: 5.0, length: 1.4, ..lifted(6, 0, 0.0) };
    (p.stiffness, p.damping) = (8.2e6, 4800.0);
    p.stiffness_ratio = vec![1.0, 1.0, 48.0, 1.5, 7.5];
    p.length_ratio = vec![1.23, 0.7, 1.06, 1.4, 1.02, 0.73];
    p.x_start[..2].copy_from_slice(&[-1.2e-3, -8.5e-5]);
    assert_energy(&run(&p, 2.16), 1e-13, "parting");
}

#[test]
fn arcs_heights_angles_and_support_forces_have_their_formulas() {
    let (length, radius, angle, u) = (1.962, 0.0313, -60f64.to_radians(), 0.3 / 60f64.to_radians().cos());
    let host = Host::with_balls(2);
    let start = format!("x_start[1]={} v_start=0.3,-0.2", length * angle.sin());
    host.give(&format!("pendulum.model=circular contact.gap=0.1 {start}"));
    host.start();
    let expect = |name: &str, expected: f64| {
        let value = host.get(name);
        assert!((value - expected).abs() < 1e-14 * expected.abs().max(1.0), "{name} is {value}, not {expected}");
    };
    expect("angle[1]", angle);
    expect("y[1]", 0.5 * length);
    expect("E_kinetic[1]", 0.5 * u * u);
    expect("E_gravity[1]", 0.5 * 9.81 * length);
    let tension = 9.81 * angle.cos() + u * u / length;
    let beside = 9.81 + 0.2 * 0.2 / length;
    expect("F_support", tension * angle.sin());
    expect("F_support_vertical", -tension * angle.cos() - beside);
    expect("a[1]", -9.81 * angle.sin() * angle.cos() - u * u / length * angle.sin());
    let (width, height) = (0.1 + 2.0 * radius - length * angle.sin(), 0.5 * length);
    expect("overlap[1]", 2.0 * radius - 2.6e-6 - width.hypot(height));
}

#[test]
fn arcs_beyond_the_model_are_refused_or_end_the_run() {
    let start = |p: &Parameters| Simulation::new(p, &Inputs::zero(p.balls()), 0.0).unwrap_err().to_string();
    let p = lifted(2, 1, 30.0);
    let expect = |p: Parameters, text: &str| assert!(start(&p).contains(text), "{}", start(&p));
    expect(
        Parameters { x_start: vec![0.0, 1.962], ..p.clone() },
        "x_start[2] = 1.962 m lifts its ball to 90 degrees or farther; allowed: more than -1.962 m and less than \
         1.962 m",
    );
    expect(Parameters { x_start: vec![-1e300, 0.0], ..p.clone() }, "x_start[1] = -1e300 m lifts its ball");
    expect(
        Parameters { x_start: vec![0.03, 0.0], ..rigid(2, 0, 0.0, 1.0) },
        "rigid balls 1 and 2 overlap by 2.9999e-2 m; allowed: x_start[1] - x_start[2] up to contact.gap[1]",
    );
    expect(Parameters { method: SolverMethod::Bdf, ..p.clone() }, "solver.method must be eventDriven (1)");
    expect(Parameters { gap: vec![-0.07], ..p.clone() }, "no distance between the centres of balls 1 and 2");
    let sides =
        "balls 1 and 2 have changed sides with x_start[1] = 0.5 m and x_start[2] = -0.5 m; allowed: each on its";
    expect(Parameters { x_start: vec![0.5, -0.5], ..p.clone() }, sides);
    expect(Parameters { x_start: vec![0.5, -0.5], length_ratio: vec![1.0, 1.5], ..p.clone() }, sides);
    let ends = |p: &Parameters, inputs: &Inputs| {
        let mut run = Engine::new(p, inputs, 0.0).unwrap();
        run.advance(10.0, &mut Unrecorded).unwrap_err()
    };
    // Fast enough for a full turn.
    let fast = Parameters { v_start: vec![0.0, 20.0], ..p.clone() };
    let error = ends(&fast, &Inputs::zero(2));
    let EngineError::OffArc { time, ball: 1, fault: Fault::Horizontal } = error else { panic!("{error}") };
    assert!(error.to_string().starts_with("pendulum 2 swings beyond 90 degrees at t = 0."), "{error}");
    let until = run(&fast, time * (1.0 - 1e-12));
    assert!((until.angle(1).to_degrees() - 90.0).abs() < 1e-8);
    // In a soft contact.
    let soft = Parameters { stiffness: 20.0, exponent: 1.0, overlap_ref: 1.0, radius: 5.0, ..lifted(2, 0, 0.0) };
    let hit = Parameters { v_start: vec![12.0, 0.0], ..soft };
    let error = ends(&hit, &Inputs::zero(2));
    let EngineError::OffArc { time, ball: 0, fault: Fault::Horizontal } = error else { panic!("{error}") };
    let until = run(&hit, time * (1.0 - 1e-12));
    assert!(until.in_contact(0) && (until.angle(0).to_degrees() - 90.0).abs() < 0.1);
    // Pushed back over the pivot by twice its weight.
    let pushed = Inputs { force: vec![20.0, 0.0], support_acceleration: 0.0 };
    let lifted = Parameters { x_start: vec![-1.9, 0.0], gap: vec![1.0], ..p };
    let error = ends(&lifted, &pushed);
    assert_eq!(error, EngineError::OffArc { time: 0.0, ball: 0, fault: Fault::Slack });
    assert!(error.to_string().starts_with("the string of ball 1 goes slack at t = 0 s"), "{error}");
}

/// The distance (m) of the centre of a ball from the line of another one's string, to its left.
fn left_of_string(run: &Engine, p: &Parameters, ball: usize, of: usize) -> f64 {
    let place = |i: usize| {
        let length = p.length * p.length_ratio[i];
        let pivot: f64 = p.gap[..i].iter().map(|gap| 2.0 * p.radius + gap).sum();
        (pivot + length * run.angle(i).sin(), length * (1.0 - run.angle(i).cos()))
    };
    let ((x, y), (sin, cos)) = (place(ball), run.angle(of).sin_cos());
    (place(of).0 - x) * cos + (place(of).1 - y) * sin
}

/// In flight, for which there is room beside a gap and between unequal pendulums; in contact; and rigid ones.
#[test]
fn arcs_neighbours_changing_sides_end_the_run() {
    let apart = Parameters { gap: vec![0.3], radius: 0.05, ..lifted(2, 0, 0.0) };
    let above = Parameters { x_start: vec![-0.3, 1.5], v_start: vec![4.0, 0.0], ..apart };
    let unequal = Parameters {
        length_ratio: vec![1.0, 1.5],
        x_start: vec![-1.9, 0.0],
        v_start: vec![0.0, -5.0],
        ..lifted(2, 1, 0.0)
    };
    let rigid = Parameters { contact_model: ContactModel::Rigid, ..above.clone() };
    let mut touching = Parameters { gap: vec![0.28237], radius: 0.05318, ..lifted(2, 0, 0.0) };
    (touching.exponent, touching.stiffness, touching.overlap_ref) = (1.5, 857.16, 0.01);
    (touching.x_start, touching.v_start) = (vec![-0.68, -0.21], vec![0.6, 0.65]);
    for (p, in_contact) in [(above, false), (unequal, false), (rigid, false), (touching, true)] {
        let mut engine = Engine::new(&p, &Inputs::zero(2), 0.0).unwrap();
        let error = engine.advance(2.0, &mut Unrecorded).unwrap_err();
        let EngineError::OffArc { time, ball: 0, fault: Fault::Sides } = error else { panic!("{error}") };
        assert!(error.to_string().starts_with("balls 1 and 2 change sides at t = "), "{error}");
        let shortly_before = time * if in_contact { 0.97 } else { 1.0 - 1e-12 };
        let before = run(&p, shortly_before);
        assert_eq!(before.in_contact(0), in_contact);
        assert_energy(&before, 1e-14, "before");
        // Steps in contact have some length.
        let within = if in_contact { 0.02 } else { 1e-11 };
        let margins = [left_of_string(&before, &p, 0, 1), -left_of_string(&before, &p, 1, 0)];
        assert!(margins.iter().any(|margin| (0.0..within).contains(margin)), "{margins:?} at {time}");
    }
}

#[test]
fn arcs_growing_force_lifts_a_ball_from_rest() {
    for order in 1..=3 {
        let host = Host::started_with("pendulum.model=circular x_start=0");
        assert_eq!(host.set_derivative("F_ext[1]", order, -0.5), fmi2OK);
        assert_eq!(host.step(0.0, 0.1), fmi2OK, "{}", host.error());
        assert_eq!(host.set_bytes(&host.to_bytes()), fmi2OK);
        assert_eq!(host.step(0.1, 0.9), fmi2OK, "{}", host.error());
        assert!(host.get("x[1]") < -1e-5 && host.get("x[2]") == 0.0);
        assert!(host.get("E_residual").abs() < 1e-15, "{}", host.get("E_residual"));
    }
}

#[test]
fn arcs_failed_step_shows_the_error_and_the_last_values() {
    let host = Host::started_with("pendulum.model=circular v_start[5]=20");
    assert_eq!(host.step(0.0, 0.05), fmi2OK);
    host.refused(host.step(0.05, 1.0), "pendulum 5 swings beyond 90 degrees at t = 0.");
    assert!(host.get("angle[5]") > 0.4);
}

/// The last values are those of the events before the error: against the time, strong drag would have no limit.
#[test]
fn arcs_last_values_are_those_of_the_events_before_the_error() {
    let mut p = Parameters { drag: 4e6, mass_ratio: vec![7.0, 6.0, 0.04], ..rigid(3, 3, 0.03, 0.3) };
    p.dead_band = 1e-11;
    let mut run = Engine::new(&p, &Inputs::zero(3), 0.0).unwrap();
    let error = run.advance(1.0, &mut Unrecorded).unwrap_err().to_string();
    assert!(error.contains("are pressed together at t = "), "{error}");
    assert!(
        run.time() > 0.0
            && run.time() < 0.1
            && run.total_energy() < Engine::new(&p, &Inputs::zero(3), 0.0).unwrap().total_energy()
    );
    // Without any event, those at the start of the step.
    let alone = cradle(1, "pendulum.model=circular v_start[1]=20 x_start=0");
    let mut run = Engine::new(&alone, &Inputs::zero(1), 0.0).unwrap();
    assert!(run.advance(1.0, &mut Unrecorded).is_err());
    assert_eq!((run.time(), run.x(0)), (0.0, 0.0));
}

/// As [`lifted`], with rigid contacts and no dead band.
fn rigid(balls: usize, count: usize, degrees: f64, restitution: f64) -> Parameters {
    let contact_model = ContactModel::Rigid;
    Parameters { contact_model, restitution, dead_band: 0.0, ..lifted(balls, count, degrees) }
}

/// Unequal balls, which meet off the level; impacts are the limit of ever stiffer contacts.
#[test]
fn arcs_rigid_impacts_are_the_limit_of_stiff_ones() {
    let (mass_ratio, length_ratio, gap) = (vec![1.0, 1.7, 0.6], vec![1.0, 0.8, 0.9], vec![0.2, 0.1]);
    let p = Parameters { mass_ratio, length_ratio, gap, ..rigid(3, 1, 60.0, 1.0) };
    let expected = run(&p, 3.0);
    assert!((0..2).all(|i| expected.pulses(i) > 1));
    let off = [1e8, 1e12].map(|stiffness| {
        let stiff = run(&Parameters { contact_model: ContactModel::PowerLaw, stiffness, ..p.clone() }, 3.0);
        (0..3).map(|i| (stiff.x(i) - expected.x(i)).abs()).fold(0.0, f64::max)
    });
    // As the duration of the impacts.
    assert!(off[1] < 1e-4 && (80.0..120.0).contains(&(off[0] / off[1])), "{off:?}");
}

/// With losses all end up swinging together, and the impacts have an end.
#[test]
fn arcs_rigid_balls_end_up_swinging_together() {
    let p = rigid(5, 1, 60.0, 0.5);
    let mut engine = run(&p, 60.0);
    let pulses = |engine: &Engine| (0..4).map(|i| engine.pulses(i)).collect::<Vec<_>>();
    let before = pulses(&engine);
    engine.advance(120.0, &mut Unrecorded).unwrap();
    assert_eq!(before, pulses(&engine));
    assert!(
        (1..5).all(|i| f64::max((engine.x(i) - engine.x(0)).abs(), (engine.v(i) - engine.v(0)).abs()) < 1e-13)
            && engine.total_energy() > 0.1
    );
    assert!(engine.energy_residual().abs() < 1e-13 * engine.dissipated_energy());
}

/// Equal pendulums that are pressed together are one, under the sum of the forces.
#[test]
fn arcs_pressed_equal_rigid_balls_swing_as_one() {
    let mut p = rigid(3, 3, 40.0, 0.0);
    (p.mass_ratio, p.gravity) = (vec![1.0, 2.0, 0.5], 9.0);
    let mut inputs = Inputs { force: vec![7.0, 0.0, -1.0], support_acceleration: 0.4 };
    let alone = Parameters { x_start: p.x_start[..1].to_vec(), mass: 3.5, gravity: 9.0, ..lifted(1, 1, 40.0) };
    let sum = |inputs: &Inputs| Inputs { force: vec![inputs.force.iter().sum()], ..*inputs };
    let mut body = Engine::new(&p, &inputs, 0.0).unwrap();
    let mut single = Engine::new(&alone, &sum(&inputs), 0.0).unwrap();
    for step in 1..=100 {
        for (engine, balls) in [(&mut body, 3), (&mut single, 1)] {
            if step == 50 {
                inputs.force = vec![4.0, -1.0, -2.0];
                let mut rate = Inputs::zero(3);
                rate.force[2] = -0.3;
                let (held, rate) = if balls == 3 { (inputs.clone(), rate) } else { (sum(&inputs), sum(&rate)) };
                engine.hold(&held, &[rate]).unwrap();
            }
            engine.advance(0.05 * f64::from(step), &mut Unrecorded).unwrap();
        }
        let force = |j: usize| {
            let since = 0.05 * f64::from(step - 49).max(0.0);
            let last = inputs.force[2] - if step >= 50 { 0.3 * since } else { 0.0 };
            let all = [inputs.force[0], inputs.force[1], last];
            let mean = all.iter().sum::<f64>() / 3.5;
            (0..=j).map(|i| all[i] - mean * p.mass_ratio[i]).sum::<f64>()
        };
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12 * b.abs().max(1.0), "{a}, not {b}, at {step}");
        (0..3).for_each(|i| close(body.x(i), single.x(0)));
        (0..3).for_each(|i| close(body.a(i), single.a(0)));
        (0..2).for_each(|j| close(body.force(j), force(j)));
        close(body.support_force(), single.support_force());
        close(body.support_force_vertical(), single.support_force_vertical());
        close(body.support_force_mean(), single.support_force_mean());
        close(body.external_work(), single.external_work());
        let (of_body, of_single) = (body.time_derivative(2), single.time_derivative(2));
        close(of_body.support_force, of_single.support_force);
        close(of_body.total_energy, of_single.total_energy);
        assert_energy(&body, 1e-13, "pressed");
    }
    assert_eq!(body.pulses(1), 1);
    inputs.force = vec![-1.0, 0.0, 0.0];
    body.hold(&inputs, &[]).unwrap();
    body.advance(5.1, &mut Unrecorded).unwrap();
    assert!(body.overlap(0) < 0.0 && body.force(0) == 0.0 && body.last_release(0) == 5.0);
}

#[test]
fn arcs_unequal_rigid_balls_are_not_held_together() {
    let p = rigid(3, 0, 0.0, 0.5);
    let mut inputs = Inputs::zero(3);
    inputs.force[1] = 0.1;
    let pressed = |p: &Parameters| Engine::new(p, &inputs, 0.0).and_then(|mut run| run.advance(9.0, &mut Unrecorded));
    assert_eq!(pressed(&p), Ok(()));
    let drag = Parameters { drag: 0.1, ..p.clone() };
    assert_eq!(pressed(&drag), Ok(()));
    let held = |p: Parameters| match pressed(&p) {
        Err(EngineError::OffArc { time, ball: 1, fault: Fault::Held }) => time,
        other => panic!("{other:?}"),
    };
    assert_eq!(held(Parameters { length_ratio: vec![1.0, 1.0, 0.9], ..p.clone() }), 0.0);
    assert_eq!(held(Parameters { mass_ratio: vec![1.0, 1.0, 2.0], ..drag }), 0.0);
    let chatter = held(Parameters { gap: vec![0.0, 1e-3], ..p.clone() });
    assert!((0.1..2.0).contains(&chatter), "{chatter}");
    // After the last bounce the next one is as low as rounding, but its speed is above that of velocities.
    let mut p = Parameters { radius: 0.05, length: 0.2, gravity: 4.36685759178228, mass: 1.0, ..p };
    (p.mass_ratio[1], p.length_ratio) = (0.2898942573352073, vec![0.7, 0.8072641806598986, 0.7]);
    (p.dead_band, p.restitution) = (8.667015589687107e-9, 0.3930767266892951);
    inputs.force = vec![0.0, 0.3147931646716329, -0.32796128858371404];
    let error = Engine::new(&p, &inputs, 0.0).unwrap().advance(0.1, &mut Unrecorded).unwrap_err();
    assert!(matches!(error, EngineError::OffArc { ball: 1, fault: Fault::Held, .. }), "{error}");
    let error = EngineError::OffArc { time: 0.5, ball: 1, fault: Fault::Held }.to_string();
    assert!(error.starts_with("rigid balls 2 and 3 are pressed together at t = 0.5 s; allowed"), "{error}");
}

/// Rigid balls without amplitude, whose rates differ by rounding, part at once.
#[test]
fn arcs_pulled_rigid_balls_part() {
    let mut p = rigid(3, 0, 0.0, 0.0);
    (p.gravity, p.radius, p.length) = (0.0, 0.05, 2.995241201409862);
    p.v_start = vec![0.7075077476437851, -0.2512780629875975, -0.6709155171783237];
    let mut engine = run(&p, 0.0);
    engine.hold(&Inputs { force: vec![0.0, -1.0388620362471428, 0.0], support_acceleration: 0.0 }, &[]).unwrap();
    engine.advance(0.1, &mut Unrecorded).unwrap();
    let (force, overlap) = (engine.force(0), engine.overlap(1));
    assert!(force > 0.5 && overlap < -1e-3, "{force} {overlap}");
}
