//! The default experiment in model exchange with the `fmi` crate as the host: Euler's method, and its error alone.

mod support;

use fmi::EventFlags;
use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{Common, ModelExchange};
use newtons_cradle::variables::{START_TIME, Variable};

const BALLS: usize = 5;
const STATES: usize = 3 * BALLS + 1;
const STEP: f64 = 1e-3; // s
const STEPS: i32 = 10_000;

#[test]
fn euler_leaves_its_own_error() {
    let import: Fmi2Import = fmi::import::from_path(support::fmu()).unwrap();
    let mut instance = import.instantiate_me("cradle", false, true).unwrap();
    instance.setup_experiment(None, START_TIME, None).unwrap();
    instance.enter_initialization_mode().unwrap();
    instance.exit_initialization_mode().unwrap();
    let mut flags = EventFlags::default();
    let (mut y, mut rates) = (vec![0.0; STATES], vec![0.0; STATES]);
    instance.get_nominals_of_continuous_states(&mut y).unwrap();
    assert!(y.iter().all(|nominal| *nominal > 0.0));
    for k in 1..=STEPS {
        instance.new_discrete_states(&mut flags).unwrap();
        assert!(!flags.discrete_states_need_update && !flags.terminate_simulation);
        instance.enter_continuous_time_mode().unwrap();
        instance.get_continuous_states(&mut y).unwrap();
        instance.get_derivatives(&mut rates).unwrap();
        y.iter_mut().zip(&rates).for_each(|(y, rate)| *y += STEP * rate);
        instance.set_time(START_TIME + f64::from(k) * STEP).unwrap();
        instance.set_continuous_states(&y).unwrap();
        let (mut enter, mut terminate) = (false, false);
        instance.completed_integrator_step(true, &mut enter, &mut terminate).unwrap();
        instance.get_event_indicators(&mut [0.0; 2 * (BALLS - 1)]).unwrap();
        // An event with nothing due changes nothing: there may be one after every step.
        instance.enter_event_mode().unwrap();
    }
    instance.new_discrete_states(&mut flags).unwrap();
    let reference = |name: &str| Variable::named(name, BALLS).unwrap().reference();
    let (mut energy, mut pulses) = ([0.0], [0; BALLS - 1]);
    instance.get_real(&[reference("E_total")], &mut energy).unwrap();
    let all: Vec<u32> = (1..BALLS).map(|i| reference(&format!("pulses[{i}]"))).collect();
    instance.get_integer(&all, &mut pulses).unwrap();
    assert_eq!(pulses, [7, 14, 14, 7]);
    let expected = 0.05 * (1.0 + 5.0 * STEP * STEP).powi(STEPS);
    assert!((energy[0] / expected - 1.0).abs() < 1e-11, "{} {expected}", energy[0]);
    instance.terminate().unwrap();
}
