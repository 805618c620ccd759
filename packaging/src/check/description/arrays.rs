//! Variables and structure of FMI 3.0: what the standard allows to go together, which no schema can say.

use std::collections::{BTreeSet, HashMap, HashSet};

use super::model::{Array, Model};
use super::variables::is_structured;
use crate::check::report::Report;

/// Checks every variable by itself, all of them against each other, and ModelStructure.
pub fn check(model: &Model, report: &mut Report) {
    let mut names = HashSet::new();
    let mut by_reference: HashMap<u32, &Array> = HashMap::new();
    for array in &model.arrays {
        let name = &array.name;
        report.require(names.insert(name), format_args!("{name}: there are two variables of this name"));
        let well_named = !name.is_empty() && (!model.structured || is_structured(name));
        report
            .require(well_named, format_args!("{name}: not a valid name for variableNamingConvention=\"structured\""));
        if let Some(other) = by_reference.insert(array.reference, array) {
            report.problem(format_args!("{name} and {} share a value reference", other.name));
        }
        let known = array.declared_type.as_deref().is_none_or(|of| model.type_names.iter().any(|name| name == of));
        report.require(known, format_args!("{name}: its declaredType is not defined"));
        let unit = array.unit.as_ref().is_none_or(|unit| model.units.iter().any(|known| known.name == *unit));
        report.require(unit, format_args!("{name}: its unit is not defined"));
        start_value(model, array, report);
    }
    let independent = model.arrays.iter().filter(|array| array.causality == "independent").count();
    report.require(independent == 1, format_args!("there are {independent} independent variables; allowed: one"));
    for array in &model.arrays {
        for of in array.dimensions.iter().flatten() {
            let structural = by_reference.get(of).is_some_and(|of| of.causality == "structuralParameter");
            report.require(structural, format_args!("{}: is not sized by a structural parameter", array.name));
        }
        let clocks = array.clocks.iter().all(|clock| by_reference.get(clock).is_some_and(|of| of.element == "Clock"));
        report.require(clocks, format_args!("{}: belongs to a clock that is none", array.name));
    }
    structure(model, &by_reference, report);
}

fn start_value(model: &Model, array: &Array, report: &mut Report) {
    let Array { name, start, .. } = array;
    let set = matches!(array.causality.as_str(), "parameter" | "structuralParameter" | "input");
    let exact = matches!(array.initial.as_deref(), Some("exact" | "approx"));
    match start {
        None => report
            .require(!(set || exact) || array.element == "Clock", format_args!("{name}: the start value is missing")),
        Some(_) if array.initial.as_deref() == Some("calculated") || array.causality == "independent" => {
            report.problem(format_args!("{name}: is calculated, but has a start value"));
        }
        Some(start) if array.element.starts_with("Float") || array.element.contains("Int") => {
            let values: Vec<&str> = start.split_whitespace().collect();
            let numbers = values.iter().all(|value| value.parse::<f64>().is_ok());
            report.require(numbers, format_args!("{name}: start = \"{start}\"; allowed: numbers"));
            let (given, wanted) = (values.len(), model.elements(array));
            report.require(given == wanted, format_args!("{name}: {given} start value(s); allowed: {wanted}"));
        }
        Some(_) => {}
    }
}

fn structure(model: &Model, by_reference: &HashMap<u32, &Array>, report: &mut Report) {
    let name =
        |reference: u32| by_reference.get(&reference).map_or_else(|| reference.to_string(), |array| array.name.clone());
    let listed = |list: &str| -> BTreeSet<u32> {
        model.unknowns.iter().filter(|unknown| unknown.list == list).map(|unknown| unknown.reference).collect()
    };
    let wanted = |which: &dyn Fn(&Array) -> bool| -> BTreeSet<u32> {
        model.arrays.iter().filter(|array| which(array)).map(|array| array.reference).collect()
    };
    let is_output = |array: &Array| array.causality == "output";
    let outputs = wanted(&is_output);
    for missing in outputs.difference(&listed("Output")) {
        report.problem(format_args!("Output: {} is missing", name(*missing)));
    }
    for other in listed("Output").difference(&outputs) {
        report.problem(format_args!("Output: {} does not belong there", name(*other)));
    }
    let calculated = |array: &Array| {
        let initial =
            matches!(array.initial.as_deref(), None | Some("calculated" | "approx")) && array.variability != "constant";
        array.element != "Clock"
            && (array.causality == "calculatedParameter" || is_output(array) && initial && array.clocks.is_empty())
    };
    for missing in wanted(&calculated).difference(&listed("InitialUnknown")) {
        report.problem(format_args!("InitialUnknown: {} is missing", name(*missing)));
    }
    for unknown in &model.unknowns {
        let known = |reference: &u32| by_reference.contains_key(reference);
        let exists = known(&unknown.reference) && unknown.dependencies.iter().flatten().all(known);
        let (list, name) = (&unknown.list, name(unknown.reference));
        report.require(exists, format_args!("{list}: {name} is, or depends on, a variable that does not exist"));
    }
}
