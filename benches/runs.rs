//! Times of whole runs and of single calls, all through the C functions.

#![expect(unsafe_code, reason = "hosts call C functions")]

use std::time::Duration;

use cradle_host::{Host, fmi2OK, scenes};
use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use newtons_cradle::fmi2::{fmi2DoStep, fmi2GetReal};

/// The default method.
const DEFAULT: &str = "eventDriven";

/// One step of a fresh instance, from `from` (s), where it has got before, to `to`.
fn one_step(c: &mut Criterion, group: &str, name: &str, scene: impl Fn() -> Host, (from, to): (f64, f64)) {
    let ready = || {
        let host = scene();
        assert!(from == 0.0 || host.step(0.0, from) == fmi2OK);
        host
    };
    let step = |host: Host| {
        assert_eq!(host.step(from, to - from), fmi2OK, "{:?}", host.log());
        host
    };
    c.benchmark_group(group).bench_function(name, |b| b.iter_batched(ready, step, BatchSize::PerIteration));
}

fn paper(c: &mut Criterion) {
    one_step(c, "paper", "ten minutes", || scenes::ten_minutes(DEFAULT, &[]), (0.0, 600.0));
    one_step(c, "paper", "cubic, 600 s", || scenes::cubic(DEFAULT, &[]), (0.0, 600.0));
    one_step(c, "paper", "figure 3, 10 s", scenes::figure3, (0.0, 10.0));
}

fn waves(c: &mut Criterion) {
    one_step(c, "hertz line struck once", "n = 100", || scenes::hertz_line(100), (0.0, 0.2));
    one_step(c, "hertz line struck once", "n = 1000", || scenes::hertz_line(1000), (0.0, 0.2));
}

fn damping(c: &mut Criterion) {
    one_step(c, "settling cradle", "first 100 s", scenes::settling, (0.0, 100.0));
    one_step(c, "settling cradle", "last 100 s of 600 s", scenes::settling, (500.0, 600.0));
    one_step(c, "damping, 10 s", "none", || scenes::damped(0.0), (0.0, 10.0));
    one_step(c, "damping, 10 s", "1000 times critical", || scenes::damped(1000.0), (0.0, 10.0));
    one_step(c, "pressed chain", "linear, equal, 600 s", scenes::pressed, (0.0, 600.0));
    one_step(c, "pressed chain", "Hertz, unequal, 600 s", scenes::pressed_steel, (0.0, 600.0));
    one_step(c, "pressed chain", "undamped, p = 10, 0.1 s", || scenes::rattling(10.0), (0.0, 0.1));
    one_step(c, "pressed chain", "undamped, p = 1.5, 0.05 s", || scenes::rattling(1.5), (0.0, 0.05));
    one_step(c, "pressed chain", "Hunt-Crossley, unequal, 1 s", scenes::ringing, (0.0, 1.0));
    one_step(c, "pressed chain", "rigid, elastic, 600 s", scenes::elastic_chatter, (0.0, 600.0));
}

/// Time per pulse of a run of `time` (s).
fn per_pulse(c: &mut Criterion, group: &str, name: &str, scene: impl Fn() -> Host, time: f64) {
    let counted = scene();
    assert_eq!(counted.step(0.0, time), fmi2OK);
    let mut group = c.benchmark_group(group);
    group.throughput(Throughput::Elements(scenes::pulses(&counted)));
    group.bench_function(name, |b| {
        b.iter_batched(&scene, |host| (host.step(0.0, time), host), BatchSize::PerIteration);
    });
}

fn pulses(c: &mut Criterion) {
    for (balls, time) in [(5, 200.0), (1000, 2.0)] {
        per_pulse(c, "separated pulses", &format!("n = {balls}"), || scenes::separated(balls), time);
    }
    for (damping, time) in [(0.0, 0.02), (50.0, 0.2), (1e3, 0.2), (3e5, 10.0)] {
        let unequal = |pressed| move || scenes::unequal(damping, pressed);
        per_pulse(c, "unequal masses, pressed", &format!("c = {damping}"), unequal(true), time);
        per_pulse(c, "unequal masses, one lifted", &format!("c = {damping}"), unequal(false), 10.0);
    }
}

/// Single calls, as a host makes them.
fn calls(c: &mut Criterion) {
    let host = scenes::in_flight();
    let mut time = 0.0;
    c.bench_function("call/doStep in flight", |b| {
        b.iter(|| {
            let status = unsafe { fmi2DoStep(host.c, time, 1e-3, 1) };
            time += 1e-3;
            status
        });
    });
    let references: Vec<u32> = (1..=5).map(|i| host.vr(&format!("x[{i}]"))).collect();
    let mut values = [0.0; 5];
    let mut group = c.benchmark_group("call");
    group.throughput(Throughput::Elements(5));
    group.bench_function("getReal of x[1..5]", |b| {
        b.iter(|| unsafe { fmi2GetReal(host.c, references.as_ptr(), 5, values.as_mut_ptr()) });
    });
    group.bench_function("doStep in flight and getReal of x[1..5]", |b| {
        b.iter(|| {
            let status = unsafe { fmi2DoStep(host.c, time, 1e-3, 1) };
            time += 1e-3;
            (status, unsafe { fmi2GetReal(host.c, references.as_ptr(), 5, values.as_mut_ptr()) })
        });
    });
    group.finish();
    one_step(c, "call", "doStep over an impact sequence", scenes::default_cradle, (0.7, 0.71));
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(2));
    targets = paper, waves, damping, pulses, calls
}
criterion_main!(benches);
