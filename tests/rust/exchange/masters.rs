//! Runs with mapped contacts by explicit methods: only the error of the method in flight is left.

use cradle_host::Host;
use cradle_host::exchange::{euler, rk4};
use cradle_host::scenes::TEN_MINUTES;

use super::{assert_close, exchanging, stepped};

/// Figure 6's set-up, with the first two of five balls pulled 1 m aside.
fn figure_6(pendulum: &str) -> String {
    format!("{} pendulum.model={pendulum}", TEN_MINUTES.1)
}

#[test]
fn exchange_mapped_rk4_keeps_the_energy_of_figure_6() {
    for whole in [true, false] {
        let mut run = exchanging(5, &figure_6("linear"));
        if whole {
            run.whole_steps(240.0, 1e-3, rk4);
        } else {
            run.steps(20.0, 1e-3, rk4);
            pulses_are_those_of_co_simulation(&run, "linear", 20.0);
            run.steps(240.0, 1e-3, rk4);
        }
        assert_eq!(run.pulses(), [171, 342, 342, 171]);
        let energy = run.get("E_total") / 5.0 - 1.0;
        assert!(energy.abs() < 1e-12, "{energy:e}");
        assert!(run.get("E_dissipated") == 0.0 && run.get("W_external") == 0.0);
    }
}

#[test]
fn exchange_mapped_rk4_follows_figure_6_on_arcs() {
    let mut run = exchanging(5, &figure_6("circular"));
    // Near a contact an overlap changes within the time in which balls pass each other, 0.03 s. Later the impacts do
    // not come one after the other any more, and rounding grows.
    run.steps(4.0, 1e-4, rk4);
    pulses_are_those_of_co_simulation(&run, "circular", 4.0);
}

fn pulses_are_those_of_co_simulation(host: &Host, pendulum: &str, time: f64) {
    let steps = stepped(&figure_6(pendulum), time);
    for (family, scale) in
        [("angle", 1.0), ("impulse", 1e2), ("t_onset", 20.0), ("t_release", 20.0), ("x", 1.0), ("v", 2.0)]
    {
        assert_close(host, &steps, &[family], 1e-9 * scale);
    }
    assert!(host.each("F_peak").iter().all(|peak| *peak > 1e7));
    assert!(host.get("E_residual").abs() < 1e-11 && host.get("solver.steps") == 0.0);
}

#[test]
fn exchange_mapped_euler_has_only_its_own_error_in_flight() {
    let mut run = exchanging(5, &figure_6("linear"));
    let (h, steps) = (1e-3, 20_000);
    run.whole_steps(f64::from(steps) * h, h, euler);
    // Every step multiplies the energy of a pendulum by 1 + omega^2 h^2, whatever its phase.
    let expected = (1.0 + 5.0 * h * h).powi(steps);
    let relative = run.get("E_total") / (5.0 * expected) - 1.0;
    assert!(relative.abs() < 1e-11, "{relative:e}");
    assert!(run.pulses().iter().all(|pulses| *pulses > 10), "{:?}", run.pulses());
}

#[test]
fn exchange_mapped_one_ball_swings_and_two_free_balls_meet_once() {
    let mut alone = exchanging(1, "");
    assert_eq!((alone.next, alone.states().len(), alone.indicators().len()), (f64::INFINITY, 4, 0));
    alone.steps(1.0, 1e-3, rk4);
    let (x, expected) = (alone.get("x[1]"), -0.1 * 5f64.sqrt().cos());
    assert!((x - expected).abs() < 1e-12, "{x} {expected}");
    let mut pair = exchanging(2, "gravity=0 v_start[1]=1");
    assert!((pair.next - 0.100_002_6).abs() < 1e-12, "{}", pair.next);
    pair.steps(1.0, 0.1, euler);
    assert_eq!((pair.get("pulses[1]"), pair.next), (1.0, f64::INFINITY));
    assert!(pair.get("v[1]").abs() < 1e-13 && (pair.get("v[2]") - 1.0).abs() < 1e-13);
    assert!((pair.get("impulse[1]") - 1.0).abs() < 1e-12);
}
