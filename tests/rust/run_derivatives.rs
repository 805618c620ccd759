//! Derivatives of the whole run: exact, checked against differences of runs with other parameters and inputs.

use newtons_cradle::engine::{Differential, History, Simulation, Unrecorded};
use newtons_cradle::model::{ContactModel, DampingLaw, Inputs, Parameters, SolverMethod};
use newtons_cradle::variables::{Settings, Type, Variable, variables};

use super::tapes::{rates_by, step};

/// Three balls that click, with gaps that keep the order of the pulses.
fn cradle() -> Parameters {
    let (x_start, v_start) = (vec![-0.1, 0.0, 0.0011], vec![0.02, 0.0, 0.0]);
    Parameters { x_start, v_start, ..Parameters::default_for(3) }
}

fn laws() -> Vec<(&'static str, Parameters)> {
    let p = cradle();
    let damped = |damping_law, exponent| Parameters {
        damping_law,
        exponent,
        damping: 1e4,
        hunt_crossley: 0.1,
        relaxation_time: 2e-7,
        drag: 0.1,
        ..p.clone()
    };
    vec![
        ("linear", p.clone()),
        ("cubic", Parameters { exponent: 3.0, ..p.clone() }),
        ("not whole", Parameters { exponent: 2.3, ..p.clone() }),
        ("Hertz", Parameters { contact_model: ContactModel::Hertz, ..p.clone() }),
        ("dashpot", damped(DampingLaw::KelvinVoigt, 1.0)),
        ("dashpot without pull", damped(DampingLaw::KelvinVoigtNoPull, 1.0)),
        ("Hunt-Crossley", damped(DampingLaw::HuntCrossley, 1.5)),
        ("viscoelastic", damped(DampingLaw::Viscoelastic, 2.0)),
        ("rigid", Parameters { contact_model: ContactModel::Rigid, restitution: 0.9, ..p.clone() }),
        ("bdf", Parameters { method: SolverMethod::Bdf, stiffness: 1e7, tolerance: 1e-14, ..p }),
    ]
}

/// A run whose inputs and damping change on the way.
struct Course {
    simulation: Simulation,
    history: History,
    parameters: Parameters,
}

const END: f64 = 2.7;

fn course(settings: &Settings) -> Course {
    let Settings { mut parameters, inputs } = settings.clone();
    let mut simulation = Simulation::new(&parameters, &inputs, 0.25).unwrap();
    let mut history = History::default();
    let advance = |simulation: &mut Simulation, time| simulation.advance(time, &mut Unrecorded).unwrap();
    advance(&mut simulation, 0.6);
    simulation.keep_history(true, parameters.tunables(), &mut history);
    let pushed =
        |inputs: &Inputs| Inputs { force: inputs.force.iter().map(|force| force + 0.1).collect(), ..inputs.clone() };
    let slopes = Inputs { support_acceleration: 0.2, ..Inputs::zero(3) };
    simulation.hold(&pushed(&inputs), &[slopes]).unwrap();
    advance(&mut simulation, 1.4);
    simulation.keep_history(true, parameters.tunables(), &mut history);
    simulation.hold(&inputs, &[]).unwrap();
    simulation.keep_history(true, parameters.tunables(), &mut history);
    for tunable in [&mut parameters.drag, &mut parameters.damping, &mut parameters.hunt_crossley] {
        *tunable += 0.01;
    }
    simulation.retune(&parameters).unwrap();
    advance(&mut simulation, 1.5);
    advance(&mut simulation, END);
    assert!(
        (0..2).map(|i| simulation.pulses(i)).sum::<u64>() >= 3,
        "{:?}",
        (simulation.pulses(0), simulation.pulses(1))
    );
    Course { simulation, history, parameters }
}

fn outputs(settings: &Settings) -> Vec<f64> {
    let run = course(settings).simulation;
    let (x, v): (Vec<_>, Vec<_>) = (0..3).map(|i| (run.x(i), run.v(i))).unzip();
    let impulses = (0..2).map(|i| run.impulse(i)).collect();
    let sums = vec![run.total_energy(), run.momentum(), run.support_force(), run.support_force_mean()];
    [x, v, impulses, sums, vec![run.next_onset().time()]].concat()
}

fn derivatives(found: &Differential) -> Vec<f64> {
    let sums = vec![found.energy, found.momentum, found.support_force, found.support_force_mean, found.next_onset];
    [found.x.clone(), found.v.clone(), found.impulse.clone(), sums].concat()
}

/// What the outputs may depend on.
fn knowns() -> impl Iterator<Item = Variable> {
    let real = |variable: &Variable| variable.row.settable() && variable.row.access.data_type() == Type::Real;
    variables(3).filter(real)
}

#[test]
fn they_agree_with_differences() {
    for (law, parameters) in laws() {
        let settings = Settings { parameters, inputs: Inputs::zero(3) };
        let Course { simulation, history, parameters } = course(&settings);
        let values = outputs(&settings);
        for known in knowns().filter(|known| !known.row.name.starts_with("solver")) {
            let value = known.real(&settings).unwrap();
            let mut along = Settings::zero(3);
            known.set_real(&mut along, 1.0);
            let found = simulation.sensitivity_of_run(&parameters, 0.25, &history, &along.parameters, &along.inputs);
            let found = found.unwrap_or_else(|_| panic!("{law}: {known} is not followed"));
            let found = derivatives(&found);
            let h = step(known, value);
            let one_sided = value == 0.0 && known.check_real(-1.0).is_err();
            let at = |steps: f64| {
                let mut changed = settings.clone();
                known.set_real(&mut changed, value + steps * h);
                outputs(&changed)
            };
            let (rates, rounding) = rates_by(at, one_sided);
            for (j, (value, rate)) in values.iter().zip(rates).enumerate() {
                let difference = rate / h;
                let error = (found[j] - difference).abs();
                let rounding = rounding * value.abs().max(1.0) / h;
                assert!(
                    error <= 1e-5 * difference.abs() + rounding,
                    "{law}: output {j} by {known}: {} {difference} {rounding}",
                    found[j]
                );
            }
        }
    }
}

/// Balls at rest in touch that forces press together: with an exponent that is not whole, the force has no series there. With damping,
/// so that they do not come to rest at the same place again.
#[test]
fn contacts_that_close_from_rest() {
    let mut p = Parameters { x_start: vec![0.0; 2], dead_band: 0.0, ..Parameters::default_for(2) };
    (p.contact_model, p.young_modulus, p.relaxation_time, p.hunt_crossley) = (ContactModel::Hertz, 1e6, 1e-4, 0.1);
    for damping_law in [DampingLaw::HuntCrossley, DampingLaw::Viscoelastic] {
        p.damping_law = damping_law;
        let inputs = Inputs { force: vec![1.0, -1.5], ..Inputs::zero(2) };
        let run = |mass: f64| {
            let p = Parameters { mass, ..p.clone() };
            let mut simulation = Simulation::new(&p, &inputs, 0.0).unwrap();
            simulation.advance(0.31, &mut Unrecorded).unwrap();
            simulation
        };
        let along = Parameters { mass: 1.0, ..Settings::zero(2).parameters };
        let found = run(1.0).sensitivity_of_run(&p, 0.0, &History::default(), &along, &Inputs::zero(2));
        let found = found.unwrap_or_else(|_| panic!("{damping_law:?} is not followed"));
        let [more, less] = [1e-6, -1e-6].map(|h| run(1.0 + h));
        for (output, found, difference) in [
            ("v[1]", found.v[0], more.v(0) - less.v(0)),
            ("impulse[1]", found.impulse[0], more.impulse(0) - less.impulse(0)),
        ] {
            let difference = difference / 2e-6;
            assert!(
                (found - difference).abs() < 1e-6 * difference.abs(),
                "{damping_law:?} {output}: {found} {difference}"
            );
        }
    }
}
