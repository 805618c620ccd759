//! The cradle that the user chooses: a preset, parameter files, single start values, checked by the FMU's own code.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::Path;

use newtons_cradle::files::{self, MAX_START_VALUES};
use newtons_cradle::variables::{
    Access, DEFAULT_BALLS, MAX_BALLS, MIN_BALLS, MODEL_IDENTIFIER, Recipe, Row, Shape, StartValue,
};
use toml::{Table, Value};

use super::names;
use crate::error::Error;

/// A cradle with a name, whose parameter file is built into the program.
pub struct Preset {
    /// Its name for `--preset`.
    pub name: &'static str,
    /// The parameter file; its first line is the title.
    file: &'static str,
}

macro_rules! presets {
    ($($name:literal),*) => {
        &[$(Preset { name: $name, file: include_str!(concat!("../../presets/", $name, ".toml")) }),*]
    };
}

/// Every preset, in the order of every list of presets: `packaging/presets/order.txt`.
pub static PRESETS: &[Preset] = presets![
    "textbook", "figure3", "figure5", "figure6", "steel", "desk", "tapered", "unlike", "clay", "rigid", "buzzing"
];

impl Preset {
    /// One line for the help.
    pub fn title(&self) -> &'static str {
        self.file.lines().next().unwrap_or_default().trim_start_matches("# ")
    }

    /// The preset of this name; the error lists all names.
    pub fn named(name: &str) -> Result<&'static Self, Error> {
        PRESETS.iter().find(|preset| preset.name == name).ok_or_else(|| {
            let known: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
            let (hint, allowed) = (names::did_you_mean(name, known.iter().copied()), known.join(", "));
            Error::Usage(format!("there is no preset \"{name}\"{hint}; allowed: {allowed}"))
        })
    }

    /// Its cradle.
    pub fn recipe(&self) -> Result<Recipe, Error> {
        let mut choice = Choice::default();
        choice.preset(self)?;
        choice.recipe()
    }
}

/// The choice so far; later values replace earlier ones.
pub struct Choice {
    /// The name of the FMU's file: that of the model, the preset or the last parameter file, with the number of balls
    /// if it differs.
    pub name: String,
    balls: usize,
    /// The preset, and its number of balls.
    preset: Option<(&'static str, usize)>,
    sources: Vec<Source>,
}

/// What one file or argument gives. Within it no value replaces another.
struct Source {
    /// What it is, for messages.
    origin: String,
    assignments: Vec<Assignment>,
}

struct Assignment {
    /// The name as it is written: in TOML, `contact.model` and `"contact.model"` are two keys.
    key: String,
    name: String,
    /// One value, or one for each variable of an array.
    values: Vec<StartValue>,
}

impl Default for Choice {
    fn default() -> Self {
        Self { name: MODEL_IDENTIFIER.to_owned(), balls: DEFAULT_BALLS, preset: None, sources: Vec::new() }
    }
}

impl Choice {
    /// Chooses the number of balls.
    pub fn balls(&mut self, balls: usize) {
        if balls != self.balls {
            self.balls = balls;
            self.name += &balls.to_string();
        }
    }

    /// Takes everything from a preset.
    pub fn preset(&mut self, preset: &Preset) -> Result<(), Error> {
        self.toml(&format!("preset {}", preset.name), preset.file)?;
        preset.name.clone_into(&mut self.name);
        self.preset = Some((preset.name, self.balls));
        Ok(())
    }

    /// Takes everything from a parameter file.
    pub fn file(&mut self, path: &Path) -> Result<(), Error> {
        let origin = path.display().to_string();
        let refused = |reason: &dyn Display| Error::Usage(format!("cannot read {origin}: {reason}"));
        let bytes = files::read(path, MAX_START_VALUES).map_err(|error| refused(&error))?;
        let text = String::from_utf8(bytes).map_err(|_| refused(&"it is not in UTF-8"))?;
        self.name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        self.toml(&origin, &text)
    }

    /// Takes the text of a parameter file: `balls`, and start values by name, whose dots may be TOML tables.
    fn toml(&mut self, origin: &str, text: &str) -> Result<(), Error> {
        let refused = |error: toml::de::Error| Error::Usage(format!("{origin}: {}", names::brief(&error.to_string())));
        let mut table: Table = text.parse().map_err(refused)?;
        if let Some(balls) = table.remove("balls") {
            let whole = balls.as_integer().and_then(|balls| usize::try_from(balls).ok());
            let (given, allowed) = (shown(&balls), format_args!("a whole number from {MIN_BALLS} to {MAX_BALLS}"));
            let refused = || Error::Usage(format!("{origin}: balls = {given} is refused; allowed: {allowed}"));
            self.balls = whole.ok_or_else(refused)?;
        }
        let mut assignments = Vec::new();
        of_table(&mut assignments, ["", ""], table).map_err(|error| Error::Usage(format!("{origin}: {error}")))?;
        self.sources.push(Source { origin: origin.to_owned(), assignments });
        Ok(())
    }

    /// Takes `name=value` or `name=value,value,...`.
    pub fn set(&mut self, text: &str) -> Result<(), Error> {
        let origin = format!("--set {}", names::brief(text));
        let Some((name, values)) = text.split_once('=') else {
            return Err(Error::Usage(format!("{origin} is refused; allowed: name=value or name=value,value,...")));
        };
        let value = |value: &str| {
            let value = value.trim();
            value.parse().map_or_else(|_| StartValue::Item(value.to_owned()), StartValue::Number)
        };
        let (name, values) = (name.trim().to_owned(), values.split(',').map(value).collect());
        self.sources.push(Source { origin, assignments: vec![Assignment { key: name.clone(), name, values }] });
        Ok(())
    }

    /// Whether an argument or a parameter file, not only the preset, gives this start value.
    pub fn names(&self, name: &str) -> bool {
        let own = if self.preset.is_some() { 1 } else { 0 };
        self.sources.iter().skip(own).any(|source| source.assignments.iter().any(|given| given.name == name))
    }

    /// The cradle, with every start value checked as the FMU checks it.
    pub fn recipe(self) -> Result<Recipe, Error> {
        let mut recipe = Recipe::new(self.balls);
        recipe.settings()?;
        // Every preset lists the positions of its balls.
        if let Some((preset, balls)) = self.preset.filter(|(_, balls)| *balls != recipe.balls) {
            return Err(Error::Usage(format!(
                "preset {preset} is of {balls} balls, not {}; leave out the number of balls, or set the preset's \
                 values one by one, with your own x_start",
                recipe.balls
            )));
        }
        for Source { origin, assignments } in self.sources {
            // Checked alone, so that the error can name where it was given.
            let mut alone =
                start(assignments, recipe.balls).map_err(|error| Error::Usage(format!("{origin}: {error}")))?;
            recipe.start.append(&mut alone);
        }
        Ok(recipe)
    }
}

/// A value of TOML, for messages.
fn shown(value: &Value) -> String {
    match value {
        Value::Integer(number) => number.to_string(),
        Value::Float(number) => format!("{number:?}"),
        Value::Boolean(truth) => truth.to_string(),
        Value::String(text) => format!("{text:?}"),
        Value::Datetime(time) => time.to_string(),
        Value::Array(_) => "a list".to_owned(),
        Value::Table(_) => "a table".to_owned(),
    }
}

/// Appends what a table of TOML assigns, whose key and name, each with a dot at its end, these are.
fn of_table(assignments: &mut Vec<Assignment>, before: [&str; 2], table: Table) -> Result<(), String> {
    for (part, value) in table {
        let is_bare = !part.is_empty() && part.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'));
        let written = if is_bare { part.clone() } else { format!("{part:?}") };
        let [key, name] = [before[0].to_owned() + &written, before[1].to_owned() + &part];
        let values = match value {
            Value::Table(inner) => {
                of_table(assignments, [&format!("{key}."), &format!("{name}.")], inner)?;
                continue;
            }
            Value::Array(values) => values,
            value => vec![value],
        };
        // Integers become reals.
        let start = |value: Value| {
            let (given, allowed) = (shown(&value), "a number, the name of an item, or a list of numbers");
            value.try_into::<StartValue>().map_err(|_| format!("{name} = {given} is refused; allowed: {allowed}"))
        };
        let values = values.into_iter().map(start).collect::<Result<_, _>>()?;
        assignments.push(Assignment { key, name, values });
    }
    Ok(())
}

/// The start values of one source by variable, checked.
fn start(assignments: Vec<Assignment>, balls: usize) -> Result<BTreeMap<String, StartValue>, String> {
    let mut recipe = Recipe::new(balls);
    let mut keys = BTreeMap::new();
    for Assignment { key, name, values } in assignments {
        for (variable, value) in elements(&name, values, balls)? {
            if let Some(other) = keys.insert(variable.clone(), key.clone()) {
                return Err(format!("{variable} is given twice, as {other} and as {key}; allowed: once"));
            }
            recipe.start.insert(variable, value);
        }
    }
    recipe.settings().map_err(|refusal| refusal.to_string())?;
    Ok(recipe.start)
}

/// The value of an enumeration by the name of its item, if its number is given.
fn by_name(row: &Row, value: StartValue) -> StartValue {
    let (StartValue::Number(number), Access::Enumeration(enumeration)) = (&value, row.access) else { return value };
    let item = enumeration.items.iter().find(|item| f64::from(item.value) == *number);
    item.map_or(value, |item| StartValue::Item(item.name.to_owned()))
}

/// The variables of `name`, with their values.
fn elements(name: &str, values: Vec<StartValue>, balls: usize) -> Result<Vec<(String, StartValue)>, String> {
    let row = names::settable(name, balls)?;
    let values: Vec<StartValue> = values.into_iter().map(|value| by_name(row, value)).collect();
    if let Some(refusal) = values.iter().find_map(|value| names::not_a_number(row, value)) {
        return Err(refusal);
    }
    if name == row.name && row.shape != Shape::Scalar {
        let (wanted, given) = (row.shape.len(balls), values.len());
        if given != wanted {
            return Err(format!(
                "{name} takes a list of {wanted} value(s) in a cradle of {balls} ball(s), not {given}; to set a single \
                 one, use {name}[i]"
            ));
        }
        let named = |(index, value)| (row.name_of(index + 1), value);
        return Ok(values.into_iter().enumerate().map(named).collect());
    }
    match <[StartValue; 1]>::try_from(values) {
        Ok([value]) => Ok(vec![(name.to_owned(), value)]),
        Err(values) => Err(format!("{name} takes one value, not {}; write decimals with a point", values.len())),
    }
}

#[cfg(test)]
mod tests {
    use newtons_cradle::variables::{Causality, Row, TABLE};

    use super::*;

    #[test]
    fn presets_are_all_files() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("presets");
        assert_eq!(std::fs::read_dir(folder).unwrap().count(), PRESETS.len() + 1);
    }

    #[test]
    fn presets_state_every_parameter_that_has_an_effect() {
        for preset in PRESETS {
            let recipe = preset.recipe().unwrap();
            let parameters = recipe.settings().unwrap().parameters;
            let stated = |name: &str| recipe.start.contains_key(name);
            // The solver is not part of a cradle.
            let of_solving = |name: &str| name.starts_with("solver.") || name.starts_with("exchange.");
            let used = |row: &&Row| row.needs.iter().all(|need| (need.is_met)(&parameters, None));
            for row in TABLE.iter().filter(|row| row.causality == Causality::Parameter).filter(used) {
                let (preset, name) = (preset.name, row.name);
                match row.shape {
                    Shape::Scalar => assert!(stated(name) || of_solving(name), "{preset}: {name}"),
                    // The others are ratios, which are 1, and gaps, which are 0.
                    _ if name.ends_with("_start") => assert!(stated(&format!("{name}[1]")), "{preset}: {name}"),
                    _ => {}
                }
            }
        }
    }
}
