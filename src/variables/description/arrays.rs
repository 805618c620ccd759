//! What the description of FMI 3.0 says in its own way: types, variables and structure.

use std::fmt::{self, Write};

use crate::variables::arrays::{Array, ArrayType, DERIVATIVES_OF, Extra, MAX_LOG};
use crate::variables::settings::Settings;
use crate::variables::table::TABLE;
use crate::variables::table::enumeration::{ENUMERATIONS, Item};
use crate::variables::table::row::{Access, Causality, Groups, Row, Shape};
use crate::variables::table::unit::QUANTITIES;
use crate::variables::text::{Escaped, Number, camel};
use crate::variables::variable::{MAX_BALLS, MIN_BALLS, Variable};

/// Name of the type of `derivatives.of`.
const DERIVATIVES_TYPE: &str = "DerivativesOf";

/// What is continued to foresee the next onset.
const INPUTS: Groups = &[&["F_ext", "a_support"]];
/// What `der(q)` depends on.
const RATE: Groups = &[&["v"]];
/// What the force of a rigid contact depends on, and the indicators of such contacts: the host may select them.
const EVERYTHING: Groups = &[&["q", "v", "F_ext", "a_support"]];
/// What `q` and `der(q)` depend on at the start.
const POSITION_AT_START: Groups = &[&["contact.deadBand", "contact.gap", "x_start"]];
const RATE_AT_START: Groups = &[&["v_start"]];

/// Writes the type definitions.
pub(super) fn write_types(out: &mut String) -> fmt::Result {
    for quantity in QUANTITIES {
        let (name, unit) = (quantity.name, quantity.unit);
        writeln!(out, "    <Float64Type name=\"{name}\" quantity=\"{name}\" unit=\"{unit}\"/>")?;
    }
    let enumerations = ENUMERATIONS.iter().map(|enumeration| (enumeration.type_name, enumeration.items));
    for (name, items) in enumerations.chain([(DERIVATIVES_TYPE, DERIVATIVES_OF)]) {
        writeln!(out, "    <EnumerationType name=\"{name}\">")?;
        for Item { name, value, description } in items {
            let description = Escaped(description);
            writeln!(out, "      <Item name=\"{name}\" value=\"{value}\" description=\"{description}\"/>")?;
        }
        writeln!(out, "    </EnumerationType>")?;
    }
    Ok(())
}

/// Writes every variable.
pub(super) fn write_variables(
    out: &mut String,
    start: &Settings,
    mut arrays: impl Iterator<Item = Array>,
) -> fmt::Result {
    arrays.try_for_each(|array| write_variable(out, start, array))
}

fn write_variable(out: &mut String, start: &Settings, array: Array) -> fmt::Result {
    let element = array.data_type();
    let causality = match (array, array.causality()) {
        (Array::Extra(Extra::Time), _) => "independent".to_owned(),
        (Array::Extra(Extra::Balls), _) => "structuralParameter".to_owned(),
        (_, causality) => causality.map_or_else(String::new, |causality| camel(&causality)),
    };
    let variability = camel(&array.variability());
    write!(out, "    <{element:?} name=\"{array}\" valueReference=\"{}\"", array.reference())?;
    write!(out, " causality=\"{causality}\" variability=\"{variability}\"")?;
    if let Some(clock) = array.clock() {
        write!(out, " clocks=\"{}\"", clock.reference())?;
    }
    if array.is_intermediate() {
        out.write_str(" intermediateUpdate=\"true\"")?;
    }
    let row = array.row();
    let calculated = row.map_or(array.causality() == Some(Causality::Local), |row| !row.settable());
    match array.causality() {
        Some(Causality::Parameter) => out.write_str(" initial=\"exact\"")?,
        Some(_) if calculated => out.write_str(" initial=\"calculated\"")?,
        _ => {}
    }
    write!(out, " description=\"{}", Escaped(&array.description()))?;
    if row.is_some_and(|row| row.range.above_min && row.settable()) {
        out.write_str("; 0 itself is refused")?;
    }
    if array.shape() == Shape::Contacts {
        out.write_str("; the last element belongs to no contact")?;
    }
    out.write_str("\"")?;
    write_element(out, array, row)?;
    write_exchange(out, array)?;
    write_start(out, start, array)?;
    match (element, array.is_array()) {
        (_, true) => {
            writeln!(out, "><Dimension valueReference=\"{}\"/></{element:?}>", Array::Extra(Extra::Balls).reference())
        }
        _ => out.write_str("/>\n"),
    }
}

/// Declared type, which has the unit, and range. The reader `fmi-schema` knows no unit and no nominal value of a
/// variable.
fn write_element(out: &mut String, array: Array, row: Option<&Row>) -> fmt::Result {
    if let Some(quantity) = array.quantity() {
        write!(out, " declaredType=\"{}\"", quantity.name)?;
    }
    match (array, row.map(|row| row.access)) {
        (Array::Extra(Extra::DerivativesOf), _) => write!(out, " declaredType=\"{DERIVATIVES_TYPE}\"")?,
        (Array::Extra(Extra::Balls), _) => write!(out, " min=\"{MIN_BALLS}\" max=\"{MAX_BALLS}\"")?,
        (Array::Extra(Extra::Pulses), _) => write!(out, " mimeType=\"text/csv\" maxSize=\"{MAX_LOG}\"")?,
        (Array::Extra(Extra::OnsetClock | Extra::ReleaseClock), _) => {
            out.write_str(" intervalVariability=\"triggered\"")?
        }
        (_, Some(Access::Enumeration(enumeration))) => write!(out, " declaredType=\"{}\"", enumeration.type_name)?,
        _ => {}
    }
    if let Some(row) = row {
        for (name, value) in [("min", row.range.min), ("max", row.range.max)] {
            if let Some(value) = value {
                write!(out, " {name}=\"{}\"", Number(value))?;
            }
        }
    }
    Ok(())
}

/// What the variable is to model exchange.
fn write_exchange(out: &mut String, array: Array) -> fmt::Result {
    for (state, derivative) in Array::states() {
        if derivative == array {
            write!(out, " derivative=\"{}\"", state.reference())?;
        }
        if state == array {
            out.write_str(" reinit=\"true\"")?;
        }
    }
    Ok(())
}

/// The start values: those of the settings, and the default for the last element of an array over contacts.
fn write_start(out: &mut String, start: &Settings, array: Array) -> fmt::Result {
    let balls = start.balls();
    match array {
        Array::Extra(Extra::Balls) => write!(out, " start=\"{balls}\""),
        Array::Extra(Extra::DerivativesOf) => write!(out, " start=\"{}\"", DERIVATIVES_OF[0].value),
        Array::Slope(_) => {
            write!(out, " start=\"{}\"", vec!["0"; array.len(balls)].join(" "))
        }
        Array::Row(position) if TABLE[position].settable() => {
            let row = &TABLE[position];
            let text = |index: usize| {
                let variable = Variable { row, position, index };
                match (variable.real(start), variable.item(start)) {
                    (Some(value), _) => Number(value).to_string(),
                    (_, Some(value)) => value.to_string(),
                    _ => Number(padding(row)).to_string(),
                }
            };
            let values: Vec<String> = (0..array.len(balls)).map(text).collect();
            write!(out, " start=\"{}\"", values.join(" "))
        }
        _ => Ok(()),
    }
}

/// The default of a parameter over contacts, for the element that belongs to none.
pub fn padding(row: &Row) -> f64 {
    let default = Settings::default_for(2);
    if let Access::Parameter { get, .. } = row.access {
        get(&default.parameters).first().copied().unwrap_or(0.0)
    } else {
        0.0
    }
}

/// Writes ModelStructure. In co-simulation an input acts from now on: what it changes at once is what is foreseen, and
/// the force of rigid balls that stay in contact. In model exchange outputs and derivatives depend on states and
/// inputs.
pub(super) fn write_structure(out: &mut String, arrays: impl Iterator<Item = Array> + Clone) -> fmt::Result {
    for array in arrays.clone().filter(|array| array.causality() == Some(Causality::Output)) {
        write!(out, "    <Output valueReference=\"{}\"", array.reference())?;
        write_dependencies(out, following(array))?;
    }
    for (_, derivative) in Array::states() {
        write!(out, "    <ContinuousStateDerivative valueReference=\"{}\"", derivative.reference())?;
        write_dependencies(out, following(derivative))?;
    }
    let exchanged: Vec<Array> = Array::states().flat_map(|(state, derivative)| [state, derivative]).collect();
    let unknown = |row: &Row| matches!(row.causality, Causality::Output | Causality::CalculatedParameter);
    for array in arrays {
        // By the letter clocks have no `initial`; FMPy takes them for calculated outputs.
        if array.data_type() == ArrayType::Clock {
            writeln!(out, "    <InitialUnknown valueReference=\"{}\" dependencies=\"\"/>", array.reference())?;
        }
        let initially = match array {
            Array::Extra(Extra::Positions) => Some(POSITION_AT_START),
            Array::Extra(Extra::Rates) => Some(RATE_AT_START),
            _ => array.row().and_then(|row| row.initially),
        };
        if array.row().is_some_and(unknown) || exchanged.contains(&array) {
            write!(out, "    <InitialUnknown valueReference=\"{}\"", array.reference())?;
            match initially {
                Some(groups) => write_dependencies(out, groups)?,
                None => out.write_str("/>\n")?,
            }
        }
    }
    for indicators in [Extra::ContactIndicators, Extra::ClipIndicators] {
        write!(out, "    <EventIndicator valueReference=\"{}\"", Array::Extra(indicators).reference())?;
        write_dependencies(out, EVERYTHING)?;
    }
    Ok(())
}

/// What an output or a derivative depends on at the same time: states and inputs.
fn following(array: Array) -> Groups {
    match (array, array.row()) {
        (Array::Extra(Extra::Rates), _) => RATE,
        (_, Some(row)) if row.name == "t_next" => INPUTS,
        (_, Some(row)) if matches!(row.name, "F" | "F_mean" | "a" | "der(E_dissipated)") => EVERYTHING,
        (_, Some(row)) => row.follows,
        _ => &[],
    }
}

/// Writes on which variables an unknown depends, each once.
fn write_dependencies(out: &mut String, groups: Groups) -> fmt::Result {
    let family = |name: &&str| {
        let name = name.trim_start_matches("all ").trim_end_matches('*').split('[').next().unwrap_or_default();
        Array::named(if matches!(name, "position" | "positions" | "overlap") { "q" } else { name })
    };
    let names = groups.iter().copied().flatten();
    let mut references: Vec<u32> = names.filter_map(|name| Some(family(name)?.reference())).collect();
    references.sort_unstable();
    references.dedup();
    let references: Vec<String> = references.iter().map(u32::to_string).collect();
    writeln!(out, " dependencies=\"{}\"/>", references.join(" "))
}
