//! The same runs by the functions of FMI 2.0 and of FMI 3.0.

#![expect(unsafe_code, reason = "hosts call C functions")]

use std::ffi::CString;
use std::ptr::{null, null_mut};
use std::time::Duration;

use cradle_host::{Host, fmi2OK};
use criterion::{Criterion, criterion_group, criterion_main};
use newtons_cradle::fmi2::{fmi2DoStep, fmi2GetReal};
use newtons_cradle::fmi3::fmi3Status::fmi3OK;
use newtons_cradle::fmi3::*;
use newtons_cradle::variables::{Array, Description, Settings};

/// s.
const STEP: f64 = 0.01;
const STEPS: u32 = 1000;
const BALLS: usize = 5;

/// Positions at all communication points of the default experiment in FMI 2.0; their sum.
fn by_fmi2() -> f64 {
    let host = Host::new();
    host.start();
    let references: Vec<u32> = (1..=BALLS).map(|i| host.vr(&format!("x[{i}]"))).collect();
    let (mut sum, mut x) = (0.0, [0.0; BALLS]);
    for step in 0..STEPS {
        unsafe {
            assert_eq!(fmi2DoStep(host.c, f64::from(step) * STEP, STEP, 1), fmi2OK);
            assert_eq!(fmi2GetReal(host.c, references.as_ptr(), BALLS, x.as_mut_ptr()), fmi2OK);
        }
        sum += x.iter().sum::<f64>();
    }
    sum
}

/// The same in FMI 3.0; with `events` it stops at onsets and releases, and takes part in them.
fn by_fmi3(token: &CString, events: bool) -> f64 {
    let reference = Array::named("x").map_or(0, Array::reference);
    let (on, name) = (fmi3Boolean::from(events), c"bench".as_ptr());
    let (mut sum, mut x) = (0.0, [0.0; BALLS]);
    unsafe {
        let c =
            fmi3InstantiateCoSimulation(name, token.as_ptr(), null(), 0, 0, on, on, null(), 0, null_mut(), None, None);
        assert!(!c.is_null());
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), fmi3OK);
        assert_eq!(fmi3ExitInitializationMode(c), fmi3OK);
        if events {
            take_part(c);
        }
        let mut time = 0.0;
        for step in 1..=STEPS {
            let end = f64::from(step) * STEP;
            while time < end {
                let (mut happened, mut ended, mut early) = (0, 0, 0);
                let h = end - time;
                let status = fmi3DoStep(c, time, h, 1, &mut happened, &mut ended, &mut early, &mut time);
                assert_eq!(status, fmi3OK);
                if happened != 0 {
                    assert_eq!(fmi3EnterEventMode(c), fmi3OK);
                    take_part(c);
                }
            }
            assert_eq!(fmi3GetFloat64(c, &reference, 1, x.as_mut_ptr(), BALLS), fmi3OK);
            sum += x.iter().sum::<f64>();
        }
        fmi3FreeInstance(c);
    }
    sum
}

/// All events there are, and on to the next step.
unsafe fn take_part(c: fmi3Instance) {
    let mut again = 1;
    while again != 0 {
        let [mut ended, mut nominals, mut values, mut defined] = [0; 4];
        let status = unsafe {
            fmi3UpdateDiscreteStates(c, &mut again, &mut ended, &mut nominals, &mut values, &mut defined, &mut 0.0)
        };
        assert_eq!(status, fmi3OK);
    }
    assert_eq!(unsafe { fmi3EnterStepMode(c) }, fmi3OK);
}

fn versions(c: &mut Criterion) {
    let token = CString::new(Description::fmi3(&Settings::default_for(BALLS)).guid()).unwrap_or_default();
    let sums = [by_fmi2(), by_fmi3(&token, false), by_fmi3(&token, true)];
    assert!(sums.iter().all(|sum| (sum - sums[0]).abs() < 1e-9), "{sums:?}");
    let mut group = c.benchmark_group("default experiment, 1000 steps");
    group.bench_function("FMI 2.0", |b| b.iter(by_fmi2));
    group.bench_function("FMI 3.0", |b| b.iter(|| by_fmi3(&token, false)));
    group.bench_function("FMI 3.0 with event mode and early return", |b| b.iter(|| by_fmi3(&token, true)));
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(2));
    targets = versions
}
criterion_main!(benches);
