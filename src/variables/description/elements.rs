//! Units, types and variables of the description.

use std::collections::HashMap;
use std::fmt::{self, Display, Write};

use super::structure::first_indices;
use crate::variables::arrays::{Array, MAX_LOG};
use crate::variables::settings::Settings;
use crate::variables::table::TABLE;
use crate::variables::table::enumeration::{DERIVATIVES_OF, ENUMERATIONS, Item};
use crate::variables::table::row::{Access, Causality, Row, Shape, Type, Variability};
use crate::variables::table::unit::{DISPLAYED, QUANTITIES, Quantity};
use crate::variables::text::{Number, camel, escaped};
use crate::variables::variable::{Variable, variables};

pub(super) fn write_units(out: &mut String) -> fmt::Result {
    for quantity in QUANTITIES {
        write!(out, "    <Unit name=\"{}\"><BaseUnit", quantity.unit)?;
        for (base, exponent) in ["kg", "m", "s"].iter().zip(quantity.exponents) {
            if exponent != 0 {
                write!(out, " {base}=\"{exponent}\"")?;
            }
        }
        out.write_str("/>")?;
        // First the unit itself: FMPy plots whatever has a unit in the first one that it can be shown in.
        let alike: Vec<&Quantity> = displayed(quantity).collect();
        if !alike.is_empty() {
            write!(out, "<DisplayUnit name=\"{}\"/>", quantity.unit)?;
        }
        for (name, factor) in alike.iter().filter_map(|quantity| quantity.display) {
            write!(out, "<DisplayUnit name=\"{name}\" factor=\"{}\"/>", Number(factor))?;
        }
        out.write_str("</Unit>\n")?;
    }
    Ok(())
}

/// Unit of a type or a variable, and the one that it is shown in.
fn units_of(quantity: &Quantity) -> String {
    let display = quantity.display.map(|(name, _)| format!(" displayUnit=\"{name}\"")).unwrap_or_default();
    format!(" unit=\"{}\"{display}", quantity.unit)
}

/// The quantity again, in each unit that it is shown in for some variables.
fn displayed(quantity: &Quantity) -> impl Iterator<Item = &'static Quantity> {
    DISPLAYED.iter().copied().filter(|shown| shown.unit == quantity.unit)
}

pub(super) fn write_types(out: &mut String, fmi3: bool) -> fmt::Result {
    for quantity in QUANTITIES {
        for shown in std::iter::once(*quantity).chain(displayed(quantity)) {
            let (name, attributes) = (shown.name, format!("quantity=\"{}\"{}", quantity.name, units_of(shown)));
            match fmi3 {
                true => writeln!(out, "    <Float64Type name=\"{name}\" {attributes}/>")?,
                false => writeln!(out, "    <SimpleType name=\"{name}\"><Real {attributes}/></SimpleType>")?,
            }
        }
    }
    for enumeration in ENUMERATIONS.iter().copied().chain(fmi3.then_some(&DERIVATIVES_OF)) {
        let name = enumeration.type_name;
        match fmi3 {
            true => writeln!(out, "    <EnumerationType name=\"{name}\">")?,
            false => writeln!(out, "    <SimpleType name=\"{name}\">\n      <Enumeration>")?,
        }
        for Item { name, value, description } in enumeration.items {
            let description = escaped(description);
            writeln!(out, "      <Item name=\"{name}\" value=\"{value}\" description=\"{description}\"/>")?;
        }
        out.push_str(if fmi3 { "    </EnumerationType>\n" } else { "      </Enumeration>\n    </SimpleType>\n" });
    }
    Ok(())
}

/// Writes every variable of FMI 2.0. The common part of a row is rendered once: an instance renders all of this for its
/// GUID.
pub(super) fn write_variables(out: &mut String, start: &Settings, states: &[(Array, Array)]) -> fmt::Result {
    let (balls, firsts) = (start.balls(), first_indices(start.balls()));
    let of_states = of_states(states, |state| firsts[state.variable(0).position] + state.index(0));
    let units = |row: &Row| row.quantity.map(units_of).unwrap_or_default();
    let rows: Vec<[String; 2]> =
        TABLE.iter().map(|row| [common_attributes(row, row.variability), typed(row) + &units(row)]).collect();
    for variable in variables(balls) {
        let [common, typed] = &rows[variable.position];
        let reference = variable.reference();
        write!(out, "    <ScalarVariable name=\"{variable}\" valueReference=\"{reference}\"{common} description=\"")?;
        write_text(out, variable.row, variable.index + 1, variable.index + 2)?;
        write!(out, "\">\n      <{:?}{typed}", variable.row.access.data_type())?;
        if let Some(nominal) = variable.row.nominal {
            write!(out, " nominal=\"{}\"", Number(nominal))?;
        }
        out.write_str(of_states.get(&reference).map_or("", String::as_str))?;
        if variable.row.settable() {
            write!(out, " start=\"{}\"", start_value(variable, start))?;
        }
        out.write_str("/>\n    </ScalarVariable>\n")?;
    }
    Ok(())
}

/// Writes these variables of FMI 3.0. Units stand in the declared types, because the reader `fmi-schema` knows no unit
/// and no nominal value of a variable.
pub(super) fn write_arrays(
    out: &mut String,
    start: &Settings,
    states: &[(Array, Array)],
    mut arrays: impl Iterator<Item = Array>,
) -> fmt::Result {
    let of_states = of_states(states, |state| state.reference() as usize);
    arrays.try_for_each(|array| write_array(out, start, of_states.get(&array.reference()), array))
}

/// What states and their derivatives have as attributes, by value reference; `number` identifies a state.
fn of_states(states: &[(Array, Array)], number: impl Fn(Array) -> usize) -> HashMap<u32, String> {
    let mut of_states: HashMap<u32, String> = HashMap::new(); // a velocity is a derivative and a state
    for (state, rate) in states {
        *of_states.entry(rate.reference()).or_default() += &format!(" derivative=\"{}\"", number(*state));
        *of_states.entry(state.reference()).or_default() += " reinit=\"true\"";
    }
    of_states
}

fn write_array(out: &mut String, start: &Settings, of_state: Option<&String>, array: Array) -> fmt::Result {
    let (row, reference) = (array.row, array.reference());
    let is_array = row.shape != Shape::Scalar && !array.is_single();
    let (element, common) = (row.access.data_type().fmi3(), common_attributes(row, array.variability()));
    write!(out, "    <{element} name=\"{array}\" valueReference=\"{reference}\"{common}")?;
    if let Some(clock) = array.clock() {
        write!(out, " clocks=\"{}\"", clock.reference())?;
    }
    if array.is_intermediate() {
        out.write_str(" intermediateUpdate=\"true\"")?;
    }
    out.write_str(" description=\"")?;
    match is_array {
        true => write_text(out, row, "i", "i+1")?,
        false => write_text(out, row, array.index(0) + 1, array.index(0) + 2)?,
    }
    if is_array && row.shape == Shape::Contacts {
        out.write_str("; the last element belongs to no contact")?;
    }
    write!(out, "\"{}", typed(row))?;
    match row.access.data_type() {
        Type::Binary => write!(out, " mimeType=\"text/csv\" maxSize=\"{MAX_LOG}\"")?,
        Type::Clock => out.write_str(" intervalVariability=\"triggered\"")?,
        _ => {}
    }
    out.write_str(of_state.map_or("", String::as_str))?;
    if row.causality == Causality::StructuralParameter {
        write!(out, " start=\"{}\"", start.balls())?;
    } else if row.settable() {
        let values = (0..array.len(start.balls())).map(|index| start_value(array.variable(index), start));
        write!(out, " start=\"{}\"", values.collect::<Vec<_>>().join(" "))?;
    }
    if !is_array {
        return out.write_str("/>\n");
    }
    let balls = Array::named("n").map_or(0, |balls| balls.reference());
    writeln!(out, "><Dimension valueReference=\"{balls}\"/></{element}>")
}

/// Attributes common to both versions, except type and description.
fn common_attributes(row: &Row, variability: Variability) -> String {
    let initial = match (row.causality, row.access) {
        (Causality::Parameter, _) => " initial=\"exact\"",
        // Clocked values and clocks have none.
        (Causality::Output, Access::Instance(..)) => "",
        (Causality::CalculatedParameter | Causality::Output | Causality::Local, _) => " initial=\"calculated\"",
        // The standards forbid it here.
        (Causality::Input | Causality::Independent | Causality::StructuralParameter, _) => "",
    };
    let (causality, variability) = (camel(&row.causality), camel(&variability));
    format!(" causality=\"{causality}\" variability=\"{variability}\"{initial}")
}

/// Declared type and range.
fn typed(row: &Row) -> String {
    let mut text = String::new();
    let mut attribute = |name: &str, value: &dyn Display| {
        // Writing to a string cannot fail.
        let _ = write!(text, " {name}=\"{value}\"");
    };
    if let Some(quantity) = row.quantity {
        attribute("declaredType", &quantity.name);
    }
    if let Access::Enumeration(enumeration) = row.access {
        attribute("declaredType", &enumeration.type_name);
    }
    for (name, value) in [("min", row.range.min), ("max", row.range.max)] {
        if let Some(value) = value {
            attribute(name, &Number(value));
        }
    }
    text
}

/// Writes the description with the index and the next one filled in, and constraints beyond the attributes. The texts
/// of the tables need no escapes (tested).
fn write_text(out: &mut String, row: &Row, i: impl Display, j: impl Display) -> fmt::Result {
    let mut pieces = row.description.split('{');
    out.write_str(pieces.next().unwrap_or_default())?;
    for piece in pieces {
        match (piece.strip_prefix("i}"), piece.strip_prefix("j}")) {
            (Some(rest), _) => write!(out, "{i}{rest}")?,
            (_, Some(rest)) => write!(out, "{j}{rest}")?,
            _ => write!(out, "{{{piece}")?,
        }
    }
    if row.range.above_min && row.settable() {
        out.write_str("; 0 itself is refused")?;
    }
    Ok(())
}

/// The start value of the settings, or the default for an element that belongs to no contact.
fn start_value(variable: Variable, start: &Settings) -> String {
    match (variable.real(start), variable.item(start)) {
        (Some(value), _) => Number(value).to_string(),
        (_, Some(value)) => value.to_string(),
        _ => Number(padding(variable.row)).to_string(),
    }
}

/// The default of a parameter over contacts, for the element that belongs to none.
pub fn padding(row: &Row) -> f64 {
    let first = |settings: &Settings| match row.access {
        Access::Setting { get, .. } => get(settings).first().copied(),
        _ => None,
    };
    first(&Settings::default_for(2)).unwrap_or(0.0)
}
