//! Times of whole runs, of their gradients and of single calls.

#![expect(unsafe_code, reason = "hosts call C functions")]

use std::time::{Duration, Instant};

use cradle_host::scenes::{self, Scene, ready};
use cradle_host::{Host, assignments, fmi2OK, fmi3};
use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use newtons_cradle::engine::{Differential, History, Simulation, Unrecorded};
use newtons_cradle::fmi2::{fmi2DoStep, fmi2GetReal};
use newtons_cradle::fmi3::fmi3Status::fmi3OK;
use newtons_cradle::fmi3::{fmi3EnterEventMode, fmi3EnterStepMode, fmi3SetDebugLogging};
use newtons_cradle::model::Inputs;
use newtons_cradle::variables::{Settings, Type, Variable, variables};

/// One step of a fresh instance from one time (s), which it has reached before, to another.
fn runs(c: &mut Criterion) {
    for (group, name, scene, from, to) in [
        ("paper", "ten minutes", scenes::TEN_MINUTES, 0.0, 600.0),
        ("paper", "cubic, 600 s", scenes::CUBIC, 0.0, 600.0),
        ("paper", "figure 3, 10 s", scenes::FIGURE_3, 0.0, 10.0),
        ("hertz line struck once", "n = 1000", scenes::HERTZ_LINE, 0.0, 0.2),
        ("settling cradle", "first 100 s", scenes::SETTLING, 0.0, 100.0),
        ("settling cradle", "last 100 s of 600 s", scenes::SETTLING, 500.0, 600.0),
        ("damping, 10 s", "none", scenes::DEFAULT, 0.0, 10.0),
        ("damping, 10 s", "1000 times critical", scenes::DAMPED, 0.0, 10.0),
        ("pressed chain", "linear, equal, 600 s", scenes::PRESSED, 0.0, 600.0),
        ("pressed chain", "Hertz, unequal, 600 s", scenes::PRESSED_STEEL, 0.0, 600.0),
        ("pressed chain", "undamped, p = 1.5, 0.05 s", scenes::RATTLING, 0.0, 0.05),
        ("pressed chain", "Hunt-Crossley, unequal, 1 s", scenes::RINGING, 0.0, 1.0),
        ("pressed chain", "rigid, elastic, 600 s", scenes::ELASTIC_CHATTER, 0.0, 600.0),
        ("lossy steel, 60 s", "Hunt-Crossley", scenes::STEEL_HUNT_CROSSLEY, 0.0, 60.0),
        ("lossy steel, 60 s", "constant restitution", scenes::STEEL_CONSTANT, 0.0, 60.0),
        ("call", "doStep over an impact sequence", scenes::DEFAULT, 0.7, 0.71),
    ] {
        let before = || {
            let host = ready(scene, "");
            assert!(from == 0.0 || host.step(0.0, from) == fmi2OK);
            host
        };
        let step = |host: Host| {
            assert_eq!(host.step(from, to - from), fmi2OK, "{:?}", host.log());
            host
        };
        c.benchmark_group(group).bench_function(name, |b| b.iter_batched(before, step, BatchSize::PerIteration));
    }
}

/// A step in flight and what a host reads after it.
fn calls(c: &mut Criterion) {
    let host = ready(scenes::IN_FLIGHT, "");
    let references: Vec<u32> = (1..=5).map(|i| host.vr(&format!("x[{i}]"))).collect();
    let (mut time, mut values) = (0.0, [0.0; 5]);
    c.bench_function("call/doStep in flight and getReal of x[1..5]", |b| {
        b.iter(|| {
            let status = unsafe { fmi2DoStep(host.c, time, 1e-3, 1) };
            time += 1e-3;
            (status, unsafe { fmi2GetReal(host.c, references.as_ptr(), 5, values.as_mut_ptr()) })
        });
    });
}

/// Steps from onset to onset of one ball and others at rest, n - 1 of them in each stroke, and t_next after each.
fn onsets(c: &mut Criterion) {
    for (balls, name, of_step) in [5, 100, 1000, 10_000].into_iter().flat_map(|balls| {
        [("step over one onset", true), ("t_next after one onset", false)].map(|(n, s)| (balls, n, s))
    }) {
        let host = ready((balls, "x_start[1]=-0.1"), "");
        let (mut time, mut next) = (0.0, host.get("t_next"));
        c.benchmark_group(name).bench_function(format!("n = {balls}"), |b| {
            b.iter_custom(|times| {
                let mut taken = Duration::ZERO;
                for _ in 0..times {
                    let begin = Instant::now();
                    assert_eq!(host.step(time, next - time), fmi2OK);
                    let stepped = begin.elapsed();
                    time = next;
                    next = host.get("t_next");
                    taken += if of_step { stepped } else { begin.elapsed() - stepped };
                }
                taken
            });
        });
    }
}

/// The default experiment in 1,000 steps, with all positions read after each, in FMI 2.0.
fn by_fmi2() {
    let (host, mut x) = (ready(scenes::DEFAULT, ""), [0.0; 5]);
    let references: Vec<u32> = (1..=5).map(|i| host.vr(&format!("x[{i}]"))).collect();
    for step in 0..1000 {
        assert_eq!(host.step(f64::from(step) * 0.01, 0.01), fmi2OK);
        assert_eq!(unsafe { fmi2GetReal(host.c, references.as_ptr(), 5, x.as_mut_ptr()) }, fmi2OK);
    }
}

/// The same in FMI 3.0; with `events` it stops at onsets and releases, with event mode.
fn by_fmi3(events: bool) {
    let host = fmi3::Host::new(events, events);
    assert_eq!(unsafe { fmi3SetDebugLogging(host.c, 0, 0, std::ptr::null()) }, fmi3OK);
    host.start();
    let take_part = || {
        while host.update().1 {}
        assert_eq!(unsafe { fmi3EnterStepMode(host.c) }, fmi3OK);
    };
    if events {
        take_part();
    }
    let mut time = 0.0;
    for step in 1..=1000 {
        while time < f64::from(step) * 0.01 {
            let (status, happened, reached) = host.step(time, f64::from(step) * 0.01 - time);
            assert_eq!(status, fmi3OK);
            time = reached;
            if happened {
                assert_eq!(unsafe { fmi3EnterEventMode(host.c) }, fmi3OK);
                take_part();
            }
        }
        host.floats("x", 5);
    }
}

fn versions(c: &mut Criterion) {
    let mut group = c.benchmark_group("default experiment, 1000 steps");
    group.bench_function("FMI 2.0", |b| b.iter(by_fmi2));
    group.bench_function("FMI 3.0", |b| b.iter(|| by_fmi3(false)));
    group.bench_function("FMI 3.0 with event mode and early return", |b| b.iter(|| by_fmi3(true)));
}

/// The derivatives of the last ball's position at the end of a run by all real parameters and inputs.
fn gradient(run: &Simulation) -> Vec<f64> {
    let tape = run.tape(&History::default()).expect("it has a tape");
    let gradient = tape.gradient(|of: &Differential| of.x[4]);
    let real = |variable: &Variable| variable.row.settable() && variable.row.access.data_type() == Type::Real;
    let by = |known: Variable| {
        let mut along = Settings::zero(5);
        known.set(&mut along, 1.0);
        gradient.along(&along.parameters, &along.inputs)
    };
    variables(5).filter(real).map(by).collect()
}

/// Five balls under every law, and how long they run, s. The last 0.1 s are the step whose derivatives are taken; all
/// but those that have settled collide in it.
const LAWS: [(&str, Scene, f64); 13] = [
    ("linear", scenes::DEFAULT, 9.55),
    ("Figure 6", scenes::TEN_MINUTES, 9.55),
    ("cubic", scenes::CUBIC, 9.3),
    ("steel, touching", scenes::STEEL, 9.55),
    (
        "steel, touching, unequal",
        (
            5,
            "x_start[1]=-0.1 contact.model=hertz contact.deadBand=0 ball.massRatio=1,2,1,0.5,1 \
             pendulum.lengthRatio=1,1.1,1,0.9,1",
        ),
        9.55,
    ),
    ("linear, touching, damped", (5, "x_start[1]=-0.1 contact.deadBand=0 contact.damping=300"), 9.55),
    (
        "Hunt-Crossley",
        (
            5,
            "x_start[1]=-0.1 contact.model=hertz contact.deadBand=0 contact.dampingLaw=huntCrossley \
             contact.huntCrossley=0.1",
        ),
        9.55,
    ),
    (
        "viscoelastic",
        (
            5,
            "x_start[1]=-0.1 contact.model=hertz contact.deadBand=0 contact.dampingLaw=viscoelastic \
             contact.relaxationTime=1e-7",
        ),
        9.55,
    ),
    ("1000 times critical", scenes::DAMPED, 9.55),
    ("arcs", (5, "x_start[1]=-0.1 pendulum.model=circular"), 9.55),
    ("rigid", (5, "x_start[1]=-0.1 contact.model=rigid contact.restitution=0.95"), 9.55),
    ("drag", (5, "x_start[1]=-0.1 contact.model=hertz pendulum.drag=0.1"), 9.55),
    ("settled", (5, "x_start[1]=-0.1 contact.model=hertz contact.deadBand=0 contact.damping=1e3"), 60.0),
];

/// A run and its gradient by everything, at most 8 times as long; a step and its derivatives along one direction, at
/// most 4 times as long, and 20 us.
fn derivatives(c: &mut Criterion) {
    for (name, (balls, settings), end) in LAWS {
        let mut start = Settings::default_for(balls);
        for (variable, value) in assignments(balls, &format!("x_start=0 {settings}")) {
            variable.set(&mut start, value);
        }
        let (parameters, from) = (start.parameters, end - 0.1);
        let run = |times: &[f64]| {
            let mut simulation = Simulation::new(&parameters, &Inputs::zero(5), 0.0).expect("it can start");
            for time in times {
                simulation.advance(*time, &mut Unrecorded).expect("the run goes on");
            }
            simulation
        };
        let mut group = c.benchmark_group(format!("derivatives, {name}"));
        let simulation = run(&[end]);
        group.bench_function("run", |b| b.iter(|| run(&[end])));
        group.bench_function("gradient of the run", |b| b.iter(|| gradient(&simulation)));
        let step = |mut run: Simulation| {
            run.advance(end, &mut Unrecorded).expect("the run goes on");
            run
        };
        let simulation = run(&[from, end]);
        let along = Inputs { force: vec![1.0, 0.0, 0.0, 0.0, 0.0], ..Inputs::zero(5) };
        group.bench_function("step", |b| b.iter_batched(|| run(&[from]), step, BatchSize::PerIteration));
        group.bench_function("direction over the step", |b| {
            b.iter(|| simulation.sensitivity_of_step(&History::default(), &along, false).expect("it is followed"));
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(2));
    targets = runs, calls, onsets, versions, derivatives
}
criterion_main!(benches);
