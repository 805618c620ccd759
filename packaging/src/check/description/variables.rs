//! The variables: what the standard allows to go together, which no schema can say.

use std::collections::{HashMap, HashSet};

use fmi_schema::fmi2::{Causality, Initial, Variability};
use newtons_cradle::variables::Type;

use super::model::{Attributes, Model, Variable};
use crate::check::report::Report;

/// Longer names are cut or refused by some hosts.
const LONG_NAME: usize = 200;

/// Checks every variable by itself, and all of them against each other.
pub fn check(model: &Model, report: &mut Report) {
    let mut names = HashSet::new();
    let mut references: HashMap<(Type, u32), &Variable> = HashMap::new();
    for variable in &model.variables {
        let name = &variable.name;
        report.require(names.insert(name), format_args!("{name}: there are two variables of this name"));
        let well_named = !name.is_empty() && (!model.structured || is_structured(name));
        report
            .require(well_named, format_args!("{name}: not a valid name for variableNamingConvention=\"structured\""));
        report.advise(name.len() <= LONG_NAME, format_args!("{name}: a name of {} bytes", name.len()));
        combination(variable, report);
        value(model, variable, report);
        // Integers and enumerations are read and set by the same functions.
        let data_type = match variable.attributes.data_type {
            Type::Enumeration => Type::Integer,
            other => other,
        };
        if let Some(first) = references.insert((data_type, variable.reference), variable)
            && settable(first)
            && settable(variable)
        {
            report.problem(format_args!("{} and {name} can both be set and share a value reference", first.name));
        }
    }
}

fn settable(variable: &Variable) -> bool {
    matches!(variable.causality, Causality::Parameter | Causality::Input)
}

/// Whether causality, variability, `initial` and start value go together (FMI 2.0.3, section 2.2.7).
fn combination(variable: &Variable, report: &mut Report) {
    use Initial::{Approx, Calculated, Exact};
    use Variability::{Constant, Continuous, Discrete, Fixed, Tunable};
    let Variable { name, causality, variability, initial, attributes, .. } = variable;
    // The default of `initial` comes first; none where it must not be given.
    let allowed: Option<&[Initial]> = match (causality, variability) {
        (Causality::Parameter, Fixed | Tunable) => Some(&[Exact]),
        (Causality::CalculatedParameter, Fixed | Tunable) => Some(&[Calculated, Approx]),
        (Causality::Input, Discrete | Continuous) | (Causality::Independent, Continuous) => Some(&[]),
        (Causality::Output | Causality::Local, Constant) => Some(&[Exact]),
        (Causality::Output | Causality::Local, Discrete | Continuous) => Some(&[Calculated, Exact, Approx]),
        (Causality::Local, Fixed | Tunable) => Some(&[Calculated, Approx]),
        _ => None,
    };
    let Some(allowed) = allowed else {
        return report
            .problem(format_args!("{name}: causality {causality} and variability {variability} exclude each other"));
    };
    let kind = attributes.data_type;
    let may_change = *variability != Continuous || kind == Type::Real;
    report.require(may_change, format_args!("{name}: {kind:?} and variability continuous exclude each other"));
    if let Some(initial) = initial {
        let text = format_args!("{name}: initial {initial} is not allowed for causality {causality}");
        report.require(allowed.contains(initial), text);
    }
    let wanted = match variable.initial_or_default() {
        Some(initial) => initial != Calculated,
        None => *causality == Causality::Input,
    };
    match (&attributes.start, wanted) {
        (None, true) => report.problem(format_args!("{name}: the start value is missing")),
        (Some(_), false) => report.problem(format_args!("{name}: is calculated, but has a start value")),
        _ => {}
    }
}

/// Declared type, units, limits and start value.
fn value(model: &Model, variable: &Variable, report: &mut Report) {
    let Variable { name, attributes, .. } = variable;
    let declared = match &attributes.declared_type {
        None => None,
        Some(declared) => match model.types.iter().find(|kind| kind.name == *declared) {
            Some(found) if found.attributes.data_type == attributes.data_type => Some(&found.attributes),
            _ => {
                let kind = attributes.data_type;
                return report.problem(format_args!("{name}: declaredType {declared} is not a type of {kind:?}"));
            }
        },
    };
    let effective = inherit(attributes, declared);
    let typed = effective.data_type != Type::Enumeration || declared.is_some();
    report.require(typed, format_args!("{name}: an enumeration without declaredType"));
    let unit = effective.unit.as_ref().map(|unit| (unit, model.units.iter().find(|known| known.name == *unit)));
    if let Some((unit, None)) = unit {
        report.problem(format_args!("{name}: unit {unit} is not defined"));
    }
    if let Some(display) = &effective.display_unit
        && !unit.is_some_and(|(_, unit)| unit.is_none_or(|unit| unit.display.contains(display)))
    {
        report.problem(format_args!("{name}: displayUnit {display} is not defined for its unit"));
    }
    let not_positive = effective.nominal.is_some_and(|nominal| nominal <= 0.0);
    report.require(!not_positive, format_args!("{name}: nominal is not positive"));
    if let (Some(min), Some(max)) = (effective.min, effective.max) {
        let crossed = min > max;
        report.require(!crossed, format_args!("{name}: min = {min} is above max = {max}"));
    }
    if let Some(index) = effective.derivative
        && model.variables.get(index.wrapping_sub(1)).is_none_or(|state| state.attributes.data_type != Type::Real)
    {
        report.problem(format_args!("{name}: derivative = {index} is not the index of a real variable"));
    }
    if let Some(start) = &effective.start {
        start_value(name, start, &effective, report);
    }
}

fn start_value(name: &str, start: &str, attributes: &Attributes, report: &mut Report) {
    let mut refused = |allowed: &str| report.problem(format_args!("{name}: start = \"{start}\"; allowed: {allowed}"));
    let number = match attributes.data_type {
        Type::String => return,
        Type::Boolean if matches!(start, "true" | "false" | "1" | "0") => return,
        Type::Boolean => return refused("true, false"),
        Type::Real => start.trim().parse::<f64>().ok(),
        Type::Integer | Type::Enumeration => start.trim().parse::<i32>().ok().map(f64::from),
    };
    let Some(number) = number else { return refused("a number") };
    let (min, max) = (attributes.min.unwrap_or(f64::NEG_INFINITY), attributes.max.unwrap_or(f64::INFINITY));
    if number < min || number > max {
        refused(&format!("{min} to {max}"));
    }
    if attributes.data_type == Type::Enumeration && !attributes.items.iter().any(|item| f64::from(*item) == number) {
        refused("an item of its type");
    }
}

/// The attributes of a variable, with those of its type where it has none.
fn inherit(own: &Attributes, declared: Option<&Attributes>) -> Attributes {
    let mut attributes = own.clone();
    if let Some(declared) = declared.cloned() {
        attributes.unit = attributes.unit.or(declared.unit);
        attributes.display_unit = attributes.display_unit.or(declared.display_unit);
        attributes.min = attributes.min.or(declared.min);
        attributes.max = attributes.max.or(declared.max);
        attributes.nominal = attributes.nominal.or(declared.nominal);
        attributes.items = declared.items;
    }
    attributes
}

/// Whether a name is one of the naming convention: identifiers and quoted names separated by dots, each with indices, or the
/// derivative `der(name,order)` of one (FMI 2.0.3, section 2.2.9).
pub(super) fn is_structured(name: &str) -> bool {
    if let Some(inner) = name.strip_prefix("der(") {
        let Some(inner) = inner.strip_suffix(')') else { return false };
        return match inner.rsplit_once(',') {
            Some((inner, order)) if is_index(order) => is_structured(inner),
            _ => is_structured(inner),
        };
    }
    let mut rest = name;
    loop {
        let Some(after) = element(rest) else { return false };
        match after.strip_prefix('.') {
            Some(next) => rest = next,
            None => return after.is_empty(),
        }
    }
}

/// What follows the first element of a structured name.
fn element(name: &str) -> Option<&str> {
    let length = match name.strip_prefix('\'') {
        Some(quoted) => quoted.find('\'')? + 2,
        None => name.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(name.len()),
    };
    let (identifier, rest) = name.split_at(length);
    if identifier.is_empty() || identifier.starts_with(|c: char| c.is_ascii_digit()) {
        return None;
    }
    match rest.strip_prefix('[') {
        None => Some(rest),
        Some(indices) => {
            let (indices, rest) = indices.split_once(']')?;
            indices.split(',').map(str::trim).all(is_index).then_some(rest)
        }
    }
}

fn is_index(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn structured_names_are_those_of_the_standard() {
        for name in ["x", "a.b", "x[1]", "a_1[2,3].b", "der(x)", "der(a.b[1],2)", "'any thing'.x", "_x"] {
            assert!(is_structured(name), "{name}");
        }
        for name in ["", "1x", "a..b", "a.", ".a", "x[", "x[]", "x[a]", "der(x", "a b", "x]", "'open"] {
            assert!(!is_structured(name), "{name}");
        }
    }
}
