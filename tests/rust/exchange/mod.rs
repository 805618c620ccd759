//! Model exchange, through a host with fixed steps.

mod derivatives;
mod events;
mod masters;
mod rigid;
mod states;
mod touching;

use cradle_host::exchange::Master;
use cradle_host::{Host, fmi2OK};

/// A run of so many balls with these settings.
fn exchanging(balls: usize, settings: &str) -> Master {
    let host = Host::exchanging(balls);
    host.give(settings);
    Master::start(host)
}

/// Co-simulation with these settings to the time `until` (s).
fn stepped(settings: &str, until: f64) -> Host {
    let host = Host::started_with(settings);
    assert_eq!(host.step(0.0, until), fmi2OK);
    host
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
