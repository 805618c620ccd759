//! Units, types and variables of the description.

use std::collections::HashMap;
use std::fmt::{self, Display, Write};

use super::structure::{Contents, numbering};
use crate::model::Item;
use crate::number::Number;
use crate::variables::settings::Settings;
use crate::variables::table::extra::MAX_LOG;
use crate::variables::table::row::{Access, Causality, Row, Shape, Type, Variability};
use crate::variables::table::types::{QUANTITIES, Quantity};
use crate::variables::text::{camel, escaped};
use crate::variables::variable::{Variable, enumerations};

pub(super) fn write_units(out: &mut String) -> fmt::Result {
    for (quantity, shown) in QUANTITIES {
        write!(out, "    <Unit name=\"{}\"><BaseUnit{}/>", quantity.unit, quantity.base_units())?;
        // The unit itself comes first: FMPy plots a variable in the first unit that it can be shown in.
        if !shown.is_empty() {
            write!(out, "<DisplayUnit name=\"{}\"/>", quantity.unit)?;
        }
        for (name, factor) in shown.iter().filter_map(|shown| shown.display) {
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

pub(super) fn write_types(out: &mut String, fmi3: bool) -> fmt::Result {
    for (quantity, others) in QUANTITIES {
        for shown in [quantity].into_iter().chain(*others) {
            let (name, attributes) = (shown.name, format!("quantity=\"{}\"{}", quantity.name, units_of(shown)));
            match fmi3 {
                true => writeln!(out, "    <Float64Type name=\"{name}\" {attributes}/>")?,
                false => writeln!(out, "    <SimpleType name=\"{name}\"><Real {attributes}/></SimpleType>")?,
            }
        }
    }
    for enumeration in enumerations(fmi3) {
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

/// Writes these variables; those of FMI 2.0 as scalars. In FMI 3.0 units stand only in the declared types, because the
/// reader `fmi-schema` knows no unit and no nominal value of a variable.
pub(super) fn write_variables(out: &mut String, contents: &Contents) -> fmt::Result {
    let Contents { start, fmi3, .. } = *contents;
    let of_states = of_states(&contents.states, numbering(start.balls(), fmi3));
    // The common part of a row is rendered only once, because an instance renders all of this for its GUID.
    let mut rows = HashMap::new();
    for variable in &contents.variables {
        let (row, reference) = (variable.row, variable.reference());
        let variability = || if fmi3 { variable.variability() } else { row.variability };
        let parts = || [common_attributes(contents.causality(row), row, variability()), typed(row, fmi3)];
        let [common, typed] = rows.entry(variable.position).or_insert_with(parts);
        let is_array = row.shape != Shape::Scalar && variable.whole;
        let element = if fmi3 { row.access.data_type().fmi3() } else { "ScalarVariable" };
        write!(out, "    <{element} name=\"{variable}\" valueReference=\"{reference}\"{common}")?;
        if let Some(clock) = variable.clock() {
            write!(out, " clocks=\"{}\"", clock.reference())?;
        }
        if fmi3 && variable.is_intermediate() {
            out.write_str(" intermediateUpdate=\"true\"")?;
        }
        out.write_str(" description=\"")?;
        match is_array {
            true => write_text(out, row, "i", "i+1")?,
            false => write_text(out, row, variable.index + 1, variable.index + 2)?,
        }
        if is_array && row.shape == Shape::Contacts {
            out.write_str("; the last element belongs to no contact")?;
        }
        match fmi3 {
            true => write!(out, "\"{typed}")?,
            false => write!(out, "\">\n      <{:?}{typed}", row.access.data_type())?,
        }
        out.write_str(of_states.get(&reference).map_or("", String::as_str))?;
        if row.causality == Causality::StructuralParameter {
            write!(out, " start=\"{}\"", start.balls())?;
        } else if row.settable() {
            for index in 0..variable.len(start.balls()) {
                let before = if index == 0 { " start=\"" } else { " " };
                let value = variable.element(index).value(start);
                write!(out, "{before}{}", Number(value.unwrap_or_else(|| padding(row))))?;
            }
            out.write_str("\"")?;
        }
        if is_array {
            let balls = Variable::array("n").map_or(0, |n| n.reference());
            writeln!(out, "><Dimension valueReference=\"{balls}\"/></{element}>")?;
        } else {
            out.write_str(if fmi3 { "/>\n" } else { "/>\n    </ScalarVariable>\n" })?;
        }
    }
    Ok(())
}

/// Attributes of states and of their derivatives, by value reference; `number` identifies a state.
fn of_states(states: &[(Variable, Variable)], number: impl Fn(Variable) -> usize) -> HashMap<u32, String> {
    let mut of_states: HashMap<u32, String> = HashMap::new(); // a velocity is a derivative and a state
    for (state, rate) in states {
        *of_states.entry(rate.reference()).or_default() += &format!(" derivative=\"{}\"", number(*state));
        *of_states.entry(state.reference()).or_default() += " reinit=\"true\"";
    }
    of_states
}

/// Attributes common to both versions, except type and description.
fn common_attributes(causality: Causality, row: &Row, variability: Variability) -> String {
    let initial = match (causality, row.access) {
        (Causality::Parameter, _) => " initial=\"exact\"",
        // Clocks and clocked values have no `initial`.
        (Causality::Output, Access::Instance(..)) => "",
        (Causality::CalculatedParameter | Causality::Output | Causality::Local, _) => " initial=\"calculated\"",
        // The standards forbid `initial` here.
        (Causality::Input | Causality::Independent | Causality::StructuralParameter, _) => "",
    };
    let (causality, variability) = (camel(&causality), camel(&variability));
    format!(" causality=\"{causality}\" variability=\"{variability}\"{initial}")
}

/// Declared type and range; in FMI 2.0 also unit and nominal value, in FMI 3.0 attributes of binary variables and
/// clocks.
fn typed(row: &Row, fmi3: bool) -> String {
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
    match row.access.data_type() {
        Type::Binary => text + &format!(" mimeType=\"text/csv\" maxSize=\"{MAX_LOG}\""),
        Type::Clock => text + " intervalVariability=\"triggered\"",
        _ if fmi3 => text,
        _ => {
            let nominal = row.nominal.map(|nominal| format!(" nominal=\"{}\"", Number(nominal)));
            text + &row.quantity.map(units_of).unwrap_or_default() + &nominal.unwrap_or_default()
        }
    }
}

/// Writes the description of a row with the index and the next one filled in, and with constraints that attributes
/// cannot express. The texts of the tables need no escapes (tested).
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

/// The default of a parameter over contacts, for the element of its array that belongs to no contact.
pub fn padding(row: &Row) -> f64 {
    match row.access {
        Access::Setting { get, .. } => get(&Settings::default_for(2)).first().copied().unwrap_or(0.0),
        _ => 0.0,
    }
}
