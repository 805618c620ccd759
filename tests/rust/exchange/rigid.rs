//! Rigid contacts in model exchange: impulses in events.

use cradle_host::exchange::rk4;
use cradle_host::fmi2OK;

use super::{assert_close, exchanging, stepped};

const PENDULUMS: [&str; 2] = ["linear", "circular"];

/// Rigid contacts with these pendulums, this coefficient of restitution and these settings.
fn rigid(pendulum: &str, restitution: f64, settings: &str) -> String {
    format!("contact.model=rigid pendulum.model={pendulum} contact.restitution={restitution} {settings}")
}

#[test]
fn impacts_are_those_of_co_simulation() {
    for (restitution, pendulum) in [1.0, 0.9].into_iter().flat_map(|e| PENDULUMS.map(|model| (e, model))) {
        let settings = rigid(pendulum, restitution, "");
        let (other, mut run) = (stepped(&settings, 3.0), exchanging(5, &settings));
        run.steps(3.0, 1e-3, rk4);
        assert_close(&run, &other, &["x", "v", "impulse", "t_onset"], 1e-9);
        assert!(run.get("E_residual").abs() < 1e-12, "{}", run.get("E_residual"));
    }
}

#[test]
fn pressed_balls_move_as_a_body_until_they_part() {
    for pendulum in PENDULUMS {
        let mut run = exchanging(5, &rigid(pendulum, 0.5, "contact.deadBand=0 x_start=0 F_ext[1]=5 F_ext[5]=-3"));
        let forces = run.each("F");
        assert!(forces.iter().zip([4.6, 4.2, 3.8, 3.4]).all(|(own, force)| (own - force).abs() < 1e-12), "{forces:?}");
        assert_eq!(run.each("inContact"), [1.0; 4]);
        assert!(run.each("a").iter().all(|a| (a - 0.4).abs() < 1e-12), "{:?}", run.each("a"));
        assert!((run.sensitivity("F[2]", "F_ext[1]") - 0.6).abs() < 1e-12);
        run.steps(0.1, 1e-3, rk4);
        assert_eq!(run.pulses(), [1; 4]);
        // Now they are pulled apart: the contacts open in the event that the indicators ask for.
        assert_eq!(run.set("F_ext[1]", -5.0), fmi2OK);
        assert!(run.indicators()[4..].iter().any(|z| *z < 0.0));
        run.step(0.101, rk4);
        assert_eq!((run.get("inContact[1]"), run.get("inContact[4]")), (0.0, 1.0));
        assert!(run.get("t_release[1]") > 0.1);
    }
}

#[test]
fn chatter_comes_to_an_end() {
    for pendulum in PENDULUMS {
        let pressed = "contact.deadBand=0 x_start=-0.01,0,0,0,0 F_ext[1]=5 F_ext[5]=-5";
        let mut run = exchanging(5, &rigid(pendulum, 0.5, pressed));
        run.steps(2.0, 1e-3, rk4);
        assert!(run.events < 1000, "{}", run.events);
        assert_eq!(run.each("inContact"), [1.0; 4]);
        assert!(run.get("E_residual").abs() < 1e-9, "{}", run.get("E_residual"));
    }
}
