//! A run through the C functions: time, values before and after a setter, the log.

use std::ptr::null;

use cradle_host::{Host, Instantiate, Line, fmi2Error, fmi2OK, scenes};
use newtons_cradle::fmi2::*;
use newtons_cradle::variables::{Access, Row, TABLE};

#[test]
fn initialization_mode_shows_the_values_that_are_set() {
    let host = Host::default();
    assert_eq!(host.set("x_start[1]", -0.2), fmi2OK);
    assert_eq!(host.set_up(3.0), fmi2OK);
    assert_eq!(host.enter(), fmi2OK);
    assert_eq!(host.get("x[1]"), -0.2);
    assert_eq!(host.set("x_start[1]", -0.3), fmi2OK);
    assert_eq!((host.get("x[1]"), host.get("x_start[1]")), (-0.3, -0.3));
    assert!((host.get("pendulum.period") - 2.0 * std::f64::consts::PI / 5f64.sqrt()).abs() < 1e-12);
    assert_eq!(host.set("gravity", 0.0), fmi2OK);
    assert_eq!(host.get("pendulum.period"), 1e30);
    host.give("gravity=9.81 contact.model=hertz");
    assert_eq!((host.get("contact.model"), host.get("solver.method")), (2.0, 1.0));
    assert_eq!(host.exit(), fmi2OK);
    assert_eq!((host.get("x[1]"), host.get("t_onset[1]"), host.get("pulses[1]")), (-0.3, -1e30, 0.0));
    assert_eq!(host.step(3.0, 0.1), fmi2OK);
    assert_ne!(host.get("x[1]"), -0.3);
}

#[test]
fn means_before_the_first_step_are_the_values() {
    let host = Host::started_with("x_start[2]=1e-5");
    let (force, support) = (host.get("F[2]"), host.get("F_support"));
    assert!(force > 0.0 && support != 0.0);
    assert_eq!((host.get("F_mean[2]"), host.get("F_peak[2]")), (force, force));
    assert_eq!(host.get("F_support_mean"), support);
    assert_eq!((host.get("pulses[2]"), host.get("inContact[2]"), host.get("t_onset[2]")), (1.0, 1.0, 0.0));
}

#[test]
fn getters_after_a_setter_answer_from_before() {
    let host = Host::started();
    assert_eq!(host.step(0.0, 0.1), fmi2OK);
    let outputs = ["x[5]", "v[5]", "a[5]", "E_total", "F_support", "t_next"];
    let before = outputs.map(|name| host.get(name));
    for (name, value) in [("F_ext[5]", 100.0), ("a_support", 3.0), ("pendulum.drag", 0.5)] {
        assert_eq!(host.set(name, value), fmi2OK);
        assert_eq!(host.get(name), value);
    }
    assert_eq!(outputs.map(|name| host.get(name)), before);
    assert_eq!(host.step(0.1, 0.1), fmi2OK);
    assert!(host.get("x[5]") > 0.1 && host.get("E_dissipated") > 0.0);
}

#[test]
fn setters_of_unchanged_values_change_nothing() {
    let run = |set: bool| {
        let host = Host::started();
        for i in 0..200 {
            if set {
                for name in ["F_ext[1]", "a_support", "pendulum.drag", "contact.damping"] {
                    assert_eq!(host.set(name, 0.0), fmi2OK);
                }
                for rate in [1.0, 0.0] {
                    assert_eq!(host.set_derivative("F_ext[2]", 1 + i % 3, rate), fmi2OK);
                }
            }
            assert_eq!(host.step(f64::from(i) * 0.01, 0.01), fmi2OK);
        }
        ["x[1]", "v[3]", "impulse[2]", "E_residual"].map(|name| host.get(name).to_bits())
    };
    assert_eq!(run(true), run(false));
}

#[test]
fn time_of_the_host_is_adopted() {
    let host = Host::started();
    let mut time = 0.0;
    for i in 0..1000 {
        let current = f64::from(i) * 0.01; // Ulps off the sum of the steps.
        assert_eq!(host.step(current, 0.01), fmi2OK);
        time = current + 0.01;
        assert_eq!(host.time(), Some(time));
    }
    // A step below the resolution of the clock is a step all the same.
    assert_eq!(host.step(time - 1e-12, 1e-15), fmi2OK);
    assert_eq!(host.time(), Some(time));
    assert_eq!(host.step(time, 1e-9), fmi2OK);
    assert!(host.log().is_empty());
}

#[test]
fn step_past_the_stop_time_is_made_and_told_once() {
    let host = Host::logging();
    assert_eq!(unsafe { fmi2SetupExperiment(host.c, 0, 0.0, 0.0, 1, 0.1) }, fmi2OK);
    assert_eq!((host.enter(), host.exit()), (fmi2OK, fmi2OK));
    assert_eq!((host.step(0.0, 0.1), host.log().len()), (fmi2OK, 0));
    assert_eq!((host.step(0.1, 0.1), host.step(0.2, 0.1)), (fmi2OK, fmi2OK));
    let log = host.log();
    assert_eq!((log.len(), log[0].status, log[0].category.as_str()), (1, fmi2OK, "logSolver"));
    assert!(log[0].text.contains("stopTime = 0.1 s"), "{}", log[0].text);
}

#[test]
fn log_categories_can_be_switched() {
    let host = Host::logging();
    let switch = |on: bool, names: &[&std::ffi::CStr]| {
        let names: Vec<fmi2String> = names.iter().map(|name| name.as_ptr()).collect();
        unsafe { fmi2SetDebugLogging(host.c, on.into(), names.len(), names.as_ptr()) }
    };
    let events = |from: f64| {
        assert_eq!(host.step(from, 1.5), fmi2OK);
        host.log().len()
    };
    host.start();
    assert!(events(0.0) > 0);
    assert_eq!((switch(false, &[]), events(1.5)), (fmi2OK, 0));
    assert_eq!(switch(true, &[c"logSolver", c"logStatusError"]), fmi2OK);
    assert_eq!(events(3.0), 0);
    let refused = "category = logNothing is refused; allowed: logEvents, logSolver";
    host.refused(switch(true, &[c"logEvents", c"logNothing"]), refused);
    assert_eq!(events(4.5), 0);
    assert_eq!(switch(true, &[c"logEvents"]), fmi2OK);
    assert!(events(6.0) > 0);
    assert_eq!(switch(false, &[]), fmi2OK);
    // Errors are told whatever is switched on.
    host.refused(host.step(7.5, -1.0), "communicationStepSize = -1 s");
}

#[test]
fn log_warns_of_parameters_without_effect() {
    let host = Host::logging();
    for (settings, expected) in [
        (
            "contact.huntCrossley=0.5 ball.youngModulus=1e9 ball.radius=0.02 solver.fixedStep=1e-5",
            "ball.youngModulus = 1e9 Pa, contact.huntCrossley = 0.5 s/m, solver.fixedStep = 1e-5 s",
        ),
        ("", ""),
        ("solver.method=rk4 solver.tolerance=1e-6 solver.fixedStep=1e-5", "solver.tolerance = 1e-6"),
        (
            "contact.model=rigid contact.dampingLaw=kelvinVoigtNoPull contact.stiffness=2 contact.damping=2 \
             contact.stiffnessRatio[2]=2 contact.stiffnessRatio[3]=3 contact.overlapRef=2 exchange.contacts=resolved",
            "contact.stiffness = 2 N/m, contact.stiffnessRatio[2] = 2 (and 1 more), contact.overlapRef = 2 m, \
             contact.dampingLaw = kelvinVoigtNoPull, contact.damping = 2 N.s/m, exchange.contacts = resolved",
        ),
        ("contact.restitution=0.5", "contact.restitution = 0.5"),
    ] {
        host.give(settings);
        host.start();
        let told = host.log().into_iter().map(|line| line.text.split_once(" has no effect").unwrap().0.to_owned());
        assert_eq!(told.collect::<Vec<_>>().join(", "), expected);
        assert_eq!(host.reset(), fmi2OK);
    }
    // Tuned, each once in a run.
    host.start();
    for (step, expected) in [(0.0, 1), (0.1, 0)] {
        host.give(&format!("contact.restitution={step} contact.damping={step}"));
        assert_eq!(host.step(step, 0.1), fmi2OK);
        let told: Vec<Line> = host.log().into_iter().filter(|line| line.category == "logStatusWarning").collect();
        assert_eq!(told.len(), expected, "{told:?}");
    }
    let exchange = Instantiate { kind: fmi2ModelExchange, logging: true, ..Default::default() }.host().unwrap();
    exchange.give("exchange.contacts=resolved solver.method=rk4 solver.tolerance=1e-9 solver.fixedStep=1e-5");
    exchange.start();
    let told: Vec<String> = exchange.log().into_iter().map(|line| line.text).collect();
    let expected = [
        "solver.method = rk4 has no effect: it needs co-simulation",
        "solver.fixedStep = 1e-5 s has no effect: it needs co-simulation",
    ];
    assert_eq!(told, expected);
}

/// Every parameter that needs something, changed under all laws and methods: it is told once that this has no effect
/// where the run keeps its bits, and not where it changes.
#[test]
fn log_warns_exactly_of_parameters_without_effect() {
    const STRUCK: &str = "gravity=0 contact.exponent=1.5 contact.deadBand=0 contact.damping=50 \
        contact.huntCrossley=0.3 contact.relaxationTime=1e-6 contact.restitution=0.8 x_start=0 \
        v_start=1,0,0,0,0 contact.gap=0,1,1,1";
    let host = Host::logging();
    let run = |settings: &str, changed: &str| {
        assert_eq!(host.reset(), fmi2OK);
        [STRUCK, settings, changed].into_iter().for_each(|given| host.give(given));
        host.start();
        let told = host.log();
        // Into the first impact.
        assert_eq!(host.step(0.0, 1e-5), fmi2OK, "{settings} {changed}: {:?}", host.log());
        let results = ["x", "v", "F", "impulse"].map(|name| host.each(name)).concat();
        (told, results.into_iter().map(f64::to_bits).collect::<Vec<_>>())
    };
    let items = |model, law| {
        ["eventDriven", "rk4"]
            .map(|method| format!("contact.model={model} contact.dampingLaw={law} solver.method={method}"))
    };
    let models = ["powerLaw", "hertz", "rigid"].into_iter();
    let laws = ["kelvinVoigt", "kelvinVoigtNoPull", "huntCrossley", "viscoelastic", "constantRestitution"];
    let choices: Vec<String> =
        models.flat_map(|model| laws.into_iter().flat_map(move |law| items(model, law))).collect();
    let mut seen = [0, 0];
    for settings in choices.iter().filter(|choice| !choice.contains("rigid") || !choice.contains("rk4")) {
        let (_, before) = run(settings, "");
        // Rigid contacts are refused by the other methods.
        let is_allowed = |row: &&Row| !(settings.contains("rigid") && row.name == "solver.method");
        for row in TABLE.iter().filter(|row| !row.needs.is_empty()).filter(is_allowed) {
            let (name, now) = (row.name_of(1), host.get(&row.name_of(1)));
            let other = match row.access {
                Access::Enumeration(of) => {
                    of.items.iter().rev().map(|item| item.value.into()).find(|item| *item != now)
                }
                _ => [1.5 * now, 0.5 * now].into_iter().find(|value| row.range.contains(*value)),
            };
            let changed = format!("{name}={}", other.unwrap());
            let (told, after) = run(settings, &changed);
            let told: Vec<_> = told.iter().filter(|line| line.text.starts_with(&format!("{name} = "))).collect();
            // What the tolerance changes may be less than a digit.
            let same = after == before && (name != "solver.tolerance" || !told.is_empty());
            assert_eq!(told.len(), usize::from(same), "{settings} {changed}: {told:?}");
            seen[told.len()] += 1;
        }
    }
    assert!(seen[0] > 50 && seen[1] > 50, "{seen:?}");
}

#[test]
fn log_lists_rigid_impacts_as_pulses_without_duration() {
    let host = Host::logging();
    host.give("contact.model=rigid contact.deadBand=0");
    host.start();
    let onset = host.get("t_next");
    assert_eq!((host.step(0.0, onset), host.get("t_next") > onset), (fmi2OK, true));
    let contacts: Vec<String> = host
        .log()
        .into_iter()
        .map(|line| {
            let fields: Vec<&str> = line.text.split([' ', '=']).collect();
            let number = |k: usize| fields[k].parse::<f64>().unwrap();
            assert_eq!((number(3), number(5), number(7)), (onset, onset, 0.0), "{}", line.text);
            assert!((number(9) - 0.1 * 5f64.sqrt()).abs() < 1e-15, "{}", line.text);
            fields[1].to_owned()
        })
        .collect();
    assert_eq!(contacts, ["2", "1", "3", "2", "4", "3"]);
    assert_eq!((host.get("pulses[2]"), host.get("F_peak[2]"), host.get("inContact[2]")), (2.0, 0.0, 0.0));
    assert!((host.get("F_mean[2]") * onset - host.get("impulse[2]")).abs() < 1e-15);
    // The restitution may change between the clicks.
    let (state, energy) = (host.to_bytes(), host.get("E_total"));
    assert_eq!((host.set("contact.restitution", 0.8), host.step(onset, 2.0)), (fmi2OK, fmi2OK));
    let lost = host.get("E_dissipated");
    assert!(lost > 0.05 * energy && (host.get("E_total") + lost - energy).abs() < 1e-15);
    assert_eq!((host.set_bytes(&state), host.step(onset, 2.0)), (fmi2OK, fmi2OK));
    assert!(host.get("E_dissipated") < 1e-30);
}

#[test]
fn status_of_the_last_step_is_answered() {
    let host = Host::started();
    let (mut status, mut boolean, mut string) = (fmi2Error, 7, null());
    unsafe {
        assert_eq!(fmi2GetStatus(host.c, fmi2DoStepStatus, &mut status), fmi2OK);
        assert_eq!(fmi2GetBooleanStatus(host.c, fmi2Terminated, &mut boolean), fmi2OK);
        assert_eq!(fmi2GetStringStatus(host.c, fmi2PendingStatus, &mut string), fmi2OK);
        assert_eq!((status, boolean, std::ffi::CStr::from_ptr(string)), (fmi2OK, 0, c""));
        let answer = fmi2GetBooleanStatus(host.c, fmi2DoStepStatus, &mut boolean);
        host.refused(answer, "fmi2StatusKind = 0 is refused; allowed: fmi2Terminated (3)");
        host.refused(fmi2GetStatus(host.c, 99, &mut status), "fmi2StatusKind = 99");
    }
}

/// With strong drag the pull of the pendulum and the drag cancel, but for what the momentum loses; and late in a run
/// the sums over a step are small parts of those since the start.
#[test]
fn means_of_the_support_force_keep_their_digits() {
    for (drag, from, step) in [(1e6, 1.0, 0.25), (1e6, 1e4, 1e-3), (1e3, 5.0, 1e-6), (20.0, 3.0, 1e-3)] {
        let host = Host::with_balls(1);
        host.give(&format!("pendulum.drag={drag}"));
        host.start();
        assert_eq!((host.step(0.0, from), host.step(from, step)), (fmi2OK, fmi2OK));
        // v is proportional to exp(slow t) - exp(fast t), with fast slow = 5 1/s2.
        let gamma: f64 = 0.5 * drag;
        let fast = -gamma - (gamma * gamma - 5.0).sqrt();
        let slow = 5.0 / fast;
        let change = |rate: f64| (rate * from).exp() * (rate * step).exp_m1();
        let lost = 0.1 * 5.0 / (slow - fast) * (change(fast) - change(slow));
        let (mean, expected) = (host.get("F_support_mean"), lost.abs() / step);
        assert!((mean / expected - 1.0).abs() < 1e-6, "{drag}: {mean:e} {expected:e}");
    }
    let host = Host::with_balls(1);
    host.give("a_support=0.5 pendulum.model=circular pendulum.drag=1");
    host.start();
    assert_eq!(host.step(0.0, 1e5), fmi2OK);
    let before = host.get("F_support");
    assert_eq!(host.step(1e5, 1e-6), fmi2OK);
    assert!((host.get("F_support_mean") - 0.5 * (before + host.get("F_support"))).abs() < 1e-9);
}

/// Ten minutes in one step: Figure 6's set-up, and cubic contacts. Every impact of two balls is solved at once.
#[test]
fn energy_of_ten_minutes_is_kept() {
    for (scene, pulses) in [(scenes::TEN_MINUTES, 2562), (scenes::CUBIC, 7194)] {
        let host = scenes::ready(scene, "");
        let energy = host.get("E_total");
        assert_eq!(host.step(0.0, 600.0), fmi2OK);
        assert_eq!(host.pulses().iter().sum::<i32>(), pulses);
        let work = ["steps", "evaluations", "events"].map(|of| host.get(&format!("solver.{of}")));
        assert_eq!(work, [pulses, pulses, 2 * pulses].map(f64::from));
        assert!(host.get("E_residual").abs() <= 1e-12 * energy, "{:e} of {energy}", host.get("E_residual"));
    }
}

/// A look for the next onset takes a fixed amount of work also where contacts stay closed for ever, and each goes on
/// from the last.
#[test]
fn forecast_of_a_pressed_chain_is_made_step_by_step() {
    for (gravity, model) in [0.0, 9.81].into_iter().flat_map(|gravity| [(gravity, "powerLaw"), (gravity, "hertz")]) {
        let cradle = format!("gravity={gravity} contact.model={model} contact.damping=1e5 x_start=0");
        let host = Host::started_with(&format!("{cradle} F_ext[1]=10 F_ext[5]=-10"));
        assert_eq!(host.step(0.0, 1.0), fmi2OK);
        let (mut time, mut before) = (1.0, 1.0);
        for _ in 0..1000 {
            let (next, is_onset) = (host.get("t_next"), host.get("t_next_isOnset") == 1.0);
            assert!(next == 1e30 && is_onset || next > before && !is_onset, "{next} after {before}");
            assert!((next, is_onset) == (host.get("t_next"), host.get("t_next_isOnset") == 1.0));
            before = next.min(1e29);
            assert_eq!(host.step(time, 0.001), fmi2OK, "{:?}", host.log());
            time += 0.001;
        }
        // With gravity the horizon is a thousand periods, without there is none.
        assert_eq!(host.get("t_next") == 1e30, gravity > 0.0);
    }
}
