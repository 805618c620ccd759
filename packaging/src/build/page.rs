//! The page of documentation that travels in the FMU. Its table comes from the table of variables.

use std::fmt::Write;

use super::Standard;
use newtons_cradle::variables::{
    Access, Array, Causality, DERIVATIVES_OF, Escaped, Extra, MODEL_IDENTIFIER, Number, Row, STEP_SIZE, STOP_TIME,
    Settings, TABLE, Variability, Variable,
};

const TEMPLATE: &str = include_str!("../../assets/index.html");
/// Fonts and colours of this page and those of the Python package.
const LOOK: &str = include_str!("../../../python/newtons_cradle/look/look.css");
/// A run with the default parameters, drawn by `examples/paper/pictures.py`.
const PICTURE: &str = include_str!("../../assets/run.svg");

/// The template with what is for this version of the standard, between `<!--2-->`, `<!--3-->` or `<!--clocks-->` and
/// `<!--end-->`.
fn template(standard: Standard) -> String {
    let mut pieces = TEMPLATE.split("<!--");
    let mut html = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        match piece.split_once("-->") {
            Some(("2", text)) if standard == Standard::Fmi2 => html.push_str(text),
            Some(("3", text)) if standard != Standard::Fmi2 => html.push_str(text),
            Some(("clocks", text)) if standard == (Standard::Fmi3 { clocks: true }) => html.push_str(text),
            Some(("end", text)) => html.push_str(text),
            _ => {}
        }
    }
    html
}

/// The page of the FMU with these start values.
pub fn html(start: &Settings, standard: Standard) -> String {
    let balls = start.balls();
    template(standard)
        .replace("{{look}}", LOOK)
        .replace("{{picture}}", PICTURE)
        .replace("{{model}}", MODEL_IDENTIFIER)
        .replace("{{version}}", env!("CARGO_PKG_VERSION"))
        .replace("{{balls}}", &format!("{balls} ball{}", if balls == 1 { "" } else { "s" }))
        .replace("{{stop_time}}", &Number(STOP_TIME).to_string())
        .replace("{{step_size}}", &Number(STEP_SIZE).to_string())
        .replace("{{parameters}}", &rows(start, standard, &[Causality::Parameter, Causality::CalculatedParameter]))
        .replace("{{inputs}}", &rows(start, standard, &[Causality::Input]))
        .replace("{{outputs}}", &rows(start, standard, &[Causality::Output]))
        .replace("{{locals}}", &rows(start, standard, &[Causality::Local]))
}

/// The variables of these causalities, each as a row of a table.
fn rows(start: &Settings, standard: Standard, causalities: &[Causality]) -> String {
    match standard {
        Standard::Fmi2 => {
            let rows = TABLE.iter().enumerate().filter(|(_, row)| causalities.contains(&row.causality));
            let of = |(position, row): (usize, &'static Row)| {
                let description = row.description.replace("{i}", "i").replace("{j}", "i+1");
                line(&row.name_of("i"), row.unit(), &start_value(start, position, row), &(description + &remarks(row)))
            };
            rows.map(of).collect()
        }
        Standard::Fmi3 { clocks } => {
            // The number of balls is a parameter to the reader.
            let causality = |array: Array| {
                if array == Array::Extra(Extra::Balls) { Some(Causality::Parameter) } else { array.causality() }
            };
            let arrays = Array::all()
                .filter(|array| clocks || !array.needs_clocks())
                .filter(|array| causality(*array).is_some_and(|own| causalities.contains(&own)));
            arrays.map(|array| line_of_array(start, array)).collect()
        }
    }
}

fn line_of_array(start: &Settings, array: Array) -> String {
    let unit = array.quantity().map_or("", |quantity| quantity.unit);
    let value = match array {
        Array::Row(position) => start_value(start, position, &TABLE[position]),
        Array::Extra(Extra::Balls) => start.balls().to_string(),
        Array::Extra(Extra::DerivativesOf) => DERIVATIVES_OF[0].name.to_owned(),
        Array::Slope(_) => "0".to_owned(),
        _ => String::new(),
    };
    line(&array.to_string(), unit, &value, &(array.description() + &array.row().map_or_else(String::new, remarks)))
}

fn line(name: &str, unit: &str, value: &str, description: &str) -> String {
    let description = Escaped(description);
    format!("<tr><td><code>{name}</code></td><td>{unit}</td><td>{value}</td><td>{description}</td></tr>\n")
}

/// Start value, if all balls or contacts have the same.
fn start_value(start: &Settings, position: usize, row: &'static Row) -> String {
    let values: Vec<String> = (0..row.shape.len(start.balls()))
        .filter_map(|index| {
            let variable = Variable { row, position, index };
            let item = |enumeration: &newtons_cradle::variables::Enumeration| {
                variable.item(start).and_then(|value| enumeration.item(value)).map(|item| item.name.to_owned())
            };
            match row.access {
                Access::Enumeration(enumeration) => item(enumeration),
                _ => variable.real(start).map(|value| Number(value).to_string()),
            }
        })
        .collect();
    match values.as_slice() {
        [] => String::new(),
        [first, rest @ ..] if rest.iter().all(|value| value == first) => first.clone(),
        [first, .., last] => format!("{first} &hellip; {last}"),
        [first] => first.clone(),
    }
}

/// What is allowed and when.
fn remarks(row: &Row) -> String {
    let mut text = String::new();
    if let Access::Enumeration(enumeration) = row.access {
        let _ = write!(text, ": {enumeration}");
    }
    if row.causality == Causality::Parameter && (row.range.min.is_some() || row.range.max.is_some()) {
        let _ = write!(text, ". Allowed: {}", row.range);
    }
    if row.variability == Variability::Tunable {
        text.push_str(". May also be changed between steps");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_is_for_one_version() {
        let versions = [Standard::Fmi2, Standard::Fmi3 { clocks: true }, Standard::Fmi3 { clocks: false }];
        let [two, three, without_clocks] = versions.map(|standard| html(&Settings::default_for(5), standard));
        assert!(two.contains("fmi2Error") && !two.contains("fmi3") && !two.contains("<!--"));
        assert!(three.contains("fmi3Error") && !three.contains("fmi2") && !three.contains("FMI 2"));
        assert!(
            three.contains("onset.clock") && !without_clocks.contains("clock") && without_clocks.contains("fmi3Error")
        );
    }

    #[test]
    fn every_variable_is_on_the_page() {
        let html = html(&Settings::default_for(5), Standard::Fmi2);
        for row in TABLE {
            assert!(html.contains(&format!("<code>{}</code>", row.name_of("i"))), "{}", row.name);
        }
        let three = super::html(&Settings::default_for(5), Standard::Fmi3 { clocks: true });
        for array in Array::all().filter(|array| *array != Array::Extra(Extra::Time)) {
            assert!(three.contains(&format!("<code>{array}</code>")), "{array}");
        }
        assert!(!three.contains("<code>t_next_isOnset</code></td>") && !three.contains("<code>x[i]</code>"));
        assert!(html.contains("<svg ") && !html.contains("{{") && !html.contains("}}"));
    }
}
