//! The page of documentation in the FMU, with tables from the table of variables.

use newtons_cradle::variables::{
    Access, Causality, Description, MODEL_IDENTIFIER, Number, Row, STEP_SIZE, STOP_TIME, Settings, Variability,
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
fn template(description: &Description) -> String {
    let Description { fmi3, clocks, scalars, .. } = *description;
    let marks = [("2", !fmi3), ("3", fmi3), ("clocks", clocks), ("arrays", !scalars), ("scalars", scalars)];
    let shown = |piece: &'static str| match piece.split_once("-->") {
        Some((mark, text)) => (mark == "end" || marks.contains(&(mark, true))).then_some(text),
        None => Some(piece),
    };
    TEMPLATE.split("<!--").filter_map(shown).collect()
}

/// The page of the FMU with this description.
pub fn html(description: &Description) -> String {
    let balls = description.start.balls();
    template(description)
        .replace("{{look}}", LOOK)
        .replace("{{picture}}", PICTURE)
        .replace("{{scene}}", SCENE)
        .replace("{{model}}", MODEL_IDENTIFIER)
        .replace("{{version}}", env!("CARGO_PKG_VERSION"))
        .replace("{{balls}}", &format!("{balls} ball{}", if balls == 1 { "" } else { "s" }))
        .replace("{{stop_time}}", &Number(STOP_TIME).to_string())
        .replace("{{step_size}}", &Number(STEP_SIZE).to_string())
        .replace("{{tables}}", &TABLES.map(|table| self::table(description, table)).concat())
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

fn table(description: &Description, (id, heading, note, causalities): TableOf) -> String {
    let start = description.start;
    let has_start = causalities.iter().any(|causality| matches!(causality, Causality::Parameter | Causality::Input));
    let third = if has_start { "<th>Start</th>" } else { "<td></td>" };
    let mut rows = String::new();
    for variable in description.variables().into_iter().filter(|variable| variable.index == 0) {
        let row = variable.row;
        let (causality, value) = match row.causality {
            // For the reader, the number of balls is a parameter.
            Causality::StructuralParameter => (Causality::Parameter, start.balls().to_string()),
            causality => (causality, start_value(start, variable)),
        };
        if causalities.contains(&causality) {
            let name = if description.scalars { &row.name_of("i") } else { row.name };
            let meaning = row.description.replace("{i}", "i").replace("{j}", "i+1") + &remarks(row);
            let (unit, meaning) = (row.unit(), escaped(&meaning));
            rows +=
                &format!("<tr><td><code>{name}</code></td><td>{unit}</td><td>{value}</td><td>{meaning}</td></tr>\n");
        }
    }
    format!(
        "<h2 id=\"{id}\">{heading}</h2>\n{note}<table>\n<thead><tr><th>Name</th><th>Unit</th>{third}\
         <th>Meaning</th></tr></thead>\n<tbody>\n{rows}</tbody>\n</table>\n\n"
    )
}

/// Start value, if it is the same for all balls or contacts; otherwise the first and the last.
fn start_value(start: &Settings, variable: Variable) -> String {
    let all = Variable { whole: true, ..variable };
    let values: Vec<String> = all.scalars(start.balls()).filter_map(|scalar| scalar.text(start)).collect();
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
    use newtons_cradle::variables::TABLE;

    use super::*;

    #[test]
    fn documentation_page_is_for_one_version_and_has_every_variable() {
        let start = Settings::default_for(5);
        let scalars = Description { clocks: false, scalars: true, ..Description::fmi3(&start) };
        let versions = [Description::of(&start), Description::fmi3(&start), scalars];
        let [two, three, without] = versions.map(|description| html(&description));
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
