//! Derivatives by time: those of inputs, which change within a step (fmi2SetRealInputDerivatives), and those of outputs
//! (fmi2GetRealOutputDerivatives), checked against finite differences of a finely stepped run.

use cradle_host::{Host, fmi2OK};
use newtons_cradle::fmi2::*;

use crate::differences::{LAWS, outputs};

/// Position and velocity at `t` of an undamped pendulum of 1 kg that starts at -0.1 m, at rest, under a force with
/// these derivatives at t = 0, by the polynomial particular solution.
fn swing(force: [f64; 4], t: f64) -> (f64, f64) {
    let omega2: f64 = 9.81 / 1.962;
    let p = [force[0] - force[2] / omega2, force[1] - force[3] / omega2, force[2], force[3]].map(|f| f / omega2);
    let omega = omega2.sqrt();
    let (sine, cosine) = (omega * t).sin_cos();
    let (x0, v0) = (-0.1 - p[0], -p[1]);
    let particular = p[0] + t * (p[1] + t * (p[2] / 2.0 + t * p[3] / 6.0));
    let rate = p[1] + t * (p[2] + t * p[3] / 2.0);
    (particular + x0 * cosine + v0 / omega * sine, rate - omega * x0 * sine + v0 * cosine)
}

#[test]
fn input_derivatives_pendulum_under_a_cubic_force_has_its_closed_form() {
    let force = [0.4, -0.7, 2.0, -3.0];
    for pieces in [1, 8] {
        let host = Host::with_balls(1);
        host.start();
        let length = 2.0 / f64::from(pieces);
        for piece in 0..pieces {
            let t = f64::from(piece) * length;
            let rates = [force[1] + t * (force[2] + t * force[3] / 2.0), force[2] + t * force[3], force[3]];
            for (order, rate) in (1..).zip(rates) {
                assert_eq!(host.set_derivative("F_ext[1]", order, rate), fmi2OK);
            }
            if piece == 0 {
                assert_eq!(host.set("F_ext[1]", force[0]), fmi2OK); // After the derivatives: they stay.
            }
            assert_eq!(host.step(t, length), fmi2OK);
        }
        let (x, v) = swing(force, 2.0);
        assert!((host.get("x[1]") - x).abs() < 1e-14 && (host.get("v[1]") - v).abs() < 1e-14, "{pieces} pieces");
        let reached = force[0] + 2.0 * (force[1] + 2.0 * (force[2] / 2.0 + 2.0 * force[3] / 6.0));
        assert!((host.get("F_ext[1]") - reached).abs() < 1e-14);
        assert!((host.get("a[1]") - (reached - 5.0 * x)).abs() < 1e-13);
        assert!(host.get("E_residual").abs() < 1e-14);
    }
}

#[test]
fn input_derivatives_leave_the_value_they_reached() {
    let (ramp, constant) = (Host::started(), Host::started());
    assert_eq!(ramp.set_derivative("a_support", 1, 2.0), fmi2OK);
    assert_eq!(ramp.get("a_support"), 0.0);
    assert_eq!(ramp.step(0.0, 0.25), fmi2OK);
    assert_eq!(ramp.get("a_support"), 0.5);
    assert_eq!(ramp.step(0.25, 0.25), fmi2OK);
    assert_eq!(ramp.get("a_support"), 0.5);
    // p_total obeys d(p_total)/dt = sum F_ext - a_support sum m - F_support in both steps.
    let change = -5.0 * 0.5 * 0.25 - 0.25 * ramp.get("F_support_mean");
    let before = ramp.get("p_total") - change;
    assert_eq!(constant.set_derivative("a_support", 1, 2.0), fmi2OK);
    assert_eq!(constant.step(0.0, 0.25), fmi2OK);
    assert!((constant.get("p_total") - before).abs() < 1e-13);
    // A step below the resolution of doubles also ends the derivatives.
    assert_eq!(constant.set_derivative("a_support", 1, 7.0), fmi2OK);
    assert_eq!(constant.step(0.25 - 1e-13, 1e-14), fmi2OK);
    assert_eq!(constant.step(0.25, 0.25), fmi2OK);
    assert_eq!(constant.get("x[3]").to_bits(), ramp.get("x[3]").to_bits());
}

#[test]
fn input_derivatives_continue_in_the_forecast() {
    let stepped = |length: f64| {
        let host = Host::started();
        assert_eq!(host.set_derivative("F_ext[2]", 1, -0.5), fmi2OK);
        assert_eq!(host.step(0.0, length), fmi2OK);
        host
    };
    let onsets = |host: &Host| host.pulses().iter().sum::<i32>();
    let host = stepped(0.3);
    let foreseen = host.get("t_next");
    assert_eq!(onsets(&stepped(foreseen - 1e-14)), onsets(&host));
    assert_eq!(onsets(&stepped(foreseen + 1e-14)), onsets(&host) + 1);
    // From here on the input is constant.
    assert_eq!(host.step(0.3, 1e-6), fmi2OK);
    assert!((host.get("t_next") - foreseen).abs() > 1e-6);
}

#[test]
fn input_derivatives_that_are_none_are_refused() {
    let host = Host::started();
    let refused = |name: &str, order: i32, value: f64, expected: &str| {
        // A good one goes with it, and is not applied either.
        let (references, orders) = ([host.vr("F_ext[1]"), host.vr(name)], [1, order]);
        let status = unsafe {
            fmi2SetRealInputDerivatives(host.c, references.as_ptr(), 2, orders.as_ptr(), [1e3, value].as_ptr())
        };
        host.refused(status, &format!("fmi2SetRealInputDerivatives: {expected}"));
    };
    refused("F_ext[2]", 0, 1.0, "order of the derivative of F_ext[2] = 0 is refused; allowed: 1 to 3");
    refused("a_support", 4, 1.0, "order of the derivative of a_support = 4 is refused; allowed: 1 to 3");
    refused("a_support", i32::MIN, 1.0, "order of the derivative of a_support = -2147483648 is refused");
    refused("F_ext[2]", 1, f64::NAN, "derivative 1 of F_ext[2] = NaN is refused; allowed: any finite value");
    refused("x[1]", 1, 1.0, "no derivative of x[1] can be set: only those of inputs can, and its causality is Output");
    for name in ["ball.mass", "contact.model"] {
        let only = "only those of inputs can, and its causality is Parameter";
        refused(name, 1, 1.0, &format!("no derivative of {name} can be set: {only}"));
    }
    host.refused(unsafe { fmi2SetRealInputDerivatives(host.c, &u32::MAX, 1, &1, &1.0) }, "value reference 4294967295");

    let untouched = Host::started();
    assert_eq!((host.step(0.0, 0.5), untouched.step(0.0, 0.5)), (fmi2OK, fmi2OK));
    assert_eq!(host.get("x[1]").to_bits(), untouched.get("x[1]").to_bits());

    // A step on which an input would leave the range of numbers is refused, a shorter one is made.
    assert_eq!(host.set_derivative("F_ext[1]", 3, 1e300), fmi2OK);
    host.refused(host.step(0.5, 1e9), "stay finite");
    assert_eq!(host.step(0.5, 1e-200), fmi2OK);
    host.assert_usable();
}

#[test]
fn input_derivatives_before_the_first_step_act_in_it_and_reset_forgets_them() {
    let during = Host::default();
    assert_eq!(during.set_derivative("F_ext[5]", 1, 0.3), fmi2OK);
    during.start();
    let after = Host::started();
    assert_eq!(after.set_derivative("F_ext[5]", 1, 0.3), fmi2OK);
    for host in [&during, &after] {
        assert_eq!(host.step(0.0, 0.4), fmi2OK);
    }
    assert_eq!(during.get("x[5]").to_bits(), after.get("x[5]").to_bits());
    assert!(during.get("x[5]") > 1e-3);
    assert_eq!(during.set_derivative("F_ext[5]", 1, 0.3), fmi2OK);
    assert_eq!(during.reset(), fmi2OK);
    during.start();
    assert_eq!(during.step(0.0, 0.4), fmi2OK);
    assert!(during.get("x[5]").abs() < 1e-15);
}

/// Outputs that change at events only.
const STEADY: [&str; 4] = ["t_next", "F_mean", "F_peak", "F_support_mean"];

/// The first derivative of equidistant samples in the middle of nine, of eighth order.
fn difference(samples: &[f64], h: f64) -> f64 {
    let weights = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
    weights.iter().zip(1..).map(|(w, k)| w * (samples[4 + k] - samples[4 - k])).sum::<f64>() / h
}

/// Steps finely from `start` on and checks the derivatives of orders 1 to 3 against differences of the order before, by
/// the `tolerance` for their largest.
fn check(what: &str, host: &Host, (start, h, count): (f64, f64, usize), tolerance: f64) {
    let (steady, outputs): (Vec<_>, Vec<_>) = outputs(5).into_iter().partition(|of| STEADY.contains(&of.row.name));
    assert!(outputs[..5].iter().all(|of| of.row.name == "x"));
    // Sampled: the order, the output, the sample.
    let mut samples = vec![vec![Vec::new(); outputs.len()]; 4];
    for i in 0..count {
        let t = start + i as f64 * h;
        assert_eq!(host.step(t, start + (i + 1) as f64 * h - t), fmi2OK);
        for (order, samples) in (0..=3).zip(&mut samples) {
            let values = if order == 0 { host.values(&outputs) } else { host.derivatives(&outputs, order) };
            samples.iter_mut().zip(values).for_each(|(samples, value)| samples.push(value));
            assert!(order == 0 || host.derivatives(&steady, order).iter().all(|rate| *rate == 0.0), "{what}");
        }
    }
    for (order, pair) in (1..).zip(samples.windows(2)) {
        for (j, output) in outputs.iter().enumerate() {
            let (before, of_order) = (&pair[0][j], &pair[1][j]);
            let of_kind = pair[1].iter().zip(&outputs).filter(|(_, other)| other.row.name == output.row.name);
            let largest =
                of_kind.flat_map(|(values, _)| values).fold(0.0_f64, |largest, value| largest.max(value.abs()));
            // What differences make of the rounding of the samples. Those of F_support and p_total are sums over all
            // balls, whose accelerations nearly cancel.
            let magnitude =
                |samples: &[Vec<f64>]| samples.concat().into_iter().fold(0.0_f64, |m, value| m.max(value.abs()));
            let cancelled = if output.row.name.contains('_') { 5.0 * magnitude(&pair[0][..5]) } else { 0.0 };
            let rounding = (1e-14 * magnitude(&pair[0][j..=j]) + 2e-16 * cancelled) / h;
            for i in 4..count - 4 {
                let difference = difference(&before[i - 4..=i + 4], h);
                let error = (of_order[i] - difference).abs();
                assert!(
                    error <= tolerance * largest + rounding,
                    "{what}: order {order} of {output}, sample {i}: {} {difference}, largest {largest}",
                    of_order[i]
                );
            }
        }
    }
}

/// Highest order offered.
const MAX_ORDER: usize = 3;

#[test]
fn output_derivatives_agree_with_differences_in_flight_and_in_contact() {
    for (law, values) in LAWS.into_iter().filter(|(law, _)| !law.starts_with("rigid")) {
        let host = Host::started_with(&format!("contact.deadBand=0 F_ext[5]=0.4 a_support=-0.2 {values}"));
        check(&format!("{law}, in flight"), &host, (0.0, 0.01, 40), 1e-6);
        let onset = host.get("t_next");
        assert_eq!(host.step(0.4, onset - 0.4), fmi2OK);
        // Across the first impact, between switchings, across which differences are no derivatives.
        let mut t = onset;
        let mut stretches = 0;
        for _ in 0..60 {
            let (state, events) = (host.to_bytes(), host.get("solver.events"));
            let (h, count) = (2e-8, 40);
            assert_eq!(host.step(t, h * count as f64), fmi2OK);
            // Short of the release, where the force of some laws has a branch point.
            let smooth = host.get("solver.events") == events && host.get("F[2]") > 30.0;
            assert_eq!(host.set_bytes(&state), fmi2OK);
            if smooth && host.get("F[2]") > 1.0 {
                check(&format!("{law}, in contact"), &host, (t, h, count), 1e-6);
                stretches += 1;
            } else {
                assert_eq!(host.step(t, h * count as f64), fmi2OK);
            }
            t += h * count as f64;
        }
        assert!(stretches > 3, "{law}: {stretches}");
    }
}

/// Five unequal pendulums, released side by side and pressed together, swing as one: rigid ones with drag, and others.
/// A dashpot that would pull has no force, but until the overlap has fallen to 0 its contact has energy, which is lost.
#[test]
fn output_derivatives_agree_with_differences_while_a_contact_is_clipped() {
    let host = Host::started_with("contact.deadBand=0 contact.dampingLaw=kelvinVoigtNoPull contact.damping=3e4");
    let onset = host.get("t_next");
    assert_eq!(host.step(0.0, onset), fmi2OK);
    let (mut t, mut stretches, h, count) = (onset, 0, 1e-8, 40);
    let clipped = || host.get("overlap[2]") > 0.0 && host.get("F[2]") == 0.0;
    for _ in 0..200 {
        let (state, events, before) = (host.to_bytes(), host.get("solver.events"), clipped());
        assert_eq!(host.step(t, h * count as f64), fmi2OK);
        if before && clipped() && host.get("solver.events") == events {
            assert_eq!(host.set_bytes(&state), fmi2OK);
            check("clipped", &host, (t, h, count), 1e-6);
            stretches += 1;
        }
        t += h * count as f64;
    }
    assert!(stretches > 3, "{stretches}");
}

#[test]
fn output_derivatives_agree_with_differences_in_lasting_contacts() {
    let rigid = "contact.model=rigid pendulum.drag=0.4 F_ext[5]=-2 a_support=-0.2";
    let damped = "contact.damping=2e4 F_ext[5]=-3";
    // Of damped contacts the third derivative of a force is rounding from the fifth digit on, of some starts from the
    // fourth.
    for (what, settings, start, h, tolerance, least) in
        [("rigid", rigid, 0.1, 0.01, 1e-6, 0.1), ("damped", damped, 0.5, 0.02, 1e-4, 2.0)]
    {
        let unequal = "ball.massRatio=1.1,1.2,1.3,1.4,1.5 pendulum.lengthRatio=0.98,0.96,0.94,0.92,0.9";
        let host = Host::started_with(&format!("contact.deadBand=0 x_start=-0.02 {unequal} F_ext[1]=3 {settings}"));
        assert_eq!((host.set_derivative("F_ext[1]", 1, 0.2), host.step(0.0, start)), (fmi2OK, fmi2OK));
        check(what, &host, (start, h, 40), tolerance);
        assert!((1..=4).all(|i| host.get(&format!("F[{i}]")) > least));
    }
}

/// Equal pendulums pressed together until they rest against each other move as one, but for 1e-6 of what presses them:
/// the force between balls j and j + 1 is what the first j are pushed by, less their share of the mass in what all are
/// pushed by.
#[test]
fn output_derivatives_keep_their_digits_in_settled_contacts() {
    const PUSHES: [[f64; 5]; 4] = [
        [3.0, 0.2, -0.1, 0.4, -2.5],
        [0.3, 0.0, 0.1, 0.0, -0.1],
        [-0.2, 0.0, 0.0, 0.1, 0.05],
        [0.4, 0.0, 0.0, -0.2, 0.0],
    ];
    for law in [
        "contact.damping=2e4",
        "contact.exponent=3 contact.damping=2e4",
        "contact.model=hertz contact.dampingLaw=huntCrossley contact.huntCrossley=1e4",
    ] {
        for masses in [[1.0; 5], [1.0, 1.2, 0.9, 1.1, 1.3]] {
            let host = Host::default();
            host.give(&format!("contact.deadBand=0 a_support=0.1 x_start=0.02 v_start=0.3 {law}"));
            for (i, mass) in (1..).zip(masses) {
                host.give(&format!("F_ext[{i}]={} ball.massRatio[{i}]={mass}", PUSHES[0][i - 1]));
            }
            host.start();
            assert_eq!(host.step(0.0, 1.0), fmi2OK);
            // A step with constant inputs, and one with inputs that change.
            for (t, orders) in [(1.0, 0), (2.0, MAX_ORDER)] {
                for (i, order) in (0..5).flat_map(|i| (1..=orders).map(move |order| (i, order))) {
                    let value = PUSHES[order][i];
                    assert_eq!(host.set_derivative(&format!("F_ext[{}]", i + 1), order as i32, value), fmi2OK);
                }
                assert_eq!(host.step(t, 1.0), fmi2OK);
                for order in 0..=MAX_ORDER {
                    // One second after the derivatives were set.
                    let weights = [1.0, 1.0, 0.5, 1.0 / 6.0];
                    let push = |i: usize| (order..=orders).zip(weights).map(|(k, w)| w * PUSHES[k][i]).sum::<f64>();
                    let share = (0..5).map(push).sum::<f64>() / masses.iter().sum::<f64>();
                    let mut force = 0.0;
                    for j in 1..5 {
                        force += push(j - 1) - masses[j - 1] * share;
                        let name = format!("F[{j}]");
                        let found = if order == 0 { host.get(&name) } else { host.derivative(&name, order as i32) };
                        assert!((found - force).abs() < 1e-5, "{law}, {t} s, order {order} of {name}: {found} {force}");
                    }
                }
            }
        }
    }
}

#[test]
fn output_derivatives_include_those_of_inputs() {
    let host = Host::started();
    for (name, order, value) in
        [("F_ext[5]", 1, 2.0), ("F_ext[5]", 2, -3.0), ("F_ext[5]", 3, 5.0), ("a_support", 1, 0.7)]
    {
        assert_eq!(host.set_derivative(name, order, value), fmi2OK);
    }
    assert_eq!(host.step(0.0, 0.1), fmi2OK);
    // v'' = F_ext' / m - a_support' - omega^2 v, and once more.
    let rate = 2.0 - 3.0 * 0.1 + 0.5 * 5.0 * 0.01;
    assert!((host.derivative("v[5]", 2) - (rate - 0.7 - 5.0 * host.get("v[5]"))).abs() < 1e-12);
    let curvature = -3.0 + 5.0 * 0.1;
    assert!((host.derivative("v[5]", 3) - (curvature - 5.0 * host.get("a[5]"))).abs() < 1e-12);
    assert!((host.derivative("v[5]", 1) - host.get("a[5]")).abs() < 1e-13);
}

#[test]
fn output_derivatives_before_the_first_step_and_at_an_onset() {
    let host = Host::started_with("v_start[4]=0.3");
    assert_eq!((host.derivative("x[4]", 1), host.derivative("x[4]", 2), host.derivative("v[4]", 2)), (0.3, 0.0, -1.5));
    let dashpot = Host::started_with("contact.damping=2e4");
    let onset = dashpot.get("t_next");
    assert_eq!(dashpot.step(0.0, onset), fmi2OK);
    // F' = k u + c u' with the closing rate u, u' = -2 F / m, F = c u.
    let (u, f) = (dashpot.get("v[2]") - dashpot.get("v[3]"), dashpot.get("F[2]"));
    assert!((f / (2e4 * u) - 1.0).abs() < 1e-6);
    let expected = 1e10 * u - 2e4 * 2.0 * f;
    assert!((dashpot.derivative("F[2]", 1) / expected - 1.0).abs() < 1e-5);
    assert!((dashpot.derivative("impulse[2]", 1) - f).abs() < 1e-9 * f);
}

#[test]
fn output_derivatives_that_do_not_exist_are_refused() {
    let host = Host::started();
    let refused = |name: &str, order: i32, expected: &str| {
        let (references, mut values) = ([host.vr("x[1]"), host.vr(name)], [7.0; 2]);
        let status = unsafe {
            fmi2GetRealOutputDerivatives(host.c, references.as_ptr(), 2, [1, order].as_ptr(), values.as_mut_ptr())
        };
        host.refused(status, &format!("fmi2GetRealOutputDerivatives: {expected}"));
        assert_eq!(values, [7.0; 2]);
    };
    refused("x[2]", 0, "order of the derivative of x[2] = 0 is refused; allowed: 1 to 3");
    refused("F[2]", 4, "order of the derivative of F[2] = 4 is refused; allowed: 1 to 3");
    refused("F[2]", i32::MIN, "order of the derivative of F[2] = -2147483648 is refused");
    refused("overlap[2]", 1, "overlap[2] has no such derivative; allowed: real outputs");
    refused("ball.mass", 1, "ball.mass has no such derivative");
    refused("F_ext[1]", 1, "F_ext[1] has no such derivative");
    refused("pulses[1]", 1, "pulses[1] is of type Integer, not Real");
    assert_eq!(host.get("x[1]"), -0.1);
}
