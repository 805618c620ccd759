//! Inputs that change within a step: fmi2SetRealInputDerivatives.

use cradle_host::{Host, fmi2OK};
use newtons_cradle::fmi2::*;

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
fn a_pendulum_under_a_cubic_force_swings_in_closed_form() {
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
fn the_input_keeps_the_value_it_reached() {
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
fn the_next_onset_continues_the_inputs_of_the_last_step() {
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
fn what_is_no_derivative_is_refused() {
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
fn derivatives_given_before_the_first_step_act_in_it_and_a_reset_forgets_them() {
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
