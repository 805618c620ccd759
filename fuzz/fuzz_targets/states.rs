//! Serialized states that nobody wrote: random bytes, and bytes of a state with changes and the digest that belongs to
//! them. They are refused, and then nothing has changed, or accepted, and then it is a state: it can be looked at,
//! written, read and stepped.
#![no_main]

use std::ptr::{null, null_mut};
use std::sync::LazyLock;

use arbitrary::Arbitrary;
use cradle_fuzz::forgery::{Change, forged};
use cradle_host::{Host, fmi2Error, fmi2OK};
use libfuzzer_sys::fuzz_target;
use newtons_cradle::fmi2::*;
use newtons_cradle::variables::{Variable, variables};

/// The states that changes are made to.
static STATES: LazyLock<Vec<Vec<u8>>> = LazyLock::new(states);

#[derive(Debug, Arbitrary)]
enum Bytes {
    Random(Vec<u8>),
    Forged { state: u8, changes: Vec<Change> },
}

thread_local! {
    /// Reset before each input: creating one takes long.
    static HOST: Host = Host::default();
}

fuzz_target!(|bytes: Bytes| HOST.with(|host| read(host, bytes)));

fn read(host: &Host, bytes: Bytes) {
    assert_eq!(host.reset(), fmi2OK);
    host.start();
    assert_eq!(host.step(0.0, 0.3), fmi2OK);
    let (bytes, parameters) = match bytes {
        Bytes::Random(bytes) => (bytes, None),
        Bytes::Forged { state, changes } => {
            let state = &STATES[usize::from(state) % STATES.len()];
            assert_eq!(host.set_bytes(state), fmi2OK, "{:?}", host.log());
            (forged(state, &changes), settings(host))
        }
    };
    let before = host.to_bytes();
    let mut state = null_mut();
    let status = unsafe { fmi2DeSerializeFMUstate(host.c, bytes.as_ptr().cast(), bytes.len(), &mut state) };
    assert!(host.to_bytes() == before, "reading bytes changed the instance");
    if status == fmi2OK {
        assert_eq!(host.restore(state), fmi2OK);
        host.free(state);
        look(host, parameters);
    } else {
        assert!(state.is_null());
        host.refused(status, "fmi2DeSerializeFMUstate: the state is refused: ");
    }
}

/// Looks at an instance in a state that was accepted. It steps only if the settings are those the state had before, and
/// the balls move as balls do: with a mass of 1e-300 kg, or balls 1e100 m within each other, it would take long.
fn look(host: &Host, before: Option<Vec<u64>>) {
    let bytes = host.to_bytes();
    assert_eq!(host.set_bytes(&bytes), fmi2OK, "its own bytes: {:?}", host.log());
    assert!(host.to_bytes() == bytes, "its own bytes read and written are others");
    let after = settings(host);
    if after.is_none() || after != before {
        return;
    }
    // What a forged state amounts to may be beyond the range of doubles.
    let everyday = |variable: Variable| {
        let moves = ["x", "v"].contains(&variable.row.name);
        host.read(variable).is_some_and(|value| !moves || value.abs() < 10.0)
    };
    let all_everyday = variables(host.balls).map(everyday).fold(true, |all, own| all && own);
    host.log();
    if !all_everyday {
        return;
    }
    if let Some(time) = host.time() {
        assert!(time.is_finite());
        // Short: a forged contact may open and close every 1e-13 s.
        let status = host.step(time, 1e-8);
        assert!(status == fmi2OK || status == fmi2Error, "{status:?}: {:?}", host.log());
    }
    host.log();
}

/// Every parameter and input, bit by bit, all of them allowed ones; nothing before initialization.
fn settings(host: &Host) -> Option<Vec<u64>> {
    if unsafe { fmi2GetReal(host.c, null(), 0, null_mut()) } == fmi2Error {
        host.log();
        return None;
    }
    let value = |variable: Variable| {
        let value = host.read(variable).unwrap_or_else(|| panic!("{variable}: {:?}", host.log()));
        assert!(variable.check(value).is_ok(), "{variable} = {value} was accepted");
        value.to_bits()
    };
    Some(variables(host.balls).filter(|variable| variable.row.settable()).map(value).collect())
}

/// States of every kind: of each phase, in flight, within an impact of known outcome, within a cluster, pressed
/// together.
fn states() -> Vec<Vec<u8>> {
    let host = Host::default();
    let mut states = vec![host.to_bytes()];
    assert_eq!((host.set_up(0.0), host.enter()), (fmi2OK, fmi2OK));
    assert_eq!(host.set_derivative("F_ext[2]", 2, 0.1), fmi2OK);
    states.push(host.to_bytes());
    for settings in [
        "",
        "contact.deadBand=0 pendulum.drag=0.1",
        "contact.exponent=3 contact.deadBand=1e-8 ball.massRatio[3]=2",
        "contact.damping=2e4 contact.gap[1]=-1e-5 F_ext[5]=-0.5 contact.deadBand=0",
    ] {
        let host = Host::started_with(settings);
        states.push(host.to_bytes());
        assert_eq!(host.step(0.0, 0.5), fmi2OK);
        states.push(host.to_bytes());
        let ahead = host.get("t_next") - 0.5;
        assert_eq!((host.set_derivative("F_ext[1]", 1, 1e-3), host.set("pendulum.drag", 0.2)), (fmi2OK, fmi2OK));
        states.push(host.to_bytes());
        if ahead < 10.0 {
            assert_eq!(host.step(0.5, ahead + 1e-7), fmi2OK);
            states.push(host.to_bytes());
        }
        assert_eq!(host.terminate(), fmi2OK);
        states.push(host.to_bytes());
    }
    let failed = Host::default();
    failed.fail();
    states.push(failed.to_bytes());
    states
}
