//! Saving and restoring: a run continues bit-for-bit identically, and invalid bytes are refused.

use std::ptr::null_mut;

use cradle_host::{Host, Line, fmi2Error, fmi2OK, guid};
use newtons_cradle::fmi2::*;

fn instantiated(settings: &str) -> Host {
    let host = Host::logging();
    host.give(settings);
    host
}

/// Cradles whose runs differ in kind: separate and overlapping impacts, all laws, drag, contacts that stay closed, free
/// balls.
const SETUPS: [(&str, &str); 14] = [
    ("separate impacts", ""),
    ("overlapping impacts", "contact.deadBand=0"),
    ("cubic", "contact.exponent=3 contact.deadBand=1e-8"),
    (
        "Hertz with Hunt-Crossley damping and drag",
        "contact.model=hertz contact.dampingLaw=huntCrossley contact.huntCrossley=0.4 pendulum.drag=0.2 \
         contact.deadBand=0",
    ),
    (
        "viscoelastic Hertz",
        "contact.model=hertz contact.dampingLaw=viscoelastic contact.relaxationTime=1e-5 contact.deadBand=0",
    ),
    ("clipped dashpots", "contact.dampingLaw=kelvinVoigtNoPull contact.damping=6e4 contact.deadBand=0"),
    ("pressed together", "contact.damping=2e4 contact.gap[1]=-1e-5 F_ext[5]=-0.5"),
    ("unequal balls", "ball.massRatio[2]=1.6 ball.massRatio[4]=2.2 pendulum.lengthRatio[3]=1.3"),
    ("free balls", "gravity=0 v_start[1]=1 x_start[1]=-0.12 v_start[5]=-0.5"),
    ("bdf", "solver.method=bdf solver.tolerance=1e-6 contact.deadBand=0 contact.damping=1e4"),
    ("adams", "solver.method=adams solver.tolerance=1e-8"),
    ("rk4", "solver.method=rk4 solver.fixedStep=2e-4 contact.stiffness=1e5 pendulum.drag=0.3"),
    (
        "rigid, lasting contacts",
        "contact.model=rigid contact.restitution=0.5 contact.deadBand=0 pendulum.lengthRatio[3]=1.1 F_ext[5]=-3",
    ),
    (
        "rigid, on arcs",
        "contact.model=rigid pendulum.model=circular contact.restitution=0.5 contact.deadBand=0 F_ext[5]=-3",
    ),
];

/// Communication points: coarse ones, the next onset itself, and fine ones through the impacts that follow it.
fn points(settings: &str) -> Vec<f64> {
    let scout = instantiated(settings);
    scout.start();
    let mut points = vec![0.0];
    let mut go = |h: f64| {
        let t = points[points.len() - 1];
        assert_eq!(scout.step(t, h), fmi2OK, "{:?}", scout.log());
        points.push(t + h);
        // How far the next onset is.
        scout.get("t_next") - (t + h)
    };
    let mut ahead = 0.0;
    for _ in 0..3 {
        ahead = go(0.05);
    }
    for _ in 0..3 {
        if ahead < 10.0 {
            go(ahead);
        }
        for h in [3e-9, 2e-7, 2e-7, 2e-7, 3e-7, 1e-6, 3e-5] {
            ahead = go(h);
        }
    }
    points
}

/// Changes by the host at point `i`.
fn disturb(host: &Host, i: usize) {
    if i % 4 == 1 {
        assert_eq!(host.set_derivative("F_ext[2]", 1 + (i % 3) as i32, 0.01), fmi2OK);
    }
    if i == 12 {
        assert_eq!(host.set("pendulum.drag", 0.05), fmi2OK);
    }
}

/// Steps through the points from number `from` on; what is read after each step, and what was logged.
fn run(host: &Host, points: &[f64], from: usize) -> Vec<(Vec<u64>, Vec<Line>)> {
    let step = |i: usize| {
        if i > from {
            disturb(host, i);
        }
        assert_eq!(host.step(points[i], points[i + 1] - points[i]), fmi2OK);
        (host.everything(), host.log())
    };
    (from..points.len() - 1).map(step).collect()
}

#[test]
fn saved_states_restore_the_run_to_the_bit() {
    for (name, settings) in SETUPS {
        let points = points(settings);
        let whole = instantiated(settings);
        whole.start();
        let mut saved = Vec::new();
        let mut expected = Vec::new();
        for i in 0..points.len() - 1 {
            disturb(&whole, i);
            saved.push((whole.to_bytes(), whole.everything()));
            assert_eq!(whole.step(points[i], points[i + 1] - points[i]), fmi2OK);
            expected.push((whole.everything(), whole.log()));
        }
        // New at the first point; at the others it has come to the end before, and knows what lies behind them.
        let restored = Host::logging();
        for (i, (bytes, values)) in saved.iter().enumerate() {
            assert_eq!(restored.set_bytes(bytes), fmi2OK, "{name}, point {i}: {:?}", restored.log());
            assert_eq!(&restored.to_bytes(), bytes, "{name}, point {i}");
            assert_eq!(&restored.everything(), values, "{name}, point {i}");
            assert!(run(&restored, &points, i) == expected[i..], "{name}, point {i}");
        }
    }
}

/// Balls blown apart, which come together after 1e14 s: a double resolves a hundredth of a second there.
#[test]
fn saved_states_hold_a_far_forecast() {
    let (host, mut time) = (Host::with_balls(2), 0.0);
    host.give("gravity=0 x_start=0 contact.gap=-1e12");
    host.start();
    for (step, is_pushed) in [(1e-9, true), (2e-9, false)].repeat(5) {
        if is_pushed {
            assert_eq!(host.set_derivative("F_ext[1]", 1, 1e12), fmi2OK);
        }
        assert_eq!(host.step(time, step), fmi2OK);
        time += step;
        assert!(host.get("t_next") > time);
        let bytes = host.to_bytes();
        assert_eq!(host.set_bytes(&bytes), fmi2OK, "{time}: {:?}", host.log());
    }
}

#[test]
fn parameter_set_and_set_back_changes_nothing() {
    for (name, settings) in SETUPS {
        let [left_alone, set_back] = [false, true].map(|is_set| {
            let host = instantiated(settings);
            host.start();
            assert_eq!(host.step(0.0, 0.35), fmi2OK);
            let drag = host.get("pendulum.drag");
            for value in [drag + 0.4, drag].into_iter().filter(|_| is_set) {
                assert_eq!(host.set("pendulum.drag", value), fmi2OK);
            }
            assert_eq!(host.step(0.35, 0.35), fmi2OK);
            (host.everything(), host.to_bytes())
        });
        assert!(set_back == left_alone, "{name}");
    }
}

#[test]
fn saved_states_hold_phase_settings_and_pending_messages() {
    let host = Host::default();
    assert_eq!(host.set("ball.mass", 2.0), fmi2OK);
    let instantiated = host.to_bytes();
    assert_eq!(unsafe { fmi2SetupExperiment(host.c, 1, f64::NAN, 3.0, 1, 9.0) }, fmi2OK);
    assert_eq!(host.enter(), fmi2OK);
    let initializing = host.to_bytes();
    assert_eq!(host.get("E_total"), 0.1);
    assert_eq!(host.exit(), fmi2OK);
    assert_eq!(host.step(3.0, 0.5), fmi2OK);
    // Set, but not acting before the next step.
    host.give("F_ext[1]=1 pendulum.drag=0.5");
    assert_eq!((host.set_derivative("a_support", 2, 0.5), host.set("pendulum.drag", 0.7)), (fmi2OK, fmi2OK));
    let pending = host.to_bytes();
    assert_eq!(host.terminate(), fmi2OK);
    let terminated = host.to_bytes();

    let other = Host::default();
    assert_eq!(other.set_bytes(&terminated), fmi2OK);
    assert_eq!(other.everything(), host.everything());
    assert_eq!(other.step(3.5, 0.5), fmi2Error);
    for _ in 0..2 {
        assert_eq!(other.set_bytes(&pending), fmi2OK);
        assert_eq!(other.everything(), host.everything());
        assert_eq!(other.step(3.5, 0.5), fmi2OK);
    }
    assert_eq!(host.set_bytes(&pending), fmi2OK);
    assert_eq!(host.step(3.5, 0.5), fmi2OK);
    assert_eq!(other.everything(), host.everything());
    assert_eq!((host.get("a_support"), host.get("pendulum.drag")), (0.5 * 0.5 * 0.25, 0.7));

    assert_eq!(other.set_bytes(&instantiated), fmi2OK);
    assert_eq!((other.set_up(0.0), other.enter(), other.get("E_total")), (fmi2OK, fmi2OK, 0.1));
    assert_eq!(other.set_bytes(&initializing), fmi2OK);
    assert_eq!((other.get("E_total"), other.exit(), other.step(3.0, 0.5)), (0.1, fmi2OK, fmi2OK));
    other.assert_usable();
}

#[test]
fn saved_states_hold_the_error_state() {
    let host = Host::started_with("gravity=0 F_ext[1]=-1e300");
    let before = host.save();
    assert_eq!((host.step(0.0, 1e9), host.set("F_ext[1]", 0.0), host.step(1e9, 1.0)), (fmi2OK, fmi2OK, fmi2Error));
    host.log();
    let bytes = host.to_bytes();
    let other = Host::default();
    assert_eq!(other.set_bytes(&bytes), fmi2OK, "{:?}", other.log());
    assert_eq!(other.everything(), host.everything());
    assert_eq!((other.step(1e9, 1.0), host.restore(before), host.step(0.0, 0.5)), (fmi2Error, fmi2OK, fmi2OK));
    host.free(before);
}

#[test]
fn saved_states_reuse_memory_and_free_it_once() {
    let host = Host::started();
    let state = host.save();
    let (mut again, x) = (state, host.get("x[1]"));
    assert_eq!(host.step(0.0, 0.5), fmi2OK);
    let later = host.get("x[1]");
    assert_eq!(unsafe { fmi2GetFMUstate(host.c, &mut again) }, fmi2OK);
    assert_eq!(again, state);
    assert_eq!((host.reset(), host.restore(state)), (fmi2OK, fmi2OK));
    assert!(host.get("x[1]") == later && later != x);
    host.free(state);
    host.free(null_mut());
    unsafe {
        assert_eq!(fmi2FreeFMUstate(host.c, null_mut()), fmi2OK);
        host.refused(fmi2GetFMUstate(host.c, null_mut()), "FMUstate = NULL is refused");
        host.refused(host.restore(null_mut()), "FMUstate = NULL is refused; allowed: a state of this FMU");
        let mut size = 0;
        assert_eq!(fmi2SerializedFMUstateSize(host.c, null_mut(), &mut size), fmi2Error);
        // A component is no state.
        assert_eq!(host.restore(host.c), fmi2Error);
        host.log();
        let state = host.save();
        assert_eq!(fmi2SerializedFMUstateSize(host.c, state, null_mut()), fmi2Error);
        let mut byte = 0;
        assert_eq!(fmi2SerializeFMUstate(host.c, state, &mut byte, 1), fmi2Error);
        assert!(host.log()[1].text.contains("size = 1 is refused; allowed: "));
        assert_eq!(fmi2DeSerializeFMUstate(host.c, std::ptr::null(), 0, &mut null_mut()), fmi2Error);
        host.free(state);
    }
}

#[test]
fn saved_states_of_damaged_bytes_are_refused() {
    let host = Host::started();
    let onset = host.get("t_next");
    assert_eq!(host.step(0.0, onset + 1e-7), fmi2OK);
    let (before, state) = (host.everything(), host.to_bytes());
    let refused = |bytes: &[u8], reason: &str| {
        host.refused(host.set_bytes(bytes), &format!("fmi2DeSerializeFMUstate: the state is refused: {reason}"));
    };
    for byte in 0..state.len() {
        let mut flipped = state.clone();
        flipped[byte] ^= 1 << (byte % 8);
        let reason = match byte {
            0..8 => "these are not the bytes of a state",
            8..12 => "its format",
            _ => "the bytes are damaged",
        };
        refused(&flipped, reason);
    }
    for length in 1..state.len() {
        refused(&state[..length], if length < 28 { "these are not the bytes" } else { "the bytes are damaged" });
    }
    refused(&[state.as_slice(), &[0]].concat(), "the bytes are damaged");
    for (format, version) in [(1, "an earlier"), (255, "a later")] {
        let mut other = state.clone();
        other[8] = format;
        refused(&other, &format!("its format, {format}, is that of {version} version; allowed: "));
    }
    refused(b"{\"a\": 1}", "these are not the bytes of a state");
    assert_eq!(host.everything(), before);
    assert_eq!(host.step(onset + 1e-7, 0.1), fmi2OK);
}

#[test]
fn saved_states_of_other_fmus_are_refused() {
    let (five, four) = (Host::started(), Host::with_balls(4));
    let fmu = |balls: usize| format!("the FMU of {balls} ball(s) with the GUID {}", guid(balls));
    let expected = format!("it belongs to {}; allowed: states of {}", fmu(5), fmu(4));
    four.refused(four.set_bytes(&five.to_bytes()), &expected);
    let state = five.save();
    four.refused(four.restore(state), "it belongs to the FMU of 5 ball(s)");
    five.free(state);
    four.assert_usable();
}

#[test]
fn saved_states_of_a_long_chain_have_a_sensible_size() {
    let host = Host::with_balls(500);
    host.start();
    assert_eq!(host.step(0.0, 1.0), fmi2OK);
    let bytes = host.to_bytes();
    assert!(bytes.len() < 500 * 500, "{}", bytes.len());
    let other = Host::with_balls(500);
    assert_eq!(other.set_bytes(&bytes), fmi2OK);
    assert_eq!((host.step(1.0, 1.0), other.step(1.0, 1.0)), (fmi2OK, fmi2OK));
    assert_eq!(host.get("x[500]").to_bits(), other.get("x[500]").to_bits());
    assert_eq!(host.get("E_residual").to_bits(), other.get("E_residual").to_bits());
}

/// The force does more work on the way to the impact than a double holds. What a step leaves can always be read again.
#[test]
fn step_beyond_the_range_of_doubles_is_an_error() {
    let far = "gravity=0 ball.mass=1e250 x_start=-1e20,0,0,0,0 F_ext=1e300,0,0,0,0";
    for (method, step, words) in [
        ("eventDriven", 1e-14, "the state of ball 1 is not finite at t = 1e-14 s"),
        ("adams", 1e-15, "the energy, the work or the impulse on the support is "),
        ("bdf", 1e-15, "the energy, the work or the impulse on the support is "),
    ] {
        let host = Host::started_with(&format!("{far} solver.method={method}"));
        host.refused(host.step(0.0, step), words);
        let bytes = host.to_bytes();
        assert_eq!((host.reset(), host.set_bytes(&bytes)), (fmi2OK, fmi2OK), "{method}");
    }
}
