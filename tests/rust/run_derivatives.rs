//! Derivatives of the whole run, along directions and backwards, checked against differences of runs with other
//! parameters and inputs, and against each other.

use newtons_cradle::engine::{Differential, History, Simulation, Tape, Unfollowed, Unrecorded};
use newtons_cradle::model::{ContactModel, Inputs, Parameters};
use newtons_cradle::variables::Settings;

use super::differences::{by_differences, knowns, step};
use super::runs::{cradle, touching};

const START: f64 = 0.25;

/// A run whose inputs and damping change on the way.
struct Course {
    simulation: Simulation,
    history: History,
    /// At its end.
    parameters: Parameters,
}

impl Course {
    /// From [`START`] to `end` (s), with the drag and the damping of the contacts changed on the way.
    fn new(settings: &Settings, end: f64) -> Self {
        let Settings { mut parameters, inputs, .. } = settings.clone();
        let mut simulation = Simulation::new(&parameters, &inputs, START).unwrap();
        let mut history = History::default();
        simulation.advance(0.6, &mut Unrecorded).unwrap();
        simulation.keep_history(true, &mut history);
        let force = inputs.force.iter().map(|force| force + 0.1).collect();
        let slopes = Inputs { support_acceleration: 0.2, ..Inputs::zero(inputs.force.len()) };
        simulation.hold(&Inputs { force, ..inputs.clone() }, &[slopes]).unwrap();
        simulation.advance(1.4, &mut Unrecorded).unwrap();
        simulation.keep_history(true, &mut history);
        simulation.hold(&inputs, &[]).unwrap();
        simulation.keep_history(true, &mut history);
        parameters.drag += 0.01;
        parameters.damping += 0.01;
        parameters.hunt_crossley += 0.01;
        simulation.retune(&parameters.tunables()).unwrap();
        simulation.advance(1.5, &mut Unrecorded).unwrap();
        simulation.advance(end, &mut Unrecorded).unwrap();
        Self { simulation, history, parameters }
    }

    fn outputs(&self) -> Vec<f64> {
        let (run, balls) = (&self.simulation, 0..self.parameters.balls());
        let states = balls.clone().map(|i| run.x(i)).chain(balls.clone().map(|i| run.v(i)));
        let impulses = balls.clone().skip(1).map(|i| run.impulse(i - 1));
        let sums = [run.total_energy(), run.momentum(), run.support_force(), run.support_force_mean()];
        let heights = balls.clone().map(|i| run.angle(i)).chain(balls.map(|i| run.y(i)));
        // Without an onset it is the time up to which there is none.
        let next = [run.next_onset().found().unwrap_or(0.0), run.support_force_vertical()];
        states.chain(impulses).chain(sums).chain(next).chain(heights).collect()
    }

    /// Its derivatives along a direction, by repeating it.
    fn along(&self, along: &Settings) -> Result<Differential, Unfollowed> {
        let direction = (&along.parameters, &along.inputs);
        self.simulation.sensitivity_of_run(&self.history, direction, true)
    }

    fn tape(&self) -> Result<Tape, Unfollowed> {
        self.simulation.tape(&self.history)
    }
}

/// A unit of one of the [`knowns`].
fn unit(known: newtons_cradle::variables::Variable, balls: usize) -> Settings {
    let mut along = Settings::zero(balls);
    known.set(&mut along, 1.0);
    along
}

/// The derivatives of [`Course::outputs`].
fn derivatives(of: &Differential) -> Vec<f64> {
    let sums = [of.total_energy, of.momentum, of.support_force, of.support_force_mean];
    let (states, next) = (of.x.iter().chain(&of.v).chain(&of.impulse), [of.next_onset, of.support_force_vertical]);
    states.chain(&sums).chain(&next).chain(&of.angle).chain(&of.y).copied().collect()
}

/// All but that of the next onset, which has none backwards.
fn without_next_onset(of: &Differential) -> Vec<f64> {
    derivatives(&Differential { next_onset: 0.0, ..of.clone() })
}

fn sum(weights: &[f64], of: &Differential) -> f64 {
    without_next_onset(of).iter().zip(weights).map(|(derivative, weight)| derivative * weight).sum()
}

/// Numbers between -1 and 1, always the same for a seed.
fn spread(seed: usize) -> impl Iterator<Item = f64> {
    (1000 * seed..).map(|k| (k as f64 * 0.618_033_988_749_895).fract() * 2.0 - 1.0)
}

/// Runs of three balls that end between and in contacts, with gaps that keep the order of the pulses, and their ends,
/// s.
const RUNS: [(&str, f64); 20] = [
    ("", 2.7),
    ("pendulum.lengthRatio[2]=1.02", 2.7),
    ("pendulum.drag=0.1", 2.7),
    ("contact.exponent=3", 2.7),
    ("contact.exponent=2.3", 2.7),
    ("contact.model=hertz", 2.7),
    // Impacts of two that take a hundredth of a second, in which pendulums, drag and inputs count.
    ("x_start=-0.1,0,0.06 contact.stiffness=2e4 contact.overlapRef=1", 2.7),
    ("x_start=-0.1,0,0.06 contact.stiffness=4e6 contact.overlapRef=1 contact.exponent=2", 2.7),
    // Three at once.
    ("contact.model=hertz x_start=-0.10002,-0.1,0", 1.6),
    // Closed at the start and the end.
    ("contact.gap[1]=-1e-5 contact.deadBand=0 contact.stiffness=1e4", 1.6),
    ("contact.damping=1e4 pendulum.drag=0.1", 2.7),
    ("contact.damping=1e4 pendulum.drag=0.1 contact.dampingLaw=kelvinVoigtNoPull", 2.7),
    ("contact.dampingLaw=huntCrossley contact.huntCrossley=0.1 contact.exponent=1.5 pendulum.drag=0.1", 2.7),
    ("contact.dampingLaw=viscoelastic contact.relaxationTime=2e-7 contact.exponent=2 pendulum.drag=0.1", 2.7),
    ("contact.model=rigid contact.restitution=0.9", 2.7),
    ("contact.model=rigid contact.restitution=0.9 pendulum.model=circular pendulum.lengthRatio[2]=1.02", 2.7),
    ("pendulum.model=circular contact.model=hertz", 2.7),
    ("pendulum.model=circular contact.model=hertz pendulum.lengthRatio[2]=1.02 pendulum.drag=0.1", 2.7),
    ("pendulum.model=circular contact.damping=1e4 pendulum.drag=0.1", 2.7),
    ("solver.method=bdf contact.stiffness=1e7 solver.tolerance=1e-14", 2.7),
];

#[test]
fn derivatives_of_a_run_agree_with_differences_and_adjoints() {
    for (name, end) in RUNS {
        let parameters = cradle(3, &format!("x_start=-0.1,0,0.0011 v_start[1]=0.02 {name}"));
        let settings = Settings { parameters, ..Settings::default_for(3) };
        let course = Course::new(&settings, end);
        let (values, tape) = (course.outputs(), course.tape().unwrap_or_else(|why| panic!("{name}: {why}")));
        both_ways(name, &tape, &settings, 1e-12);
        for known in knowns(3) {
            let (value, along) = (known.value(&settings).unwrap(), unit(known, 3));
            let taped = tape.along(&along.parameters, &along.inputs);
            let found = course.along(&along).unwrap_or_else(|why| panic!("{name}: {known}: {why}"));
            assert_eq!(without_next_onset(&taped), without_next_onset(&found), "{name}: {known}");
            let h = step(known, value);
            let one_sided = value == 0.0 && known.check(-1.0).is_err();
            let (differences, rounding) = by_differences(h, one_sided, |change| {
                let mut changed = settings.clone();
                known.set(&mut changed, value + change);
                Course::new(&changed, end).outputs()
            });
            let next_onset = 12;
            for (j, (found, difference)) in derivatives(&found).into_iter().zip(&differences).enumerate() {
                if j == next_onset && values[j] == 0.0 {
                    continue; // There is none, but may be one in a changed run.
                }
                let bound = 1e-5 * difference.abs() + 6e-13 * rounding * values[j].abs().max(1.0);
                assert!(
                    (found - difference).abs() <= bound,
                    "{name}: output {j} by {known}: {found} {difference} {bound}"
                );
            }
        }
    }
}

/// Balls at rest in touch that forces press together: with an exponent that is not whole, the force has no series
/// there. With damping, so that they do not come to rest at the same place again.
#[test]
fn derivatives_of_a_run_with_contacts_closing_from_rest() {
    for law in ["huntCrossley", "viscoelastic"] {
        let losses = "contact.relaxationTime=1e-4 contact.huntCrossley=0.1";
        let p = touching(2, &format!("contact.model=hertz ball.youngModulus=1e6 {losses} contact.dampingLaw={law}"));
        let inputs = Inputs { force: vec![1.0, -1.5], ..Inputs::zero(2) };
        let run = |mass: f64| {
            let p = Parameters { mass, ..p.clone() };
            let mut simulation = Simulation::new(&p, &inputs, 0.0).unwrap();
            simulation.advance(0.31, &mut Unrecorded).unwrap();
            simulation
        };
        let along = Parameters { mass: 1.0, ..Settings::zero(2).parameters };
        let direction = (&along, &Inputs::zero(2));
        let found = run(1.0).sensitivity_of_run(&History::default(), direction, false);
        let found = found.unwrap_or_else(|why| panic!("{law}: {why}"));
        let (differences, _) = by_differences(1e-6, false, |change| {
            let changed = run(1.0 + change);
            vec![changed.v(0), changed.impulse(0)]
        });
        let found = [("v[1]", found.v[0]), ("impulse[1]", found.impulse[0])];
        for ((output, found), difference) in found.into_iter().zip(differences) {
            assert!((found - difference).abs() < 1e-6 * difference.abs(), "{law} {output}: {found} {difference}");
        }
    }
}

/// Both directions of a tape, by several weights of the outputs and directions, some of them along few of the knowns:
/// the weighted sum of the derivatives along the direction, and the sum of its derivatives by each of the knowns, agree
/// to within an `allowed` part of the largest of these.
fn both_ways(name: &str, tape: &Tape, settings: &Settings, allowed: f64) {
    let balls = settings.balls();
    for seed in 0..8 {
        let weights: Vec<f64> = spread(seed).take(6 * balls + 8).collect();
        let gradient = tape.gradient(|of| sum(&weights, of));
        let mut all = Settings::zero(balls);
        let (mut adjoint, mut largest) = (0.0, 0.0_f64);
        let few = |k: usize| seed < 4 || k % 4 == seed % 4;
        for (_, (known, part)) in knowns(balls).zip(spread(seed + 1)).enumerate().filter(|(k, _)| few(*k)) {
            // In proportion: a change by 1 is a million reference overlaps.
            let change = 1e5 * part * step(known, known.value(settings).unwrap());
            known.set(&mut all, change);
            let mut along = Settings::zero(balls);
            known.set(&mut along, change);
            let by_known = gradient.along(&along.parameters, &along.inputs);
            (adjoint, largest) = (adjoint + by_known, largest.max(by_known.abs()));
        }
        let directional = sum(&weights, &tape.along(&all.parameters, &all.inputs));
        let error = (adjoint - directional).abs() / largest;
        assert!(error <= allowed, "{name}, seed {seed}: {adjoint} {directional}: {error}");
    }
}

#[test]
fn derivatives_of_a_run_agree_with_adjoints_through_a_hundred_clicks() {
    // The derivatives grow with the run: for five balls of Hertz with small gaps to 1e13, for seven in touch to 1e25.
    for (balls, settings, allowed) in [
        (5, "", 1e-12),
        (3, "contact.model=hertz", 3e-11),
        (4, "contact.model=hertz", 3e-11),
        (5, "contact.model=hertz", 3e-11),
        (5, "contact.model=hertz contact.gap=1e-6", 1e-11),
        (7, "contact.model=hertz", 1e-10),
    ] {
        let parameters = cradle(balls, settings);
        let mut simulation = Simulation::new(&parameters, &Inputs::zero(balls), 0.0).unwrap();
        let known = Settings { parameters, ..Settings::default_for(balls) };
        for end in [1.0, 10.0, 142.0] {
            simulation.advance(end, &mut Unrecorded).unwrap();
            let tape = simulation.tape(&History::default()).unwrap();
            both_ways(&format!("{settings}, {balls} balls, {end} s"), &tape, &known, allowed);
        }
        assert!((0..balls - 1).map(|i| simulation.pulses(i)).min() >= Some(100));
    }
}

/// Without gravity a flight is a polynomial, as short as it is to the oscillator: with the slope of an input one of the
/// third degree.
#[test]
fn derivatives_of_a_run_with_long_flights_without_gravity() {
    let p = cradle(1, "gravity=0 x_start=0");
    let mut simulation = Simulation::new(&p, &Inputs::zero(1), 0.0).unwrap();
    let mut history = History::default();
    simulation.keep_history(true, &mut history);
    let slope = Inputs { support_acceleration: -1.0, ..Inputs::zero(1) };
    simulation.hold(&Inputs::zero(1), &[slope]).unwrap();
    simulation.advance(1.0, &mut Unrecorded).unwrap();
    let along = Parameters { gravity: 1.0, ..Settings::zero(1).parameters };
    let found = simulation.tape(&history).unwrap().along(&along, &Inputs::zero(1));
    // x = t^3 / 6, and a small gravity g pulls it back by g x / length.
    assert!((found.x[0] * p.length * 120.0 + 1.0).abs() < 1e-14, "{}", found.x[0]);
}

/// A step in which inputs change, and at whose end inputs and a parameter do.
fn cut_step(p: &Parameters, change: f64) -> (Simulation, History) {
    let held = |force: f64| Inputs { force: vec![0.0, 0.0, 0.0, force + change], support_acceleration: 0.1 };
    let mut simulation = Simulation::new(p, &held(0.2), START).unwrap();
    let (mut history, mut p) = (History::default(), p.clone());
    simulation.hold(&Inputs::zero(4), &[]).unwrap();
    simulation.advance(0.3, &mut Unrecorded).unwrap();
    simulation.begin_step();
    history.begin_step();
    for (time, force) in [(0.3, 0.2), (0.7, 0.5), (0.95, 0.1), (1.2, 3.0)] {
        simulation.continue_step(time, &mut Unrecorded).unwrap();
        simulation.keep_history(false, &mut history);
        simulation.hold(&held(force), &[]).unwrap();
    }
    simulation.keep_history(false, &mut history);
    p.drag += 0.3;
    simulation.retune(&p.tunables()).unwrap();
    (simulation, history)
}

/// Along a change of the inputs over all of it; those that act from its end on count for the next onset only.
#[test]
fn derivatives_of_a_step_cut_by_inputs() {
    let soft = "contact.stiffness=2e3 contact.overlapRef=1 contact.damping=3 pendulum.drag=0.2";
    for settings in ["pendulum.drag=0.1", soft, "contact.stiffness=1e5 solver.method=adams"] {
        let p = cradle(4, &format!("{settings} solver.tolerance=1e-14"));
        let outputs = |change: f64| {
            let (run, _) = cut_step(&p, change);
            let means = (0..3).map(|i| run.force_mean(i)).chain([run.support_force_mean()]);
            let impulses = (0..3).map(|i| run.impulse(i)).chain([run.next_onset().time()]);
            (0..4).map(|i| run.x(i)).chain(means).chain(impulses).collect::<Vec<_>>()
        };
        let (run, history) = cut_step(&p, 0.0);
        let along = Inputs { force: vec![0.0, 0.0, 0.0, 1.0], ..Inputs::zero(4) };
        let of = run.sensitivity_of_step(&history, &along, true).unwrap();
        let exact = [of.x, of.force_mean, vec![of.support_force_mean], of.impulse, vec![of.next_onset]].concat();
        let tolerance = if settings.contains("adams") { 1e-4 } else { 1e-7 };
        let (differences, _) = by_differences(if settings.contains("adams") { 1e-3 } else { 1e-4 }, false, outputs);
        let size = exact.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        for (k, (exact, difference)) in exact.iter().zip(differences).enumerate() {
            assert!((exact - difference).abs() < tolerance * size, "{settings} {k}: {exact} {difference}");
        }
    }
}

/// A brake that changes at every millisecond, there and back.
#[test]
fn derivatives_of_a_run_with_parameters_changed_at_every_step() {
    for contact_model in [ContactModel::PowerLaw, ContactModel::Hertz] {
        let mut p = Parameters { contact_model, ..Parameters::default_for(3) };
        let mut simulation = Simulation::new(&p, &Inputs::zero(3), START).unwrap();
        let mut history = History::default();
        for k in 1..=1000 {
            simulation.advance(START + 1e-3 * f64::from(k), &mut Unrecorded).unwrap();
            simulation.keep_history(true, &mut history);
            p.drag = 0.01 * f64::from(k % 3);
            simulation.retune(&p.tunables()).unwrap();
        }
        simulation.advance(START + 1.1, &mut Unrecorded).unwrap();
        let tape = simulation.tape(&history).unwrap();
        let settings = Settings { parameters: p.clone(), ..Settings::default_for(3) };
        both_ways(&format!("{contact_model:?}"), &tape, &settings, 1e-12);
        let course = Course { simulation, history, parameters: p };
        // Linear forces do not depend on the reference overlap, and for the exponent the run is followed to 1e-3 only.
        for known in knowns(3).filter(|known| !["contact.overlapRef", "contact.exponent"].contains(&known.row.name)) {
            let along = unit(known, 3);
            let found = without_next_onset(&tape.along(&along.parameters, &along.inputs));
            let repeated = without_next_onset(&course.along(&along).unwrap());
            let size = repeated.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
            for (found, repeated) in found.iter().zip(repeated) {
                assert!((found - repeated).abs() <= 1e-8 * size, "{contact_model:?}, {known}: {found} {repeated}");
            }
        }
    }
}

#[test]
fn derivatives_of_a_run_refuse_another_course() {
    let settings = Settings::default_for(3);
    let Course { simulation, history, .. } = Course::new(&settings, 2.7);
    assert!(simulation.tape(&history).is_ok());
    assert_eq!(simulation.tape(&History::default()).err(), Some(Unfollowed::Another));
}

/// Rigid balls in touch share a force: of three equal ones each gets a third, through the contacts.
#[test]
fn derivatives_of_a_run_through_rigid_balls_in_touch() {
    let p = touching(3, "contact.model=rigid");
    let pressed = Inputs { force: vec![2.0, 0.0, -1.0], ..Inputs::zero(3) };
    let mut simulation = Simulation::new(&p, &pressed, 0.0).unwrap();
    simulation.advance(0.1, &mut Unrecorded).unwrap();
    let along = Inputs { force: vec![3.0, 0.0, 0.0], ..Inputs::zero(3) };
    let found = simulation.last_step().at_end_along_inputs(&along);
    for (found, expected) in found.a.iter().chain(&found.force).zip([1.0, 1.0, 1.0, 2.0, 1.0]) {
        assert!((found - expected).abs() < 1e-15, "{found} {expected}");
    }
}

/// One ball alone, on a line and on an arc.
#[test]
fn derivatives_of_a_run_of_one_ball() {
    for model in ["linear", "circular"] {
        let p = cradle(1, &format!("pendulum.model={model} x_start=0.3"));
        let run = |gravity: f64| {
            let mut simulation = Simulation::new(&Parameters { gravity, ..p.clone() }, &Inputs::zero(1), 0.0).unwrap();
            simulation.advance(1.3, &mut Unrecorded).unwrap();
            simulation
        };
        let along = Parameters { gravity: 1.0, ..Settings::zero(1).parameters };
        let found = run(p.gravity).tape(&History::default()).unwrap().along(&along, &Inputs::zero(1));
        let difference = (run(p.gravity + 1e-4).x(0) - run(p.gravity - 1e-4).x(0)) / 2e-4;
        assert!((found.x[0] - difference).abs() < 1e-7, "{model}: {} {difference}", found.x[0]);
    }
}

/// Linear contacts damped ten and a hundred times critically: fast decays within the first microseconds of a long step.
#[test]
fn derivatives_of_a_run_with_strongly_damped_impacts() {
    for (damping, model) in [(5e3, "linear"), (5e4, "linear"), (5e3, "circular")] {
        let contact = format!("contact.stiffness=1e5 contact.overlapRef=1 contact.damping={damping}");
        let p = cradle(2, &format!("{contact} pendulum.model={model} x_start=-0.1,0.001 v_start[1]=0.02"));
        let run = |v: f64| {
            let mut parameters = p.clone();
            parameters.v_start[0] += v;
            let mut simulation = Simulation::new(&parameters, &Inputs::zero(2), 0.0).unwrap();
            simulation.advance(1.4, &mut Unrecorded).unwrap();
            simulation
        };
        let mut along = Settings::zero(2).parameters;
        along.v_start[0] = 1.0;
        let found = run(0.0).tape(&History::default()).unwrap().along(&along, &Inputs::zero(2));
        let (before, after) = (run(-1e-6), run(1e-6));
        for i in 0..2 {
            let difference = (after.v(i) - before.v(i)) / 2e-6;
            assert!((found.v[i] - difference).abs() < 1e-6, "{damping} {model}: {} {difference}", found.v[i]);
        }
    }
}
