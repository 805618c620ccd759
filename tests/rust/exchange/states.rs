//! Saved states of model exchange, in memory and as bytes.

use cradle_host::exchange::{Master, rk4};
use cradle_host::{Host, fmi2OK};

use super::exchanging;

/// All values, states, indicators and derivatives, bit by bit.
fn bits(host: &Host) -> Vec<u64> {
    let continuous = [host.states(), host.rates(), host.indicators(), host.nominals()].concat();
    host.everything().into_iter().chain(continuous.into_iter().map(f64::to_bits)).collect()
}

#[test]
fn a_restored_run_goes_on_with_the_same_bits() {
    for (settings, until) in [("", 1.0), ("exchange.contacts=resolved", 0.7025), ("contact.model=rigid", 1.0)] {
        let host = exchanging(settings);
        let mut master = Master::start(&host);
        master.steps(until, 1e-3, rk4);
        let (time, next, bytes, state) = (master.time, master.next, host.to_bytes(), host.save());
        let go_on = |host: &Host| {
            let mut master = Master { host, time, next, events: 0, indicators: host.indicators() };
            master.steps(time + 0.5e-4, 1e-6, rk4);
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
