//! Units and types, and ModelStructure: that its lists have exactly what they must.

use std::collections::BTreeSet;

use fmi_schema::fmi2::{Causality, Initial};
use newtons_cradle::variables::Type;

use super::model::{Model, Unknown, Variable};
use crate::check::report::Report;

/// Checks the definitions and the structure.
pub fn check(model: &Model, report: &mut Report) {
    report.duplicates("unit", model.units.iter().map(|unit| &unit.name));
    report.duplicates("type", model.types.iter().map(|kind| &kind.name));
    for kind in &model.types {
        let attributes = &kind.attributes;
        let empty = attributes.data_type == Type::Enumeration && attributes.items.is_empty();
        report.require(!empty, format_args!("{}: an enumeration without items", kind.name));
        report.duplicates(&format!("item of {}", kind.name), attributes.items.iter());
    }
    let structure = &model.structure;
    let none = Vec::new();
    let outputs = structure.outputs.as_ref().unwrap_or(&none);
    let derivatives = structure.derivatives.as_ref().unwrap_or(&none);
    let initial = structure.initial_unknowns.as_ref().unwrap_or(&none);
    exactly("Outputs", outputs, indices(model, |variable| variable.causality == Causality::Output), model, report);
    if structure.derivatives.is_some() {
        let wanted = indices(model, |variable| variable.attributes.derivative.is_some());
        exactly("Derivatives", derivatives, wanted, model, report);
    }
    let state = |unknown: &Unknown| variable(model, unknown.index).and_then(|variable| variable.attributes.derivative);
    let states: BTreeSet<usize> =
        derivatives.iter().flat_map(|unknown| [Some(unknown.index), state(unknown)]).flatten().collect();
    let mut wanted = indices(model, |variable| variable.causality == Causality::CalculatedParameter);
    let unknown_at_start = |index: &usize| {
        let initial = variable(model, *index).and_then(Variable::initial_or_default);
        matches!(initial, Some(Initial::Approx | Initial::Calculated))
    };
    let outputs = indices(model, |variable| variable.causality == Causality::Output);
    wanted.extend(outputs.into_iter().chain(states).filter(unknown_at_start));
    exactly("InitialUnknowns", initial, wanted, model, report);
}

fn variable(model: &Model, index: usize) -> Option<&Variable> {
    model.variables.get(index.checked_sub(1)?)
}

/// One-based indices of the variables that `wanted` holds for.
fn indices(model: &Model, wanted: impl Fn(&Variable) -> bool) -> BTreeSet<usize> {
    model.variables.iter().enumerate().filter(|(_, variable)| wanted(variable)).map(|(index, _)| index + 1).collect()
}

/// Whether a list has the unknowns it must have, each with dependencies that exist.
fn exactly(list: &str, unknowns: &[Unknown], wanted: BTreeSet<usize>, model: &Model, report: &mut Report) {
    let name = |index: usize| variable(model, index).map_or_else(|| format!("index {index}"), |v| v.name.clone());
    let listed: BTreeSet<usize> = unknowns.iter().map(|unknown| unknown.index).collect();
    for index in wanted.difference(&listed) {
        report.problem(format_args!("{list}: {} is missing", name(*index)));
    }
    for index in listed.difference(&wanted) {
        report.problem(format_args!("{list}: {} does not belong there", name(*index)));
    }
    report.require(listed.len() == unknowns.len(), format_args!("{list}: an unknown is listed twice"));
    for unknown in unknowns {
        let dependencies = unknown.dependencies.as_deref().unwrap_or_default();
        let name = name(unknown.index);
        let exist = dependencies.iter().all(|index| variable(model, *index).is_some());
        report.require(exist, format_args!("{list}: {name} depends on a variable that does not exist"));
        let fit = unknown.kinds.is_none_or(|kinds| unknown.dependencies.is_some() && kinds == dependencies.len());
        report.require(fit, format_args!("{list}: {name} does not have one dependenciesKind for each dependency"));
    }
}
