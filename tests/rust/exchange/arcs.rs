//! Balls on arcs: where they are follows from the first position and the overlaps.

use cradle_host::exchange::rk4;
use cradle_host::fmi3::{self, vr};
use cradle_host::{Host, fmi2Error, fmi2OK};
use newtons_cradle::fmi2::fmi2Status::fmi2Discard;
use newtons_cradle::fmi2::*;
use newtons_cradle::fmi3::fmi3Status::{fmi3Discard, fmi3OK};
use newtons_cradle::fmi3::*;

use super::{assert_close, exchanging};

/// Unequal pendulums, lifted to places for which the nearer solution is the wrong one.
const UNEQUAL: &str = "pendulum.model=circular pendulum.length=1 pendulum.lengthRatio[2]=1.25 ball.radius=0.006 \
                       contact.deadBand=0 x_start=-0.075,-0.02";

/// Co-simulation of so many balls at the start.
fn stepped(balls: usize, settings: &str) -> Host {
    let host = Host::with_balls(balls);
    host.give(settings);
    host.start();
    host
}

#[test]
fn exchange_on_arcs_starts_at_the_given_positions() {
    let lifted = |angles: &[f64]| {
        let places: Vec<String> = angles.iter().map(|angle| (0.2 * angle.to_radians().sin()).to_string()).collect();
        format!("pendulum.model=circular pendulum.length=0.2 ball.radius=0.02 x_start={}", places.join(","))
    };
    let far_out = "pendulum.lengthRatio=10,2.5 x_start[1]=-1.9 x_start[2]=0.43";
    for (balls, settings) in [
        (2, UNEQUAL.to_owned()),
        // Touching at 70 degrees, beside balls that hang.
        (4, lifted(&[-70.0, -70.0, 0.0, 0.0])),
        (4, lifted(&[-70.0, -70.0, -70.0, -70.0])),
        (3, lifted(&[-85.0, 0.0, 85.0])),
        // The long pendulum to the left, so high that the string of the short one points at it.
        (2, format!("{} {far_out}", lifted(&[0.0, 0.0]))),
    ] {
        let other = stepped(balls, &settings);
        for contacts in [1, 2] {
            let run = exchanging(balls, &format!("{settings} exchange.contacts={contacts}"));
            assert_close(&run, &other, &["x", "v", "a", "overlap"], 1e-13);
            assert!(run.get("E_residual").abs() < 1e-12, "{settings}: {}", run.get("E_residual"));
        }
    }
}

#[test]
fn exchange_on_arcs_of_unequal_pendulums_is_co_simulation() {
    let (other, mut run) = (stepped(2, UNEQUAL), exchanging(2, UNEQUAL));
    assert!((run.get("x[2]") + 0.02).abs() < 1e-15 && (run.get("a[2]") - 0.1569).abs() < 1e-4);
    run.steps(2.0, 1e-4, rk4);
    assert_eq!(other.step(0.0, 2.0), fmi2OK);
    assert!(run.pulses()[0] >= 2, "{:?}", run.pulses());
    assert_close(&run, &other, &["x", "v", "impulse", "overlap", "t_onset"], 1e-9);
}

/// States that a solver may try: their derivatives, indicators and values do not exist, but the run goes on.
#[test]
fn exchange_on_arcs_discards_impossible_trial_states() {
    let run = exchanging(2, UNEQUAL);
    let (y, rates, indicators) = (run.states(), run.rates(), run.indicators());
    // Farther out than the pendulum is long; farther from the left ball, or closer to it, than the arc of the right one
    // reaches.
    for (place, value, why) in [
        (0, 1.5, "x[1] lies farther out than its pendulum is long at t = 0 s"),
        (1, -3.0, "no place of ball 2 within 90 degrees gives overlap[1] at t = 0 s"),
        (1, 0.02, "no place of ball 2 within 90 degrees gives overlap[1] at t = 0 s"),
    ] {
        let mut tried = y.clone();
        tried[place] = value;
        run.place(0.0, &tried);
        let (mut found, mut signs, mut x) = ([0.0; 7], [0.0; 2], 0.0);
        let answers = unsafe {
            [
                fmi2GetDerivatives(run.c, found.as_mut_ptr(), 7),
                fmi2GetEventIndicators(run.c, signs.as_mut_ptr(), 2),
                fmi2GetReal(run.c, &run.vr("a[2]"), 1, &mut x),
            ]
        };
        assert_eq!(answers, [fmi2Discard; 3], "{value}");
        // For hosts that ignore the status.
        assert!(found.iter().any(|rate| rate.is_nan()), "{found:?}");
        let log = run.log();
        let indicator = "fmi2GetEventIndicators: event indicator has no value";
        let expected = ["fmi2GetDerivatives", indicator, "fmi2GetReal: a[2]"];
        assert_eq!(log.len(), 3, "{log:?}");
        for (line, function) in log.iter().zip(expected) {
            assert!(line.text.starts_with(function) && line.text.ends_with(why), "{}", line.text);
            assert_eq!((line.status, line.category.as_str()), (fmi2Discard, "logStatusDiscard"));
        }
        // What the states say by themselves is known.
        assert_eq!(run.states(), tried);
        assert_eq!(run.get("overlap[1]"), tried[1]);
    }
    run.place(0.0, &y);
    assert_eq!((run.rates(), run.indicators()), (rates, indicators));
}

#[test]
fn exchange_on_arcs_discards_impossible_trial_states_in_fmi_3() {
    let run = fmi3::Host::exchanging();
    assert_eq!(unsafe { fmi3SetInt64(run.c, &vr("pendulum.model"), 1, &2, 1) }, fmi3OK);
    run.start();
    assert_eq!(unsafe { fmi3EnterContinuousTimeMode(run.c) }, fmi3OK);
    let y = run.vector::<17>(fmi3GetContinuousStates);
    let rates = run.vector::<17>(fmi3GetContinuousStateDerivatives);
    let mut tried = y;
    tried[3] = -5.0;
    let (mut found, mut signs, mut values) = ([0.0; 17], [0.0; 10], [0.0; 5]);
    unsafe {
        assert_eq!(fmi3SetContinuousStates(run.c, tried.as_ptr(), 17), fmi3OK);
        let answers = [
            fmi3GetContinuousStateDerivatives(run.c, found.as_mut_ptr(), 17),
            fmi3GetEventIndicators(run.c, signs.as_mut_ptr(), 10),
            fmi3GetFloat64(run.c, &vr("z.contact"), 1, values.as_mut_ptr(), 5),
            fmi3GetFloat64(run.c, &vr("x"), 1, values.as_mut_ptr(), 5),
        ];
        assert_eq!(answers, [fmi3Discard; 4]);
        assert!(found.iter().any(|rate| rate.is_nan()));
        assert_eq!(fmi3SetContinuousStates(run.c, y.as_ptr(), 17), fmi3OK);
    }
    assert_eq!(run.vector::<17>(fmi3GetContinuousStateDerivatives), rates);
}

/// A solver that halves steps that are discarded gets on where whole ones would leave the arcs.
#[test]
fn exchange_on_arcs_goes_on_with_halved_steps() {
    let run = exchanging(2, "pendulum.model=circular x_start=0.3,1.8 v_start=0,0.7");
    let euler = |y: &[f64], h: f64| -> Option<Vec<f64>> {
        let rates = run.rates();
        let next: Vec<f64> = y.iter().zip(&rates).map(|(y, rate)| y + h * rate).collect();
        run.place(h, &next);
        let mut rates = [0.0; 7];
        let status = unsafe { fmi2GetDerivatives(run.c, rates.as_mut_ptr(), 7) };
        let discarded = status == fmi2Discard;
        if discarded {
            run.place(0.0, y);
        }
        (!discarded).then_some(next)
    };
    let (y, mut h, mut halved) = (run.states(), 2.0, 0);
    while euler(&y, h).is_none() {
        (h, halved) = (0.5 * h, halved + 1);
    }
    assert!((1..10).contains(&halved), "{halved}");
}

/// The largest force of a damped contact at 60 degrees lies within a step, whose slopes there need the acceleration of
/// the overlap.
#[test]
fn exchange_on_arcs_peak_of_a_damped_contact_is_that_of_co_simulation() {
    let settings = "pendulum.model=circular gravity=0.001 pendulum.length=1 x_start=-0.87,-0.86 v_start=0.5,0 \
                    contact.stiffness=1e5 contact.dampingLaw=3 contact.huntCrossley=3 exchange.contacts=1";
    let (other, mut run) = (stepped(2, settings), exchanging(2, settings));
    assert_eq!(other.step(0.0, 0.05), fmi2OK);
    run.steps(0.05, 2.5e-4, rk4);
    let (own, expected) = (run.get("F_peak[1]"), other.get("F_peak[1]"));
    assert!((own / expected - 1.0).abs() < 2e-5, "{own} {expected}");
}

/// Between events, too.
#[test]
fn exchange_on_arcs_slack_string_ends_the_run() {
    let mut run = exchanging(2, "pendulum.model=circular x_start=-1.9,0");
    run.steps(0.1, 1e-3, rk4);
    assert!(!run.completed());
    assert_eq!(run.set("F_ext[1]", 20.0), fmi2OK);
    run.place(0.101, &rk4(&run, 0.1, 0.101));
    ends(&run, "the string of ball 1 goes slack at t = 0.101 s");
}

/// The long pendulum is at the left: where the balls are follows from their overlap all the time.
#[test]
fn exchange_on_arcs_neighbours_changing_sides_end_the_run() {
    let unequal = "pendulum.model=circular pendulum.lengthRatio[1]=1.5 x_start=0,1.9 v_start=5,0";
    for contacts in ["exchange.contacts=1", "exchange.contacts=2", "contact.model=rigid"] {
        let other = stepped(2, unequal);
        assert_eq!(other.step(0.0, 2.0), fmi2Error);
        let told = other.error();
        let told = told.split("balls 1 and 2 change sides at t = ").nth(1).and_then(|rest| rest.split(' ').next());
        let crossing: f64 = told.unwrap().parse().unwrap();
        let mut run = exchanging(2, &format!("{unequal} {contacts}"));
        run.steps(crossing - 1e-3, 1e-4, rk4);
        let states = rk4(&run, crossing - 1e-3, crossing + 1e-3);
        run.place(crossing + 1e-3, &states);
        ends(&run, "balls 1 and 2 change sides at t = ");
    }
}

/// The event that this step asks for ends the run.
fn ends(run: &Host, why: &str) {
    assert!(run.completed());
    let mut info = fmi2EventInfo {
        newDiscreteStatesNeeded: 0,
        terminateSimulation: 0,
        nominalsOfContinuousStatesChanged: 0,
        valuesOfContinuousStatesChanged: 0,
        nextEventTimeDefined: 0,
        nextEventTime: 0.0,
    };
    unsafe {
        assert_eq!(fmi2EnterEventMode(run.c), fmi2OK);
        assert_eq!(fmi2NewDiscreteStates(run.c, &mut info), fmi2Error);
    }
    let error = run.error();
    assert!(error.contains(why), "{error}");
}
