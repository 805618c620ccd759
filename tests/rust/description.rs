//! The description, read by somebody else's code, against the table and the rules of the standard.

use std::collections::{HashMap, HashSet};

use fmi_schema::fmi2::{self, Causality, Fmi2ModelDescription, Initial, ScalarVariableElement, Variability};
use fmi_schema::traits::FmiModelDescription;
use newtons_cradle::variables::{Description, MODEL_IDENTIFIER, Settings, TABLE, Type, Variable, states, variables};

fn xml(balls: usize) -> String {
    Description::of(&Settings::default_for(balls)).xml("2000-01-01T00:00:00Z")
}

fn read(xml: &str) -> Fmi2ModelDescription {
    Fmi2ModelDescription::deserialize(xml).unwrap()
}

/// Attributes of the value elements, which `fmi-schema` does not read, by variable.
fn attributes(xml: &str) -> HashMap<String, HashMap<String, String>> {
    let of = |line: &str| -> HashMap<String, String> {
        let pieces: Vec<&str> = line.split('"').collect();
        let key = |text: &str| text.trim().trim_end_matches('=').rsplit(' ').next().unwrap().to_owned();
        pieces.chunks_exact(2).map(|pair| (key(pair[0]), pair[1].to_owned())).collect()
    };
    let lines: Vec<&str> = xml.lines().collect();
    let starts = lines.windows(2).filter(|pair| pair[0].trim_start().starts_with("<ScalarVariable "));
    starts.map(|pair| (of(pair[0])["name"].clone(), of(pair[1]))).collect()
}

#[test]
fn the_description_is_the_table() {
    for balls in [1, 2, 5, 13, 100] {
        let description = read(&xml(balls));
        let described = &description.model_variables.variables;
        assert_eq!(described.len(), variables(balls).count());
        for (described, variable) in described.iter().zip(variables(balls)) {
            assert_eq!((&described.name, described.value_reference), (&variable.to_string(), variable.reference()));
            assert_eq!(
                described.causality.to_string().to_lowercase(),
                format!("{:?}", variable.row.causality).to_lowercase()
            );
            let variability = described.variability.unwrap().to_string();
            assert_eq!(variability, format!("{:?}", variable.row.variability).to_lowercase());
            let actual = match described.elem {
                ScalarVariableElement::Real(_) => Type::Real,
                ScalarVariableElement::Integer(_) => Type::Integer,
                ScalarVariableElement::Boolean(_) => Type::Boolean,
                ScalarVariableElement::Enumeration => Type::Enumeration,
                ScalarVariableElement::String => Type::String,
            };
            assert_eq!(actual, variable.row.access.data_type());
            assert!(!described.description.as_ref().unwrap().contains(['{', '}']));
        }
    }
}

#[test]
fn causality_variability_and_initial_go_together() {
    for variable in read(&xml(5)).model_variables.variables {
        let real = matches!(variable.elem, ScalarVariableElement::Real(_));
        let variability = variable.variability.unwrap();
        let fits = match variable.causality {
            Causality::Parameter => {
                matches!(variability, Variability::Fixed | Variability::Tunable)
                    && variable.initial == Some(Initial::Exact)
            }
            Causality::CalculatedParameter => {
                variability == Variability::Fixed && variable.initial == Some(Initial::Calculated)
            }
            Causality::Input => variability == Variability::Continuous && variable.initial.is_none(),
            Causality::Output | Causality::Local => {
                matches!(variability, Variability::Discrete | Variability::Continuous)
                    && variable.initial == Some(Initial::Calculated)
            }
            Causality::Independent => false,
        };
        assert!(fits && (real || variability != Variability::Continuous), "{}", variable.name);
    }
}

#[test]
fn start_values_are_there_and_in_range() {
    for balls in [1, 2, 5] {
        for (name, attributes) in attributes(&xml(balls)) {
            let number = |key: &str| attributes.get(key).map(|text| text.parse::<f64>().unwrap());
            let variable = Variable::named(&name, balls).unwrap();
            assert_eq!(number("start").is_some(), variable.row.settable(), "{name}");
            if let Some(start) = number("start") {
                assert!(
                    start >= number("min").unwrap_or(f64::MIN) && start <= number("max").unwrap_or(f64::MAX),
                    "{name}"
                );
            }
            assert!(number("nominal").is_none_or(|nominal| nominal > 0.0), "{name}");
        }
    }
}

#[test]
fn every_unit_and_type_is_defined_once() {
    let text = xml(5);
    let description = read(&text);
    let units: Vec<String> = description.unit_definitions.unwrap().units.into_iter().map(|unit| unit.name).collect();
    let types: Vec<String> = description.type_definitions.unwrap().types.into_iter().map(|kind| kind.name).collect();
    let names: HashSet<String> =
        description.model_variables.variables.into_iter().map(|variable| variable.name).collect();
    for list in [&units, &types] {
        assert_eq!(list.iter().collect::<HashSet<_>>().len(), list.len());
    }
    assert!(types.iter().all(|name| !names.contains(name)));
    for (name, attributes) in attributes(&text) {
        assert!(attributes.get("unit").is_none_or(|unit| units.contains(unit)), "{name}");
        assert!(attributes.get("declaredType").is_none_or(|kind| types.contains(kind)), "{name}");
    }
}

#[test]
fn units_have_the_right_base_units() {
    let units = read(&xml(5)).unit_definitions.unwrap().units;
    let exponents = |name: &str| {
        let unit: &fmi2::Fmi2Unit = units.iter().find(|unit| unit.name == name).expect(name);
        let base = unit.base_unit.as_ref().unwrap();
        assert!(base.factor.is_none() && base.offset.is_none() && unit.display_unit.is_empty());
        [base.kg, base.m, base.s].map(Option::unwrap_or_default)
    };
    for (name, expected) in [
        ("1", [0, 0, 0]),
        ("kg.m/s", [1, 1, -1]),
        ("N.s", [1, 1, -1]),
        ("N.s/m", [1, 0, -1]),
        ("kg/s", [1, 0, -1]),
        ("s/m", [0, -1, 1]),
        ("N", [1, 1, -2]),
        ("N/m", [1, 0, -2]),
        ("J", [1, 2, -2]),
        ("W", [1, 2, -3]),
        ("Pa", [1, -1, -2]),
        ("m/s2", [0, 1, -2]),
    ] {
        assert_eq!(exponents(name), expected, "{name}");
    }
}

#[test]
fn the_structure_lists_what_the_standard_asks_for() {
    for balls in [1, 2, 5, 13] {
        let description = read(&xml(balls));
        let all = &description.model_variables.variables;
        let indices = |wanted: &[Causality]| -> Vec<u32> {
            let matching = all.iter().enumerate().filter(|(_, variable)| wanted.contains(&variable.causality));
            matching.map(|(position, _)| position as u32 + 1).collect()
        };
        let position = |name: &str| all.iter().position(|variable| variable.name == name).unwrap() as u32 + 1;
        let structure = &description.model_structure;
        let outputs: Vec<u32> = structure.outputs.unknowns.iter().map(|unknown| unknown.index).collect();
        assert_eq!(outputs, indices(&[Causality::Output]));
        // In co-simulation nothing feeds through: outputs depend on states, not on inputs.
        let states: Vec<u32> = states(balls).map(|(state, _)| position(&state.to_string())).collect();
        let of_states =
            |unknown: &fmi2::Fmi2VariableDependency| unknown.dependencies.iter().all(|one| states.contains(one));
        assert!(structure.outputs.unknowns.iter().all(of_states));
        let initial: Vec<u32> = structure.initial_unknowns.unknowns.iter().map(|unknown| unknown.index).collect();
        let exchanged = newtons_cradle::variables::states(balls).flat_map(|(state, rate)| [state, rate]);
        let mut expected = indices(&[Causality::Output, Causality::CalculatedParameter]);
        expected.extend(exchanged.map(|variable| position(&variable.to_string())));
        expected.sort_unstable();
        expected.dedup();
        assert_eq!(initial, expected);
        for unknown in &structure.initial_unknowns.unknowns {
            assert!(unknown.dependencies.is_sorted());
            let settable =
                |index: &u32| matches!(all[*index as usize - 1].causality, Causality::Parameter | Causality::Input);
            assert!(unknown.dependencies.iter().all(settable), "{}", all[unknown.index as usize - 1].name);
        }
    }
}

#[test]
fn outputs_come_in_the_order_of_the_interface() {
    let families = [
        "x",
        "F",
        "v",
        "E_total",
        "p_total",
        "F_support",
        "t_next",
        "impulse",
        "F_mean",
        "F_peak",
        "F_support_mean",
        "pulses",
        "inContact",
    ];
    let outputs: Vec<&str> = TABLE
        .iter()
        .filter(|row| row.causality == newtons_cradle::variables::Causality::Output)
        .map(|row| row.name)
        .collect();
    assert_eq!(outputs, families);
}

#[test]
fn attributes_of_the_model_are_those_of_the_interface() {
    let text = xml(5);
    let description = read(&text);
    assert_eq!((description.fmi_version.as_str(), description.model_name.as_str()), ("2.0", MODEL_IDENTIFIER));
    assert_eq!(description.version.as_deref(), Some(env!("CARGO_PKG_VERSION")));
    assert_eq!(description.variable_naming_convention.as_deref(), Some("structured"));
    let experiment = description.default_experiment.unwrap();
    assert_eq!((experiment.start_time, experiment.stop_time), (Some(0.0), Some(10.0)));
    assert_eq!((experiment.step_size, experiment.tolerance), (Some(0.01), None));
    let categories: Vec<String> = description.log_categories.unwrap().categories.into_iter().map(|c| c.name).collect();
    assert_eq!(categories, ["logEvents", "logSolver", "logStatusWarning", "logStatusError"]);
    assert_eq!(description.model_exchange.unwrap().model_identifier, MODEL_IDENTIFIER);
    assert_eq!(description.co_simulation.unwrap().model_identifier, MODEL_IDENTIFIER);
    assert!(text.contains("numberOfEventIndicators=\"8\""));
    // Every state may jump in an event.
    let jumps = attributes(&text).into_iter().filter(|(_, attributes)| attributes.contains_key("reinit")).count();
    assert_eq!(jumps, states(5).count());
    assert!(
        text.contains("name=\"contact.model\"")
            && text.contains("<Enumeration declaredType=\"ContactModel\" start=\"1\"/>")
    );
}
