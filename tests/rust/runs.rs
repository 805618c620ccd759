//! Runs of the engine, and what many tests ask of them.

use cradle_host::assignments;
use newtons_cradle::engine::{Engine, Results, Unrecorded};
use newtons_cradle::model::{Inputs, Parameters};
use newtons_cradle::variables::Settings;

/// A cradle with these parameters; see [`assignments`].
pub fn cradle(balls: usize, text: &str) -> Parameters {
    let mut settings = Settings::default_for(balls);
    for (variable, value) in assignments(balls, text) {
        assert!(variable.row.settable(), "{variable}");
        variable.set(&mut settings, value);
    }
    settings.parameters
}

/// The same of balls at rest side by side that just touch.
pub fn touching(balls: usize, text: &str) -> Parameters {
    cradle(balls, &format!("x_start=0 contact.deadBand=0 {text}"))
}

/// Such balls without gravity, the first `strikers` of them at 1 m/s; F = overlap^p in SI units.
pub fn struck_chain(n: usize, strikers: usize, exponent: f64) -> Parameters {
    let mut p = Parameters { gravity: 0.0, stiffness: 1.0, overlap_ref: 1.0, exponent, ..touching(n, "") };
    p.v_start[..strikers].fill(1.0);
    p
}

/// A cradle without inputs, at its start.
pub fn started(p: &Parameters) -> Engine {
    Engine::new(p, &Inputs::zero(p.balls()), 0.0).unwrap()
}

/// A run without inputs to the time `time` (s).
pub fn run(p: &Parameters, time: f64) -> Engine {
    run_under(p, &Inputs::zero(p.balls()), time)
}

/// The same under constant inputs.
pub fn run_under(p: &Parameters, inputs: &Inputs, time: f64) -> Engine {
    let mut engine = Engine::new(p, inputs, 0.0).unwrap();
    engine.advance(time, &mut Unrecorded).unwrap();
    engine
}

/// Positions (m) and velocities (m/s) of the first `n` balls.
pub fn state(run: &dyn Results, n: usize) -> (Vec<f64>, Vec<f64>) {
    (0..n).map(|i| (run.x(i), run.v(i))).unzip()
}

/// All energy there is or has been, J.
pub fn energy(run: &dyn Results) -> f64 {
    run.total_energy() + run.dissipated_energy() + run.external_work().abs()
}

/// Asserts that nothing but work and losses has changed the energy, by more than this part of it.
#[track_caller]
pub fn assert_energy(run: &dyn Results, allowed: f64, what: &str) {
    let (off, all) = (run.energy_residual().abs(), energy(run));
    assert!(off <= allowed * all, "{what}: the energy is off by {off:e} of {all:e} J");
}
