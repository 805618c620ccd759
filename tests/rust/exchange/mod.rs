//! Model exchange, through a host with fixed steps.

mod arcs;
mod derivatives;
mod events;
mod masters;
mod touching;

use cradle_host::exchange::{Master, rk4};
use cradle_host::{Host, fmi2OK};
use newtons_cradle::fmi2::fmi2SetDebugLogging;

/// A run of so many balls with these settings.
fn exchanging(balls: usize, settings: &str) -> Master {
    let host = Host::exchanging(balls);
    host.give(settings);
    log_pulses(&host);
    Master::start(host)
}

/// Co-simulation with these settings to the time `until` (s).
fn stepped(settings: &str, until: f64) -> Host {
    let host = Host::started_with(settings);
    log_pulses(&host);
    assert_eq!(host.step(0.0, until), fmi2OK);
    host
}

fn log_pulses(host: &Host) {
    let categories = [c"logEvents".as_ptr()];
    assert_eq!(unsafe { fmi2SetDebugLogging(host.c, 1, categories.len(), categories.as_ptr()) }, fmi2OK);
}

/// Checks that these values are close, and that pulses are as many.
fn assert_close(own: &Host, other: &Host, families: &[&str], tolerance: f64) {
    assert_eq!(own.pulses(), other.pulses());
    for family in families {
        for (i, (own, other)) in own.each(family).into_iter().zip(other.each(family)).enumerate() {
            assert!((own - other).abs() <= tolerance, "{family}[{}]: {own:e} {other:e}", i + 1);
        }
    }
}

/// All values, states, indicators and derivatives, bit by bit.
fn bits(run: &Master) -> Vec<u64> {
    let continuous = [run.states(), run.rates(), run.indicators(), run.nominals()].concat();
    run.everything().into_iter().chain(continuous.into_iter().map(f64::to_bits)).collect()
}

#[test]
fn exchange_restored_run_keeps_its_bits() {
    for (settings, until) in [("", 1.0), ("exchange.contacts=resolved", 0.7025), ("contact.model=rigid", 1.0)] {
        let mut run = exchanging(5, settings);
        run.steps(until, 1e-3, rk4);
        let (time, next, bytes, state) = (run.time, run.next, run.to_bytes(), run.save());
        let go_on = |run: &mut Master| {
            (run.time, run.next, run.indicators) = (time, next, run.host.indicators());
            run.steps(time + 0.5e-4, 1e-6, rk4);
            (bits(run), run.to_bytes())
        };
        let first = go_on(&mut run);
        assert_eq!(run.restore(state), fmi2OK);
        assert!(go_on(&mut run) == first);
        run.free(state);
        let other = Host::exchanging(5);
        assert_eq!(other.set_bytes(&bytes), fmi2OK);
        let mut other = Master { host: other, ..run };
        assert!(other.to_bytes() == bytes && go_on(&mut other) == first);
    }
}
