//! Model exchange, through a host with fixed steps.

mod derivatives;
mod events;
mod masters;
mod rigid;
mod states;
mod touching;

use cradle_host::Host;

/// Onsets of each contact so far.
fn pulses(host: &Host) -> Vec<i32> {
    (1..host.balls).map(|i| host.get_integer(&format!("pulses[{i}]"))).collect()
}

/// Elements of an array.
fn each(host: &Host, family: &str) -> Vec<f64> {
    let count = if ["x", "v", "a", "angle"].contains(&family) { host.balls } else { host.balls - 1 };
    (1..=count).map(|i| host.get(&format!("{family}[{i}]"))).collect()
}

fn assert_close(own: &Host, other: &Host, families: &[&str], tolerance: f64) {
    for family in families {
        for (i, (own, other)) in each(own, family).into_iter().zip(each(other, family)).enumerate() {
            assert!((own - other).abs() <= tolerance, "{family}[{}]: {own:e} {other:e}", i + 1);
        }
    }
}
