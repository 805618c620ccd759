//! The page of documentation in the FMU, with tables from the table of variables.

use super::Standard;
use newtons_cradle::variables::{
    Access, Causality, MAX_BALLS, MODEL_IDENTIFIER, Number, Row, STEP_SIZE, STOP_TIME, Settings, TABLE, Variability,
    Variable, escaped,
};

const TEMPLATE: &str = include_str!("../../assets/index.html");
/// Fonts and colours of this page and those of the Python package.
const LOOK: &str = include_str!("../../../python/newtons_cradle/look/look.css");
/// A run with the default parameters, drawn by `examples/paper/pictures.py`.
const PICTURE: &str = include_str!("../../assets/run.svg");
/// The same run inside its first click, as the cradle's page shows it.
const SCENE: &str = include_str!("../../assets/scene.svg");

/// The template with the parts for this version of the standard, between `<!--2-->`, `<!--3-->`, `<!--arrays-->`,
/// `<!--scalars-->` or `<!--clocks-->` and `<!--end-->`.
fn template(standard: Standard) -> String {
    let mut pieces = TEMPLATE.split("<!--");
    let mut html = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        match piece.split_once("-->") {
            Some(("2", text)) if standard == Standard::Fmi2 => html.push_str(text),
            Some(("3", text)) if standard != Standard::Fmi2 => html.push_str(text),
            Some(("clocks", text)) if standard.has_clocks() => html.push_str(text),
            Some(("arrays", text)) if standard.has_arrays() => html.push_str(text),
            Some(("scalars", text)) if !standard.has_arrays() => html.push_str(text),
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
        .replace("{{scene}}", SCENE)
        .replace("{{model}}", MODEL_IDENTIFIER)
        .replace("{{version}}", env!("CARGO_PKG_VERSION"))
        .replace("{{balls}}", &format!("{balls} ball{}", if balls == 1 { "" } else { "s" }))
        .replace("{{stop_time}}", &Number(STOP_TIME).to_string())
        .replace("{{step_size}}", &Number(STEP_SIZE).to_string())
        .replace("{{tables}}", &TABLES.map(|table| self::table(start, standard, table)).concat())
}

/// A table of variables: anchor, heading, note, and causalities.
type TableOf = (&'static str, &'static str, &'static str, &'static [Causality]);

const TABLES: [TableOf; 4] = [
    ("parameters", "Parameters", NOTE, &[Causality::Parameter, Causality::CalculatedParameter]),
    ("inputs", "Inputs", "", &[Causality::Input]),
    ("outputs", "Outputs", "", &[Causality::Output]),
    ("locals", "Local variables", "", &[Causality::Local]),
];

const NOTE: &str = "<p>A parameter of a law that is not selected is ignored, and the log says so.</p>\n";

fn table(start: &Settings, standard: Standard, (id, heading, note, causalities): TableOf) -> String {
    let has_start = causalities.iter().any(|causality| matches!(causality, Causality::Parameter | Causality::Input));
    let third = if has_start { "<th>Start</th>" } else { "<td></td>" };
    let rows = rows(start, standard, causalities);
    format!(
        "<h2 id=\"{id}\">{heading}</h2>\n{note}<table>\n<thead><tr><th>Name</th><th>Unit</th>{third}\
         <th>Meaning</th></tr></thead>\n<tbody>\n{rows}</tbody>\n</table>\n\n"
    )
}

/// The variables of these causalities, each as a row of a table.
fn rows(start: &Settings, standard: Standard, causalities: &[Causality]) -> String {
    let of = |variable: Variable, name: &str| {
        let row = variable.row;
        let value = match row.causality {
            Causality::StructuralParameter => start.balls().to_string(),
            _ => start_value(start, variable.scalars(start.balls())),
        };
        let description = row.description.replace("{i}", "i").replace("{j}", "i+1") + &remarks(row);
        let (unit, meaning) = (row.unit(), escaped(&description));
        format!("<tr><td><code>{name}</code></td><td>{unit}</td><td>{value}</td><td>{meaning}</td></tr>\n")
    };
    if standard == Standard::Fmi2 {
        let rows = TABLE.iter().enumerate().filter(|(_, row)| causalities.contains(&row.causality));
        let whole = |(position, row)| Variable { row, position, index: 0, whole: true };
        return rows.map(whole).map(|of_row| of(of_row, &of_row.row.name_of("i"))).collect();
    }
    // For the reader, the number of balls is a parameter.
    let causality = |array: &Variable| match array.row.causality {
        Causality::StructuralParameter => Causality::Parameter,
        causality => causality,
    };
    Variable::arrays()
        .filter(|array| standard.has_clocks() || !array.needs_clocks())
        .filter(|array| standard.has_arrays() || array.scalar(0, MAX_BALLS).is_some())
        .filter(|array| causalities.contains(&causality(array)))
        .map(|array| {
            let name = if standard.has_arrays() { array.row.name } else { &array.row.name_of("i") };
            of(array, name)
        })
        .collect()
}

/// Start value, if it is the same for all balls or contacts; otherwise the first and the last.
fn start_value(start: &Settings, variables: impl Iterator<Item = Variable>) -> String {
    let values: Vec<String> = variables.filter_map(|variable| variable.text(start)).collect();
    match values.as_slice() {
        [first, .., last] if values.iter().any(|value| value != first) => format!("{first} &hellip; {last}"),
        all => all.first().cloned().unwrap_or_default(),
    }
}

/// Ranges, and when it may be set.
fn remarks(row: &Row) -> String {
    let mut text = match row.access {
        Access::Enumeration(enumeration) => format!(": {enumeration}"),
        _ => String::new(),
    };
    if row.causality == Causality::Parameter && (row.range.min.is_some() || row.range.max.is_some()) {
        text += &format!(". Allowed: {}", row.range);
    }
    if row.variability == Variability::Tunable {
        text += ". May also be changed between steps";
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_is_for_one_version_and_has_every_variable() {
        const FMI3: Standard = Standard::Fmi3 { clocks: true, scalars: false };
        let versions = [Standard::Fmi2, FMI3, Standard::Fmi3 { clocks: false, scalars: true }];
        let [two, three, without] = versions.map(|standard| html(&Settings::default_for(5), standard));
        assert!(two.contains("fmi2Error") && !two.contains("fmi3") && !two.contains("<!--"));
        assert!(three.contains("fmi3Error") && !three.contains("fmi2") && !three.contains("FMI 2"));
        assert!(three.contains("onset.clock") && !without.contains("clock"));
        assert!(without.contains("fmi3Error") && !without.contains("<code>n</code>") && !without.contains("array"));
        for row in TABLE {
            assert!(two.contains(&format!("<code>{}</code>", row.name_of("i"))), "{}", row.name);
            let left_out = row.name == "t_next_isOnset";
            assert!(left_out || without.contains(&format!("<code>{}</code>", row.name_of("i"))), "{}", row.name);
        }
        for array in Variable::arrays().filter(|array| array.row.causality != Causality::Independent) {
            assert!(three.contains(&format!("<code>{array}</code>")), "{array}");
        }
        assert!(!three.contains("<code>t_next_isOnset</code></td>") && !three.contains("<code>x[i]</code>"));
        assert!(two.contains("<svg ") && !two.contains("{{") && !two.contains("}}"));
    }
}
