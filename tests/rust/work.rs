//! What runs cost at most, in steps, evaluations of contact forces and events. Where that follows from the physics,
//! running.rs knows it exactly.

use std::ops::RangeInclusive;

use newtons_cradle::engine::{History, Simulation};
use newtons_cradle::model::{Inputs, Parameters};

use crate::runs::{cradle, touching};

/// A run without inputs takes at most so many steps and evaluations, and so many events.
fn assert_bounds(parameters: &Parameters, time: f64, steps: u64, evaluations: u64, events: RangeInclusive<u64>) {
    let mut run = Simulation::new(parameters, &Inputs::zero(parameters.balls()), 0.0).unwrap();
    run.advance(time, &mut Vec::new()).unwrap();
    let work = run.work();
    let within = work.steps <= steps && work.evaluations <= evaluations && events.contains(&work.events);
    assert!(within, "{work:?}, at most {steps} steps, {evaluations} evaluations, events within {events:?}");
}

/// Steel balls that touch: four pulses a group, where those of two balls alone are one step each without damping.
#[test]
fn work_of_a_minute_of_touching_steel_balls() {
    for (losses, steps, evaluations, events) in [
        ("", 1600, 16_400, 620..=630),
        ("contact.dampingLaw=huntCrossley contact.huntCrossley=0.05", 2000, 19_000, 615..=630),
        // Four more switchings a group: where the forces would begin to pull.
        ("contact.dampingLaw=viscoelastic contact.relaxationTime=4e-7", 2400, 21_800, 915..=940),
    ] {
        let parameters = cradle(5, &format!("contact.model=hertz contact.deadBand=0 {losses}"));
        assert_bounds(&parameters, 60.0, steps, evaluations, events);
    }
}

/// A line of steel balls that touch, the first struck to 1 m/s: a wave through all of them, which leaves them at rest
/// but for the first and the last ones.
#[test]
fn work_of_a_wave_through_a_hundred_steel_balls() {
    let parameters = touching(100, "contact.model=hertz gravity=0 v_start[1]=1");
    assert_bounds(&parameters, 0.02, 700, 36_500, 175..=200);
}

/// One ball strikes four that touch at 1 m/s: a few steps for each of the eight switchings, whether a power is a
/// product or not.
#[test]
fn work_of_a_collision_with_any_exponent() {
    for exponent in [1.25, 1.5, 1.7, 2.0, 2.3, 2.75, 3.0, 4.0] {
        let parameters = touching(5, &format!("x_start[1]=-1e-3 v_start[1]=1 contact.exponent={exponent}"));
        assert_bounds(&parameters, 2e-3, 27, 550, 8..=8);
    }
}

/// Damped balls that are pressed together take many steps to the next onset, which is followed only for who
/// asks for its time.
#[test]
fn work_of_a_derivative_is_that_of_its_step() {
    let parameters = touching(5, "contact.damping=1e4 x_start[1]=-0.1");
    let (pressed, along) = ([0.0, 5.0, 0.0, 0.0, -5.0], [1.0, 0.0, 0.0, 0.0, 0.0]);
    let [pressed, along] = [pressed, along].map(|force| Inputs { force: force.to_vec(), ..Inputs::zero(5) });
    let mut run = Simulation::new(&parameters, &pressed, 0.0).unwrap();
    run.advance(1e-6, &mut Vec::new()).unwrap();
    let derivatives = |next_onset: bool| {
        let found = run.sensitivity_of_step(&History::default(), &along, next_onset).unwrap();
        assert!((found.x[0] - 5e-13).abs() < 1e-24, "{:e}", found.x[0]);
        let step = run.last_step().with_next_onset(next_onset);
        step.at_end_along_inputs(&along);
        (found.next_onset, step.steps_to_onset())
    };
    let (not_asked, none) = derivatives(false);
    assert!(not_asked.is_nan() && none == 0, "{not_asked}, {none} steps");
    let (asked, many) = derivatives(true);
    assert!(asked < 0.0 && many > 20, "{asked}, {many} steps");
}

/// Orders and steps follow from the errors that a step has made, and that other orders would have: who is wrong about
/// one of them by a factor takes more steps, to the same result.
#[test]
fn work_shows_that_error_estimates_are_right() {
    for (method, steps, evaluations) in [("adams", 702, 1210), ("bdf", 1660, 4450)] {
        let contacts = "contact.exponent=2.5 contact.stiffness=1e6";
        let parameters = cradle(5, &format!("{contacts} solver.method={method} solver.tolerance=1e-10"));
        assert_bounds(&parameters, 1.0, steps, evaluations, 8..=8);
    }
}
