//! Steps that would take days.

use newtons_cradle::engine::Simulation;
use newtons_cradle::model::{Inputs, Parameters};

use crate::runs::cradle;

/// A step of this length (s) that would take days ends in an error, which says why.
#[track_caller]
fn is_hopeless(parameters: &Parameters, step: f64, why: &str) {
    let mut run = Simulation::new(parameters, &Inputs::zero(parameters.balls()), 0.0).unwrap();
    let error = run.advance(step, &mut Vec::new()).unwrap_err().to_string();
    assert!(error.starts_with("the step would take days: at t = ") && error.contains(why), "{error}");
}

#[test]
fn hopeless_step_of_too_many_events_ends_in_an_error() {
    is_hopeless(&cradle(2, "gravity=1e100"), 1.0, "contact 1 needs ");
}

/// The series of a flight are short where a pendulum is, or gravity is so strong.
#[test]
fn hopeless_step_of_too_long_a_flight_ends_in_an_error() {
    let cradles = [(1, "pendulum.length=1e-30 x_start=-1e-31"), (2, "gravity=1e100 ball.massRatio[2]=1e-300")];
    for (balls, settings) in cradles {
        let parameters = cradle(balls, &format!("pendulum.model=circular {settings}"));
        is_hopeless(&parameters, 0.25, "the flight of ball 1 needs ");
    }
}

#[test]
fn hopeless_step_of_a_general_purpose_solver_ends_in_an_error() {
    is_hopeless(&cradle(5, "solver.method=rk4 solver.fixedStep=1e-20"), 0.01, "the solver needs 1.0e20 steps ");
}
