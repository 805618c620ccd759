//! Calls at corners of what is legal, at which a host could have to wait: getters within slow impacts, the next onset
//! where none is in sight, sums over long flights; and what a step over one onset costs with few balls and with many.

use std::time::{Duration, Instant};

use cradle_host::scenes::{self, Setting, at_rest, choose, started};
use cradle_host::{Host, fmi2OK};
use criterion::{BatchSize, Criterion, criterion_group, criterion_main};

/// The first time that `variable` is read after steps of these lengths (s).
fn read(c: &mut Criterion, name: &str, scene: impl Fn() -> Host, steps: &[f64], variable: &str) {
    let ready = || {
        let host = scene();
        let mut time = 0.0;
        for step in steps {
            assert_eq!(host.step(time, *step), fmi2OK, "{:?}", host.log());
            time += step;
        }
        host
    };
    let read = |host: Host| {
        host.get(variable);
        host
    };
    c.benchmark_group(name).bench_function(variable, |b| b.iter_batched(ready, read, BatchSize::PerIteration));
}

/// Ball 1 meets ball 2 at this speed (m/s); with the order 10 the impact lasts longer than any run.
fn slow_impact(speed: f64) -> Host {
    let apart = [("x_start[3]", 1.0), ("x_start[4]", 2.0), ("x_start[5]", 3.0)];
    let law = [("gravity", 0.0), ("contact.exponent", 10.0), ("contact.deadBand", 0.0), ("v_start[1]", speed)];
    started(at_rest(5, &[&apart[..], &law].concat()))
}

/// Two balls without gravity, the right one pushed away ever harder by an input derivative of this order.
fn pushed_away(drag: f64, order: i32) -> Host {
    let host = at_rest(2, &[("gravity", 0.0), ("pendulum.drag", drag), ("x_start[1]", -0.01)]);
    assert_eq!(host.set_derivative("F_ext[2]", order, 1.0), fmi2OK);
    started(host)
}

/// Thirteen balls pressed together by their gaps, with damping.
fn pressed_together() -> Host {
    let gaps: Vec<(String, f64)> = (1..13).map(|i| (format!("contact.gap[{i}]"), -3.6e-6)).collect();
    let gaps: Vec<Setting> = gaps.iter().map(|(name, gap)| (name.as_str(), *gap)).collect();
    let law = [("contact.damping", 3e5), ("contact.exponent", 7.3)];
    started(at_rest(13, &[&gaps[..], &law].concat()))
}

/// Five unequal balls pressed by 50 N, with Hunt-Crossley damping.
fn pressed_unequal() -> Host {
    let masses = [("ball.massRatio[2]", 2.0), ("ball.massRatio[4]", 0.5)];
    let load = [("F_ext[1]", 50.0), ("F_ext[5]", -50.0), ("contact.huntCrossley", 0.3), ("contact.deadBand", 0.0)];
    let host = at_rest(5, &[&masses[..], &load].concat());
    choose(&host, "contact.dampingLaw", "DampingLaw", "huntCrossley");
    started(host)
}

/// All five balls lifted together, with drag, never in touch.
fn long_flight(drag: f64) -> Host {
    let lifted = ["x_start[1]", "x_start[2]", "x_start[3]", "x_start[4]", "x_start[5]"].map(|name| (name, -0.1));
    started(at_rest(5, &[&lifted[..], &[("pendulum.drag", drag), ("contact.deadBand", 1.0)]].concat()))
}

fn getters(c: &mut Criterion) {
    for speed in [1e-30, 1e-20, 1e-8] {
        let name = format!("impact at {speed:e} m per s, after 1 s");
        for variable in ["x[1]", "t_next"] {
            read(c, &name, || slow_impact(speed), &[1.0], variable);
        }
    }
    for variable in ["E_dissipated", "E_residual", "F_support_mean"] {
        read(c, "flight of 1e6 s, drag 1e-9", || long_flight(1e-9), &[1e6], variable);
        read(c, "flight of 1000 s, drag 1e-3", || long_flight(1e-3), &[1000.0], variable);
    }
}

fn next_onset(c: &mut Criterion) {
    for drag in [1e-3, 0.2, 10.0] {
        for order in [1, 3] {
            let name = format!("pushed away, drag {drag}, order {order}");
            read(c, &name, || pushed_away(drag, order), &[0.75], "t_next");
        }
    }
    read(c, "pressed together, 13 balls", pressed_together, &[0.1, 0.1], "t_next");
    read(c, "pressed by 50 N, unequal", pressed_unequal, &[0.1], "t_next");
    // A host that moves the support and records t_next.
    let gaps = ["contact.gap[1]", "contact.gap[2]", "contact.gap[3]", "contact.gap[4]"].map(|name| (name, -1e-6));
    let law = [("contact.damping", 1e5), ("contact.exponent", 7.3), ("contact.deadBand", 0.0)];
    let host = started(at_rest(5, &[&gaps[..], &law].concat()));
    let mut k = 0;
    c.bench_function("pressed, new a_support every 10 ms/doStep and t_next", |b| {
        b.iter(|| {
            assert_eq!(host.set("a_support", 0.1 * f64::from(k * 7 % 5 - 2)), fmi2OK);
            assert_eq!(host.step(0.01 * f64::from(k), 0.01), fmi2OK, "{:?}", host.log());
            k += 1;
            host.get("t_next")
        });
    });
}

/// Steps from onset to onset, and t_next after each.
fn onsets(c: &mut Criterion) {
    for balls in [5, 100, 1000, 10_000] {
        let mut timed = |name: &str, of_step: bool| {
            let host = scenes::separated(balls);
            let (mut time, mut next) = (0.0, host.get("t_next"));
            c.benchmark_group(name).bench_function(format!("n = {balls}"), |b| {
                b.iter_custom(|times| {
                    let mut taken = Duration::ZERO;
                    for _ in 0..times {
                        let begin = Instant::now();
                        let status = host.step(time, next - time);
                        let stepped = begin.elapsed();
                        assert_eq!(status, fmi2OK);
                        time = next;
                        let begin = Instant::now();
                        next = host.get("t_next");
                        taken += if of_step { stepped } else { begin.elapsed() };
                    }
                    taken
                });
            });
        };
        timed("step over one onset", true);
        timed("t_next after one onset", false);
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_secs(1));
    targets = getters, next_onset, onsets
}
criterion_main!(benches);
