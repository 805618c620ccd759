//! Times of a run and of its gradient: the derivatives of one number by all real parameters and inputs.

use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};
use newtons_cradle::engine::{Differential, History, Simulation, Unrecorded};
use newtons_cradle::model::{ContactModel, Inputs, Parameters};
use newtons_cradle::variables::{Settings, Type, Variable, variables};

const BALLS: usize = 5;

fn run(parameters: &Parameters, end: f64) -> Simulation {
    let mut simulation = Simulation::new(parameters, &Inputs::zero(BALLS), 0.0).expect("the defaults can start");
    simulation.advance(end, &mut Unrecorded).expect("the run goes on");
    simulation
}

/// The derivatives of the last ball's position.
fn gradient(run: &Simulation, parameters: &Parameters) -> Vec<f64> {
    let tape = run.tape(parameters, 0.0, &History::default()).expect("elastic runs have a tape");
    let gradient = tape.gradient(&tape.weights(|of: &Differential| of.x[BALLS - 1]));
    let real = |variable: &Variable| variable.row.settable() && variable.row.access.data_type() == Type::Real;
    let mut along = Settings::zero(BALLS);
    let mut by = |known: Variable| {
        known.set_real(&mut along, 1.0);
        let derivative = gradient.along(&along.parameters, &along.inputs);
        known.set_real(&mut along, 0.0);
        derivative
    };
    variables(BALLS).filter(real).map(&mut by).collect()
}

fn gradients(c: &mut Criterion) {
    for (name, contact_model) in [("linear", ContactModel::PowerLaw), ("Hertz", ContactModel::Hertz)] {
        let parameters = Parameters { contact_model, ..Parameters::default_for(BALLS) };
        for end in [10.0, 140.0] {
            let mut group = c.benchmark_group(format!("{name}, {end} s"));
            group.bench_function("run", |b| b.iter(|| run(&parameters, end)));
            let simulation = run(&parameters, end);
            group.bench_function("gradient", |b| b.iter(|| gradient(&simulation, &parameters)));
            group.finish();
        }
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(2));
    targets = gradients
}
criterion_main!(benches);
