//! The default experiment with the `fmi` crate as the host: it reads the same doubles as a run without an FMU.

mod support;

use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common};
use fmi::schema::fmi2::{Causality, ScalarVariableElement};
use fmi::traits::FmiImport;
use newtons_cradle::engine::{Engine, Results};
use newtons_cradle::variables::{START_TIME, STEP_SIZE, STOP_TIME, Settings};

#[test]
fn the_default_experiment_gives_the_same_doubles() {
    let import: Fmi2Import = fmi::import::from_path(support::fmu()).unwrap();
    let description = import.model_description();
    let experiment = description.default_experiment.as_ref().unwrap();
    let (start, stop) = (experiment.start_time.unwrap(), experiment.stop_time.unwrap());
    let step = experiment.step_size.unwrap();
    assert_eq!((start, stop, step), (START_TIME, STOP_TIME, STEP_SIZE));

    // Every real output, in the order of the description.
    let outputs = description.get_model_variables().filter(|variable| {
        variable.causality == Causality::Output && matches!(variable.elem, ScalarVariableElement::Real(_))
    });
    let (names, references): (Vec<&str>, Vec<u32>) =
        outputs.map(|variable| (variable.name.as_str(), variable.value_reference)).unzip();

    let mut instance = import.instantiate_cs("cradle", false, true).unwrap();
    assert_eq!((instance.get_version(), instance.get_types_platform()), ("2.0", "default"));
    instance.setup_experiment(None, start, Some(stop)).unwrap();
    instance.enter_initialization_mode().unwrap();
    instance.exit_initialization_mode().unwrap();

    let settings = Settings::default_for(5);
    let mut engine = Engine::new(&settings.parameters, &settings.inputs, start).unwrap();
    let mut values = vec![f64::NAN; references.len()];
    let steps = ((stop - start) / step).round() as usize;
    for i in 0..steps {
        let time = start + i as f64 * step;
        instance.do_step(time, step, true).unwrap();
        engine.advance(time + step, &mut Vec::new()).unwrap();
        instance.get_real(&references, &mut values).unwrap();
        for (name, value) in names.iter().zip(&values) {
            if let Some(expected) = expected(&engine, name) {
                assert_eq!(value.to_bits(), expected.to_bits(), "{name} at t = {}", time + step);
            }
        }
    }
    let pulses: Vec<usize> = (0..4).map(|i| engine.pulses(i) as usize).collect();
    assert_eq!(pulses.iter().sum::<usize>(), 42);
    assert!(instance.get_real(&[u32::MAX], &mut [0.0]).is_err());
    assert!((instance.last_successful_time().unwrap() - stop).abs() < 1e-12);
    instance.terminate().unwrap();
}

/// The value of an output without the FMU around it.
fn expected(engine: &Engine, name: &str) -> Option<f64> {
    let (family, index) = match name.strip_suffix(']').and_then(|name| name.split_once('[')) {
        Some((family, index)) => (family, index.parse::<usize>().unwrap() - 1),
        None => (name, 0),
    };
    Some(match family {
        "x" => engine.x(index),
        "v" => engine.v(index),
        "F" => engine.force(index),
        "impulse" => engine.impulse(index),
        "F_mean" => engine.force_mean(index),
        "F_peak" => engine.force_peak(index),
        "E_total" => engine.total_energy(),
        "p_total" => engine.momentum(),
        "F_support" => engine.support_force(),
        "F_support_mean" => engine.support_force_mean(),
        "t_next" => engine.next_onset().time(),
        _ => return None,
    })
}
