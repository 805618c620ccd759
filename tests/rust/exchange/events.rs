//! Events: contacts at rest, simultaneous ones, contacts closed from the start, inputs that change at an onset, chains
//! that stay pressed, impulses of rigid balls.

use cradle_host::exchange::{Master, euler, rk4};
use cradle_host::{Host, fmi2OK};

use super::{assert_close, exchanging, stepped};

fn with(settings: &str, contacts: i32) -> Master {
    exchanging(5, &format!("{settings} exchange.contacts={contacts}"))
}

const AT_REST: &str = "contact.deadBand=0 x_start=0";
const ONE_LIFTED: &str = "contact.deadBand=0 x_start[2]=0";
const BOTH_ENDS: &str = "x_start=-0.1,0,0,0,0.1";

#[test]
fn exchange_balls_at_rest_in_touch_stay_so() {
    for contacts in [1, 2] {
        let mut run = with(AT_REST, contacts);
        assert_eq!(run.next, f64::INFINITY);
        run.whole_steps(1.0, 1e-2, rk4);
        assert!(run.states().iter().all(|state| *state == 0.0));
        assert!(run.indicators()[..4].iter().all(|z| *z < 0.0) && run.indicators()[4..] == [1.0; 4]);
        assert_eq!((run.pulses(), run.events), (vec![0; 4], 1));
    }
}

#[test]
fn exchange_ball_hits_four_at_rest_in_touch() {
    let mut run = with(ONE_LIFTED, 2);
    run.steps(1.0, 1e-3, rk4);
    let other = stepped(ONE_LIFTED, 1.0);
    assert_close(&run, &other, &["x", "v", "impulse", "overlap", "t_onset"], 1e-12);
    assert_peaks(&run, &other, 4, 1e-12);
    run.steps(20.0, 1e-3, rk4);
    let energy = run.get("E_total") / 0.025 - 1.0;
    assert!(energy.abs() < 1e-11, "{energy:e}");
}

#[test]
fn exchange_ties_from_both_ends_stay_mirrored() {
    let mut run = with(BOTH_ENDS, 2);
    for k in 1..=10 {
        run.steps(f64::from(k), 1e-3, rk4);
        let (x, pulses) = (run.each("x"), run.pulses());
        assert!((0..5).all(|i| (x[i] + x[4 - i]).abs() < 1e-6), "{x:?}");
        assert!((0..4).all(|i| pulses[i] == pulses[3 - i]), "{pulses:?}");
    }
    assert_eq!(run.pulses(), stepped(BOTH_ENDS, 10.0).pulses());
    assert!(run.get("E_residual").abs() < 1e-13);
}

#[test]
fn exchange_contacts_closed_at_the_start_are_followed() {
    let settings = "contact.deadBand=0 x_start=2e-8,0,0,-1e-8,0 v_start[5]=-0.1";
    for (contacts, h) in [(1, 1e-8), (2, 1e-3)] {
        let (host, all) = (Host::exchanging(5), format!("{settings} exchange.contacts={contacts}"));
        host.give(&all);
        assert_eq!((host.set_up(0.0), host.enter()), (fmi2OK, fmi2OK));
        assert_eq!((host.pulses(), host.get("t_onset[1]")), (vec![1, 0, 1, 0], 0.0));
        assert!(host.get("F[1]") > 0.0 && host.get("inContact[1]") == 1.0);
        assert_eq!(host.reset(), fmi2OK);
        host.give(&all);
        let mut run = Master::start(host);
        if contacts == 2 {
            assert_eq!((run.get("F[1]"), run.get("inContact[1]")), (0.0, 0.0));
        }
        let until = if contacts == 1 { 1e-5 } else { 0.1 };
        let other = stepped(settings, until);
        run.steps(until, h, rk4);
        let tolerance = if contacts == 1 { 1e-6 } else { 1e-11 };
        assert_close(&run, &other, &["x", "v", "impulse"], tolerance);
        assert_close(&run, &other, &["t_release"], 1e-9);
    }
}

#[test]
fn exchange_input_changed_at_an_onset_acts_within_the_contact() {
    let other = Host::started();
    let onset = other.get("t_next");
    assert_eq!([other.step(0.0, onset), other.set("F_ext[3]", 50.0), other.step(onset, 1e-4)], [fmi2OK; 3]);
    let mut run = with("", 2);
    run.steps(run.next - 1e-3, 1e-3, rk4);
    // Swings in closed form, to be there exactly.
    let (omega, tau) = (5f64.sqrt(), onset - run.time);
    let (x, v) = (run.get("x[1]"), run.get("v[1]"));
    let mut there = run.states();
    there[0] = x * (omega * tau).cos() + v / omega * (omega * tau).sin();
    let speed = v * (omega * tau).cos() - x * omega * (omega * tau).sin();
    (there[5], there[6], there[2]) = (speed, speed, 0.0);
    run.place(onset, &there);
    assert_eq!(run.set("F_ext[3]", 50.0), fmi2OK);
    run.time = onset;
    run.event();
    assert!(run.pulses().iter().sum::<i32>() > 0);
    run.steps(onset + 1e-4, 1e-5, rk4);
    assert_close(&run, &other, &["x", "v"], 1e-7);
}

#[test]
fn exchange_mapped_leaves_a_pressed_chain_to_the_solver() {
    // Without gravity no period limits the duration of a group.
    for (gravity, contacts) in [(9.81, 1), (9.81, 2), (0.0, 1), (0.0, 2)] {
        let settings = format!("{AT_REST} gravity={gravity} F_ext[1]=1e3 F_ext[5]=-1e3 contact.damping=1e5");
        let (other, mut run) = (stepped(&settings, 1e-3), with(&settings, contacts));
        assert!(run.next < 1e-12);
        run.steps(2e-6, 1e-7, rk4);
        assert_eq!(run.next, f64::INFINITY);
        assert!(run.each("inContact").contains(&1.0));
        run.steps(1e-3, 1e-7, rk4);
        assert_close(&run, &other, &["overlap"], 1e-12);
        assert_close(&run, &other, &["F"], 1e-2);
        assert!(run.each("F").iter().all(|force| (force - 1e3).abs() < 1.0), "{:?}", run.each("F"));
    }
}

#[test]
fn exchange_mapped_follows_an_impact_beside_a_pressed_pair() {
    // The pair is pressed from the start, or closes a microsecond after that, within the impact.
    for (overlap, closed) in [(1e-7, true), (-1e-8, false)] {
        let forces = "F_ext[4]=1e3 F_ext[5]=-1e3";
        let settings = format!("contact.deadBand=0 x_start=-0.99998e-3,-1e-3,0,{},1e-3 {forces}", 1e-3 + overlap);
        let (mut run, other) = (with(&settings, 2), stepped(&settings, 1e-4));
        assert_eq!((run.pulses()[..3].to_vec(), run.get("F[1]")), (vec![1, 0, 0], 0.0));
        assert_eq!(run.each("inContact"), [0.0, 0.0, 0.0, f64::from(closed)]);
        run.steps(1e-4, 1e-8, rk4);
        assert_eq!(run.pulses()[0], 1);
        assert_close(&run, &other, &["overlap"], 1e-11);
        for (i, tolerance) in [(1, 1e-12), (2, 1e-12), (4, 1e-4), (5, 1e-4)] {
            let (own, other) = (run.get(&format!("v[{i}]")), other.get(&format!("v[{i}]")));
            assert!((own - other).abs() < tolerance, "v[{i}]: {own:e} {other:e}");
        }
    }
}

#[test]
fn exchange_late_event_goes_back_to_every_onset() {
    let mut run = with(BOTH_ENDS, 2);
    for k in 1..=500 {
        run.whole_steps(0.02 * f64::from(k), 0.02, euler);
        for i in 1..5 {
            let (overlap, rate) = (run.get(&format!("overlap[{i}]")), run.get(&format!("der(overlap[{i}])")));
            assert!(overlap <= 0.0 || rate <= 0.0, "{i} {overlap:e} {rate:e} at {}", run.time);
        }
    }
    assert!(run.pulses().iter().all(|pulses| *pulses >= 7), "{:?}", run.pulses());
}

#[test]
fn exchange_event_with_nothing_due_changes_nothing() {
    for contacts in [1, 2] {
        let mut run = with("", contacts);
        // Up to the first onset where the host would have to integrate it.
        for k in 1..if contacts == 1 { 14 } else { 40 } {
            run.steps(0.05 * f64::from(k), 1e-3, rk4);
            let (before, next) = (run.everything(), run.next);
            let info = run.host.event();
            assert_eq!(info.valuesOfContinuousStatesChanged, 0);
            let differs = |(a, b): (&u64, &u64)| a != b;
            let changed = before.iter().zip(&run.everything()).filter(|pair| differs(*pair)).count();
            // But for the next onset, which is foretold anew from the states.
            assert!(changed <= 1 && (info.nextEventTime - next).abs() < 1e-9 || next == f64::INFINITY, "{changed}");
        }
    }
}

#[test]
fn exchange_resolved_pulse_is_that_of_co_simulation() {
    let other = stepped("", 0.71);
    let mut run = with("", 1);
    run.steps(0.70, 1e-3, rk4);
    while run.time < 0.71 {
        let closed = run.each("inContact").contains(&1.0);
        let near = run.each("overlap").iter().any(|overlap| overlap.abs() < 1e-5);
        let h = match (closed, near) {
            (true, _) => 2e-8,
            (false, true) => 1e-6,
            (false, false) => 1e-4,
        };
        run.step((run.time + h).min(run.next).min(0.71), rk4);
    }
    assert_close(&run, &other, &["x", "v", "impulse"], 1e-6);
    assert_close(&run, &other, &["t_onset", "t_release"], 1e-7);
    for (own, other) in run.each("F_peak").into_iter().zip(other.each("F_peak")) {
        assert!((own / other - 1.0).abs() < 1e-3, "{own} {other}");
    }
    assert_peaks(&run, &other, 6, 1e-7);
}

/// Asserts that the logs have so many pulses, with the times (s) of their peaks this close.
#[track_caller]
fn assert_peaks(run: &Host, other: &Host, count: usize, allowed: f64) {
    let [own, other] = [run, other].map(|host| {
        let time = |line: &str| line.split_once("peakTime=").map(|(_, time)| time.parse::<f64>().unwrap());
        let mut times: Vec<f64> = host.log().iter().filter_map(|line| time(&line.text)).collect();
        times.sort_by(f64::total_cmp);
        times
    });
    assert_eq!([own.len(), other.len()], [count; 2]);
    assert!(own.iter().zip(&other).all(|(own, other)| (own - other).abs() < allowed), "{own:?} {other:?}");
}

/// A run with resolved contacts to the first onset; one pulse comes after the other.
fn at_an_onset(settings: &str) -> Master {
    let mut run = with(settings, 1);
    run.steps(0.70, 1e-3, rk4);
    while !run.each("inContact").contains(&1.0) {
        let near = run.each("overlap").iter().any(|overlap| overlap.abs() < 1e-5);
        run.step((run.time + if near { 1e-7 } else { 1e-5 }).min(run.next), rk4);
    }
    run
}

/// What a solver tries and rejects is no part of a pulse, and reading changes nothing that is saved.
#[test]
fn exchange_rejected_trial_leaves_no_trace() {
    let [plain, tried] = [false, true].map(|tries| {
        let mut run = at_an_onset(APART);
        while run.each("inContact").contains(&1.0) {
            let (states, bytes) = (run.states(), run.to_bytes());
            let mut deep = states.clone();
            deep[1..5].iter_mut().for_each(|overlap| *overlap += 1e-3);
            for time in [run.time + 1e-8, run.time + 1e-6, run.time].into_iter().filter(|_| tries) {
                run.place(time, &deep);
                assert!(run.rates().iter().any(|rate| *rate > 1e6));
                run.everything();
                run.indicators();
            }
            run.place(run.time, &states);
            assert!(run.to_bytes() == bytes, "at {}", run.time);
            run.step(run.time + 1e-7, rk4);
        }
        run.to_bytes()
    });
    assert!(plain == tried);
}

const APART: &str = "contact.deadBand=1e-4";

/// Many steps of a solver that reports none of them.
fn unreported(host: &Host, from: f64, to: f64) -> Vec<f64> {
    let steps = 4000;
    let place = |k: i32| from + (to - from) * f64::from(k) / f64::from(steps);
    for k in 0..steps {
        let states = rk4(host, place(k), place(k + 1));
        host.place(place(k + 1), &states);
    }
    host.states()
}

/// The peak of a pulse follows from its ends and its impulse, if the host reports no steps within.
#[test]
fn exchange_pulse_within_one_step_has_a_peak() {
    for (exponent, off) in [(1.0, -0.0027), (1.5, 0.019), (3.0, -0.285)] {
        let settings = format!("{APART} contact.exponent={exponent}");
        let mut run = at_an_onset(&settings);
        let other = stepped(&settings, run.time + 1e-4);
        let release = other.get("t_release[2]");
        assert!(run.time < release && run.get("inContact[2]") == 1.0);
        run.step(release + 1e-9, unreported);
        assert_eq!(run.get("inContact[2]"), 0.0);
        let error = run.get("F_peak[2]") / other.get("F_peak[2]") - 1.0;
        assert!((error - off).abs() < 2e-3, "{exponent}: {error}");
    }
}

const PENDULUMS: [&str; 2] = ["linear", "circular"];

/// Rigid contacts with these pendulums, this coefficient of restitution and these settings.
fn rigid(pendulum: &str, restitution: f64, settings: &str) -> String {
    format!("contact.model=rigid pendulum.model={pendulum} contact.restitution={restitution} {settings}")
}

#[test]
fn exchange_rigid_impacts_are_those_of_co_simulation() {
    for (restitution, pendulum) in [1.0, 0.9].into_iter().flat_map(|e| PENDULUMS.map(|model| (e, model))) {
        let settings = rigid(pendulum, restitution, "");
        let (other, mut run) = (stepped(&settings, 3.0), exchanging(5, &settings));
        run.steps(3.0, 1e-3, rk4);
        assert_close(&run, &other, &["x", "v", "impulse", "t_onset"], 1e-9);
        assert!(run.get("E_residual").abs() < 1e-12, "{}", run.get("E_residual"));
    }
}

#[test]
fn exchange_pressed_rigid_balls_move_as_a_body_until_they_part() {
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
fn exchange_chatter_of_rigid_balls_ends() {
    for pendulum in PENDULUMS {
        let pressed = "contact.deadBand=0 x_start=-0.01,0,0,0,0 F_ext[1]=5 F_ext[5]=-5";
        let mut run = exchanging(5, &rigid(pendulum, 0.5, pressed));
        run.steps(2.0, 1e-3, rk4);
        assert!(run.events < 1000, "{}", run.events);
        assert_eq!(run.each("inContact"), [1.0; 4]);
        assert!(run.get("E_residual").abs() < 1e-9, "{}", run.get("E_residual"));
    }
}
