//! Tapes: derivatives of whole runs of elastic contacts in both directions.

use newtons_cradle::engine::{Differential, History, Simulation, Tape, Unrecorded};
use newtons_cradle::model::{ContactModel, DampingLaw, Inputs, Parameters, SolverMethod};
use newtons_cradle::variables::{Settings, Type, Variable, variables};

const START: f64 = 0.25;

/// What a run may depend on.
fn knowns(balls: usize) -> impl Iterator<Item = Variable> {
    let real = |variable: &Variable| variable.row.settable() && variable.row.access.data_type() == Type::Real;
    variables(balls).filter(real).filter(|known| !known.row.name.starts_with("solver"))
}

/// A run whose inputs and drag change on the way, from this start to this end.
fn course(settings: &Settings, end: f64) -> (Simulation, History, Parameters) {
    let Settings { mut parameters, inputs } = settings.clone();
    let mut simulation = Simulation::new(&parameters, &inputs, START).unwrap();
    let mut history = History::default();
    simulation.advance(0.6, &mut Unrecorded).unwrap();
    simulation.keep_history(true, parameters.tunables(), &mut history);
    let force = inputs.force.iter().map(|force| force + 0.1).collect();
    let slopes = Inputs { support_acceleration: 0.2, ..Inputs::zero(inputs.force.len()) };
    simulation.hold(&Inputs { force, ..inputs.clone() }, &[slopes]).unwrap();
    simulation.advance(1.4, &mut Unrecorded).unwrap();
    simulation.keep_history(true, parameters.tunables(), &mut history);
    simulation.hold(&inputs, &[]).unwrap();
    simulation.keep_history(true, parameters.tunables(), &mut history);
    parameters.drag += 0.01;
    simulation.retune(&parameters).unwrap();
    simulation.advance(end, &mut Unrecorded).unwrap();
    (simulation, history, parameters)
}

/// Outputs that a tape has derivatives of.
fn outputs(settings: &Settings, end: f64) -> Vec<f64> {
    let run = course(settings, end).0;
    let balls = 0..settings.parameters.balls();
    let states = balls.clone().map(|i| run.x(i)).chain(balls.clone().map(|i| run.v(i)));
    let impulses = balls.skip(1).map(|i| run.impulse(i - 1));
    states.chain(impulses).chain([run.total_energy(), run.momentum(), run.support_force()]).collect()
}

fn derivatives(of: &Differential) -> Vec<f64> {
    let sums = [of.energy, of.momentum, of.support_force];
    of.x.iter().chain(&of.v).chain(&of.impulse).chain(&sums).copied().collect()
}

fn sum(weights: &[f64], of: &Differential) -> f64 {
    derivatives(of).iter().zip(weights).map(|(derivative, weight)| derivative * weight).sum()
}

/// Numbers between -1 and 1, always the same for a seed.
fn spread(seed: usize) -> impl Iterator<Item = f64> {
    (1000 * seed..).map(|k| (k as f64 * 0.618_033_988_749_895).fract() * 2.0 - 1.0)
}

/// Runs that end between, and in contacts.
fn runs() -> Vec<(&'static str, Parameters, f64)> {
    let (x_start, v_start) = (vec![-0.1, 0.0, 0.0011], vec![0.02, 0.0, 0.0]);
    let p = Parameters { x_start, v_start, ..Parameters::default_for(3) };
    let unequal = vec![1.0, 1.02, 1.0];
    let hertz = Parameters { contact_model: ContactModel::Hertz, ..p.clone() };
    let together = Parameters { x_start: vec![-0.10002, -0.1, 0.0], ..hertz.clone() };
    let overlapping = Parameters { gap: vec![-1e-5, 0.0], dead_band: 0.0, stiffness: 1e4, ..p.clone() };
    vec![
        ("linear", p.clone(), 2.7),
        ("unequal lengths", Parameters { length_ratio: unequal, ..p.clone() }, 2.7),
        ("drag", Parameters { drag: 0.1, ..p.clone() }, 2.7),
        ("cubic", Parameters { exponent: 3.0, ..p.clone() }, 2.7),
        ("not whole", Parameters { exponent: 2.3, ..p }, 2.7),
        ("Hertz", hertz, 2.7),
        ("three at once", together, 1.6),
        ("closed at the start and the end", overlapping, 1.6),
    ]
}

#[test]
fn they_agree_with_differences() {
    for (name, parameters, end) in runs() {
        let settings = Settings { parameters, inputs: Inputs::zero(3) };
        let (simulation, history, parameters) = course(&settings, end);
        let tape = simulation.tape(&parameters, START, &history).expect(name);
        let values = outputs(&settings, end);
        for known in knowns(3) {
            let value = known.real(&settings).unwrap();
            let mut along = Settings::zero(3);
            known.set_real(&mut along, 1.0);
            let found = derivatives(&tape.along(&along.parameters, &along.inputs));
            let h = step(known, value);
            let one_sided = value == 0.0 && known.check_real(-1.0).is_err();
            let at = |steps: f64| {
                let mut changed = settings.clone();
                known.set_real(&mut changed, value + steps * h);
                outputs(&changed, end)
            };
            let (rates, rounding) = rates_by(at, one_sided);
            for (j, (value, rate)) in values.iter().zip(rates).enumerate() {
                let difference = rate / h;
                let bound = 1e-5 * difference.abs() + rounding * value.abs().max(1.0) / h;
                let found = found[j];
                assert!(
                    (found - difference).abs() <= bound,
                    "{name}: output {j} by {known}: {found} {difference} {bound}"
                );
            }
        }
    }
}

/// The step of differences by what has this value.
pub(super) fn step(known: Variable, value: f64) -> f64 {
    let unit = if ["contact.gap", "contact.deadBand"].contains(&known.row.name) { 1e-3 } else { 1.0 };
    1e-5 * if value == 0.0 { unit } else { value.abs() }
}

/// Derivatives of values at 0 by the step, from their differences, and what rounding makes of values of 1: of sixth order, or
/// `one_sided` of fourth order.
pub(super) fn rates_by(at: impl Fn(f64) -> Vec<f64>, one_sided: bool) -> (Vec<f64>, f64) {
    let weights: &[(f64, f64)] = if one_sided {
        &[(0.0, -25.0 / 12.0), (1.0, 4.0), (2.0, -3.0), (3.0, 4.0 / 3.0), (4.0, -0.25)]
    } else {
        &[(1.0, 0.75), (-1.0, -0.75), (2.0, -0.15), (-2.0, 0.15), (3.0, 1.0 / 60.0), (-3.0, -1.0 / 60.0)]
    };
    let rounding = weights.iter().map(|(_, weight)| 6e-13 * weight.abs()).sum();
    let mut sums = Vec::new();
    for (step, weight) in weights {
        let values = at(*step);
        sums.resize(values.len(), 0.0);
        sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
    }
    (sums, rounding)
}

/// Both directions of a tape, by several weights of the outputs and directions, some of them along few of the knowns: the weighted sum of
/// the derivatives along the direction, and the sum of its derivatives by each of the knowns, agree to 1e-12 of the larger one.
fn both_ways(name: &str, tape: &Tape, balls: usize) {
    for seed in 0..8 {
        let weights: Vec<f64> = spread(seed).take(3 * balls + 2).collect();
        let gradient = tape.gradient(&tape.weights(|of| sum(&weights, of)));
        let mut all = Settings::zero(balls);
        let mut adjoint = 0.0;
        let few = |k: usize| seed < 4 || k % 4 == seed % 4;
        for (_, (known, change)) in knowns(balls).zip(spread(seed + 1)).enumerate().filter(|(k, _)| few(*k)) {
            known.set_real(&mut all, change);
            let mut along = Settings::zero(balls);
            known.set_real(&mut along, change);
            adjoint += gradient.along(&along.parameters, &along.inputs);
        }
        let directional = sum(&weights, &tape.along(&all.parameters, &all.inputs));
        let error = (adjoint - directional).abs() / adjoint.abs().max(directional.abs());
        assert!(error <= 1e-12, "{name}, seed {seed}: {adjoint} {directional}: {error}");
    }
}

#[test]
fn both_directions_agree_through_a_hundred_clicks() {
    // The derivatives grow with the run: for five balls of Hertz with small gaps to 1e13, for seven in touch to 1e25.
    let (linear, hertz) = (ContactModel::PowerLaw, ContactModel::Hertz);
    for (contact_model, balls, gap) in [
        (linear, 5, None),
        (hertz, 3, None),
        (hertz, 4, Some(0.0)),
        (hertz, 5, None),
        (hertz, 5, Some(1e-6)),
        (hertz, 7, Some(0.0)),
    ] {
        let default = Parameters::default_for(balls);
        let gap = gap.map_or(default.gap.clone(), |gap| vec![gap; balls - 1]);
        let parameters = Parameters { contact_model, gap, ..default };
        let mut simulation = Simulation::new(&parameters, &Inputs::zero(balls), 0.0).unwrap();
        for end in [1.0, 10.0, 142.0] {
            simulation.advance(end, &mut Unrecorded).unwrap();
            let tape = simulation.tape(&parameters, 0.0, &History::default()).unwrap();
            both_ways(&format!("{contact_model:?}, {balls} balls, {end} s"), &tape, balls);
        }
        assert!((0..balls - 1).map(|i| simulation.pulses(i)).min() >= Some(100));
    }
}

#[test]
fn both_directions_agree_whatever_acts() {
    for (name, parameters, end) in runs() {
        let (simulation, history, parameters) = course(&Settings { parameters, inputs: Inputs::zero(3) }, end);
        both_ways(name, &simulation.tape(&parameters, START, &history).expect(name), 3);
    }
}

#[test]
fn only_elastic_event_driven_runs_have_one() {
    let p = Parameters::default_for(2);
    let damped = Parameters { damping: 1.0, ..p.clone() };
    for other in [
        Parameters { contact_model: ContactModel::Rigid, ..p.clone() },
        Parameters { method: SolverMethod::Bdf, stiffness: 1e6, ..p.clone() },
        Parameters { damping_law: DampingLaw::KelvinVoigtNoPull, ..damped.clone() },
        damped,
        Parameters {
            contact_model: ContactModel::Hertz,
            damping_law: DampingLaw::HuntCrossley,
            hunt_crossley: 0.1,
            ..p
        },
    ] {
        let mut simulation = Simulation::new(&other, &Inputs::zero(2), 0.0).unwrap();
        assert!(simulation.tape(&other, 0.0, &History::default()).is_none());
        simulation.advance(0.1, &mut Unrecorded).unwrap();
        assert!(simulation.tape(&other, 0.0, &History::default()).is_none());
    }
}

/// Without gravity a flight is a polynomial, as short as it is to the oscillator: with the slope of an input one of the third degree.
#[test]
fn long_flights_without_gravity() {
    let p = Parameters { gravity: 0.0, x_start: vec![0.0], ..Parameters::default_for(1) };
    let mut simulation = Simulation::new(&p, &Inputs::zero(1), 0.0).unwrap();
    let mut history = History::default();
    simulation.keep_history(true, p.tunables(), &mut history);
    let slope = Inputs { support_acceleration: -1.0, ..Inputs::zero(1) };
    simulation.hold(&Inputs::zero(1), &[slope]).unwrap();
    simulation.advance(1.0, &mut Unrecorded).unwrap();
    let along = Parameters { gravity: 1.0, ..Settings::zero(1).parameters };
    let found = simulation.tape(&p, 0.0, &history).unwrap().along(&along, &Inputs::zero(1));
    // x = t^3 / 6, and a small gravity g pulls it back by g x / length.
    assert!((found.x[0] * p.length * 120.0 + 1.0).abs() < 1e-14, "{}", found.x[0]);
}

/// A brake that changes at every millisecond, there and back.
#[test]
fn parameters_that_change_all_the_time() {
    for contact_model in [ContactModel::PowerLaw, ContactModel::Hertz] {
        let mut p = Parameters { contact_model, ..Parameters::default_for(3) };
        let mut simulation = Simulation::new(&p, &Inputs::zero(3), 0.0).unwrap();
        let mut history = History::default();
        for k in 1..=1000 {
            simulation.advance(1e-3 * f64::from(k), &mut Unrecorded).unwrap();
            simulation.keep_history(true, p.tunables(), &mut history);
            p.drag = 0.01 * f64::from(k % 3);
            simulation.retune(&p).unwrap();
        }
        simulation.advance(1.1, &mut Unrecorded).unwrap();
        let tape = simulation.tape(&p, 0.0, &history).unwrap();
        both_ways(&format!("{contact_model:?}"), &tape, 3);
        // Linear forces do not depend on the reference overlap, and for the exponent the run is followed to 1e-3 only.
        for known in knowns(3).filter(|known| !["contact.overlapRef", "contact.exponent"].contains(&known.row.name)) {
            let mut along = Settings::zero(3);
            known.set_real(&mut along, 1.0);
            let Settings { parameters, inputs } = along;
            let found = derivatives(&tape.along(&parameters, &inputs));
            let followed = simulation.sensitivity_of_run(&p, 0.0, &history, &parameters, &inputs).unwrap();
            let followed = derivatives(&followed);
            let size = followed.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
            for (found, followed) in found.iter().zip(followed) {
                assert!((found - followed).abs() <= 1e-8 * size, "{contact_model:?}, {known}: {found} {followed}");
            }
        }
    }
}

#[test]
fn another_course_than_that_of_the_run_has_none() {
    let p = Parameters::default_for(3);
    let (simulation, history, end) = course(&Settings { parameters: p.clone(), inputs: Inputs::zero(3) }, 2.7);
    assert!(simulation.tape(&end, START, &history).is_some());
    assert!(simulation.tape(&end, START, &History::default()).is_none());
    let later = Parameters { v_start: vec![0.0, 0.0, 1e-6], ..end };
    assert!(simulation.tape(&later, START, &history).is_none());
}
