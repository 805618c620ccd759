//! Rigid contacts in model exchange: impulses in events.

use cradle_host::exchange::{Master, Method};
use cradle_host::fmi2OK;

use super::{assert_close, exchanging, stepped};

/// On lines and on arcs.
const PENDULUMS: [f64; 2] = [1.0, 2.0];

/// Rigid contacts with these pendulums, this coefficient of restitution and these values.
fn rigid<'a>(pendulum: f64, restitution: f64, values: &[(&'a str, f64)]) -> Vec<(&'a str, f64)> {
    let rigid = [("contact.model", 3.0), ("pendulum.model", pendulum), ("contact.restitution", restitution)];
    [&rigid, values].concat()
}

#[test]
fn impacts_are_those_of_co_simulation() {
    for (restitution, pendulum) in [1.0, 0.9].into_iter().flat_map(|e| PENDULUMS.map(|model| (e, model))) {
        let values = rigid(pendulum, restitution, &[]);
        let (other, host) = (stepped(&values, 3.0), exchanging(&values));
        let mut master = Master::start(&host);
        master.steps(3.0, 1e-3, Method::Rk4);
        assert_eq!(host.pulses(), other.pulses(), "{restitution}");
        assert_close(&host, &other, &["x", "v", "impulse", "t_onset"], 1e-9);
        assert!(host.get("E_residual").abs() < 1e-12, "{}", host.get("E_residual"));
    }
}

#[test]
fn pressed_balls_move_as_a_body_until_they_part() {
    let values =
        [("contact.deadBand", 0.0), ("x_start[1]", 0.0), ("x_start[2]", 0.0), ("F_ext[1]", 5.0), ("F_ext[5]", -3.0)];
    for pendulum in PENDULUMS {
        let host = exchanging(&rigid(pendulum, 0.5, &values));
        let mut master = Master::start(&host);
        for (i, force) in [(1, 4.6), (2, 4.2), (3, 3.8), (4, 3.4)] {
            assert!((host.get(&format!("F[{i}]")) - force).abs() < 1e-12);
            assert!(host.get_boolean(&format!("inContact[{i}]")));
        }
        assert!((1..6).all(|i| (host.get(&format!("a[{i}]")) - 0.4).abs() < 1e-12));
        assert!((host.sensitivity("F[2]", "F_ext[1]") - 0.6).abs() < 1e-12);
        master.steps(0.1, 1e-3, Method::Rk4);
        assert_eq!(host.pulses(), [1; 4]);
        // Now they are pulled apart: the contacts open in the event that the indicators ask for.
        assert_eq!(host.set("F_ext[1]", -5.0), fmi2OK);
        assert!(host.indicators()[4..].iter().any(|z| *z < 0.0));
        master.step(0.101, Method::Rk4);
        assert!(!host.get_boolean("inContact[1]") && host.get_boolean("inContact[4]"));
        assert!(host.get("t_release[1]") > 0.1);
    }
}

#[test]
fn chatter_comes_to_an_end() {
    let values =
        [("contact.deadBand", 0.0), ("x_start[1]", -0.01), ("x_start[2]", 0.0), ("F_ext[1]", 5.0), ("F_ext[5]", -5.0)];
    for pendulum in PENDULUMS {
        let host = exchanging(&rigid(pendulum, 0.5, &values));
        let mut master = Master::start(&host);
        master.steps(2.0, 1e-3, Method::Rk4);
        assert!(master.events < 1000, "{}", master.events);
        assert!((1..5).all(|i| host.get_boolean(&format!("inContact[{i}]"))));
        assert!(host.get("E_residual").abs() < 1e-9, "{}", host.get("E_residual"));
    }
}
