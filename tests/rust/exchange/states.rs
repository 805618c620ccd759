//! Saved states of model exchange: in every mode, in memory and as bytes.

use cradle_host::exchange::{Master, Method};
use cradle_host::{Host, fmi2Error, fmi2OK};

/// All values, states, indicators and derivatives, bit by bit.
fn bits(host: &Host) -> Vec<u64> {
    let continuous = [host.states(), host.rates(), host.indicators(), host.nominals()].concat();
    host.everything().into_iter().chain(continuous.into_iter().map(f64::to_bits)).collect()
}

#[test]
fn a_restored_run_goes_on_with_the_same_bits() {
    for (model, contacts, until) in [(1, 2, 1.0), (1, 1, 0.7025), (3, 2, 1.0)] {
        let host = Host::exchanging(5);
        assert_eq!(host.set_integer("contact.model", model), fmi2OK);
        assert_eq!(host.set_integer("exchange.contacts", contacts), fmi2OK);
        let mut master = Master::start(&host, 0.0);
        master.steps(until, 1e-3, Method::Rk4);
        let (time, next, bytes, state) = (master.time, master.next, host.to_bytes(), host.save());
        let go_on = |host: &Host| {
            let mut master = Master { time, next, ..Master::resumed(host) };
            master.steps(time + 0.5e-4, 1e-6, Method::Rk4);
            (bits(host), host.to_bytes())
        };
        let first = go_on(&host);
        assert_eq!(host.restore(state), fmi2OK);
        assert!(go_on(&host) == first);
        let other = Host::exchanging(5);
        assert_eq!(other.set_bytes(&bytes), fmi2OK);
        assert!(other.to_bytes() == bytes && go_on(&other) == first);
        host.free(state);
    }
}

#[test]
fn every_mode_comes_back() {
    let host = Host::exchanging(5);
    let mut states = vec![host.to_bytes()];
    assert_eq!((host.set_up(0.0), host.enter()), (fmi2OK, fmi2OK));
    states.push(host.to_bytes());
    assert_eq!(host.exit(), fmi2OK);
    states.push(host.to_bytes());
    host.update();
    states.push(host.to_bytes());
    let mut master = Master::resumed(&host);
    master.steps(0.3, 1e-3, Method::Rk4);
    states.push(host.to_bytes());
    assert_eq!(host.terminate(), fmi2OK);
    states.push(host.to_bytes());
    for state in &states {
        assert_eq!(host.set_bytes(state), fmi2OK);
        assert!(host.to_bytes() == *state);
    }
    let steps = Host::started();
    assert!(states.iter().all(|state| steps.set_bytes(state) == fmi2Error));
}

/// Bytes that somebody forged, digest and all: whatever they hold, they are refused or run, and nothing panics.
#[test]
#[ignore = "tries every bit of a state: only in `cradle.py test --all`"]
fn forged_states_do_no_harm() {
    let host = Host::exchanging(3);
    let mut master = Master::start(&host, 0.0);
    master.steps(0.8, 1e-3, Method::Rk4);
    let bytes = host.to_bytes();
    let content = bytes.len() - 16;
    let (mut refused, mut accepted) = (0, 0);
    for place in (12..content).step_by(5) {
        for change in [0x01_u8, 0x40, 0x80, 0xff] {
            let mut forged = bytes[..content].to_vec();
            forged[place] ^= change;
            let digest = uuid::Uuid::new_v5(&uuid::Uuid::NAMESPACE_OID, &forged);
            forged.extend(digest.into_bytes());
            let other = Host::exchanging(3);
            if other.set_bytes(&forged) != fmi2OK {
                refused += 1;
                continue;
            }
            accepted += 1;
            let mut info = newtons_cradle::fmi2::fmi2EventInfo::default();
            // Either may be refused, if the forged phase does not have it.
            unsafe {
                newtons_cradle::fmi2::fmi2EnterEventMode(other.c);
                let status = newtons_cradle::fmi2::fmi2NewDiscreteStates(other.c, &mut info);
                assert!(status == fmi2OK || status == fmi2Error, "{place} {change}");
            }
        }
    }
    assert!(refused > 20 && accepted > 20, "{refused} {accepted}");
}
