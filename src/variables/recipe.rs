//! The file in the FMU's resources that tells an instance n and the changed start values.

use std::collections::BTreeMap;
use std::fmt::Formatter;

use serde::de::{Deserializer, Error, MapAccess, Visitor};
use serde::{Deserialize, Serialize};

use super::settings::{DEFAULT_BALLS, MAX_BALLS, MIN_BALLS, Settings};
use super::table::row::Access;
use super::text::{Refusal, ensure};
use super::variable::Variable;
use crate::number::Number;

/// Name of the file in `resources/`.
pub const FILE_NAME: &str = "cradle.json";

/// Format that this code reads and writes.
const FORMAT: u32 = 1;

/// The cradle an FMU was built for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recipe {
    format: u32,
    /// Number of balls n, 1 to 10000.
    pub balls: usize,
    /// Start values that are not the defaults, by name.
    #[serde(default, deserialize_with = "each_once")]
    pub start: BTreeMap<String, StartValue>,
}

/// A start value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum StartValue {
    /// Of a real parameter or input.
    Number(f64),
    /// Name of an item of an enumeration.
    Item(String),
}

/// Reads the start values of a file, none of which may be given twice.
fn each_once<'de, D: Deserializer<'de>>(file: D) -> Result<BTreeMap<String, StartValue>, D::Error> {
    struct Each;

    impl<'de> Visitor<'de> for Each {
        type Value = BTreeMap<String, StartValue>;

        fn expecting(&self, f: &mut Formatter) -> std::fmt::Result {
            f.write_str("start values by name")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut file: A) -> Result<Self::Value, A::Error> {
            let mut start = BTreeMap::new();
            while let Some((name, value)) = file.next_entry::<String, _>()? {
                if start.insert(name.clone(), value).is_some() {
                    return Err(A::Error::custom(format_args!("{name} is given twice; allowed: once")));
                }
            }
            Ok(start)
        }
    }

    file.deserialize_map(Each)
}

impl Default for Recipe {
    fn default() -> Self {
        Self::new(DEFAULT_BALLS)
    }
}

impl Recipe {
    /// `balls` balls with default start values.
    pub fn new(balls: usize) -> Self {
        Self { format: FORMAT, balls, start: BTreeMap::new() }
    }

    /// Reads what [`Recipe::to_json`] wrote.
    pub fn from_json(text: &[u8]) -> Result<Self, Refusal> {
        let recipe: Self =
            serde_json::from_slice(text).map_err(|error| Refusal::new(format_args!("not readable: {error}")))?;
        let format = recipe.format;
        ensure(format == FORMAT, || Refusal::new(format_args!("format {format} is unknown; known: {FORMAT}")))?;
        Ok(recipe)
    }

    /// The text of the file.
    pub fn to_json(&self) -> String {
        // Numbers and texts always serialize; a NaN would become null and be refused when it is read.
        let mut text = serde_json::to_string_pretty(self).unwrap_or_default();
        text.push('\n');
        text
    }

    /// The settings with these start values, checked as setters check them.
    pub fn settings(&self) -> Result<Settings, Refusal> {
        let allowed = format_args!("{MIN_BALLS} to {MAX_BALLS}");
        let known = (MIN_BALLS..=MAX_BALLS).contains(&self.balls);
        ensure(known, || Refusal::argument("balls", self.balls, allowed))?;
        let mut settings = Settings::default_for(self.balls);
        for (name, value) in &self.start {
            let variable = Variable::named(name, self.balls);
            let unknown = || Refusal::unknown(format_args!("name \"{name}\""), self.balls);
            start(variable.ok_or_else(unknown)?, value, &mut settings)?;
        }
        Ok(settings)
    }
}

fn start(variable: Variable, value: &StartValue, settings: &mut Settings) -> Result<(), Refusal> {
    variable.check_settable(false)?;
    let value = match (value, variable.row.access) {
        (StartValue::Number(value), Access::Enumeration(enumeration)) => {
            return Err(Refusal::value(variable, Number(*value), enumeration));
        }
        (StartValue::Number(value), _) => *value,
        (StartValue::Item(name), Access::Enumeration(enumeration)) => {
            let item = enumeration.items.iter().find(|item| item.name == name);
            item.ok_or_else(|| Refusal::value(variable, name, enumeration))?.value.into()
        }
        (StartValue::Item(text), _) => return Err(Refusal::value(variable, format_args!("{text:?}"), "a number")),
    };
    variable.check(value)?;
    variable.set(settings, value);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::DampingLaw;

    #[test]
    fn recipe_survives_its_file_bit_for_bit() {
        for value in [-0.1 - 1e-17, 0.1 + 0.2, 1.0 / 3.0, f64::MIN_POSITIVE, f64::MAX, 0.702481473104] {
            let mut recipe = Recipe::new(3);
            recipe.start.insert("x_start[1]".into(), StartValue::Number(value));
            recipe.start.insert("contact.dampingLaw".into(), StartValue::Item("huntCrossley".into()));
            let read = Recipe::from_json(recipe.to_json().as_bytes()).unwrap();
            assert_eq!(read, recipe);
            let parameters = read.settings().unwrap().parameters;
            assert_eq!(parameters.damping_law, DampingLaw::HuntCrossley);
            assert_eq!(parameters.x_start[0].to_bits(), value.to_bits());
        }
    }

    #[test]
    fn recipe_damage_is_refused() {
        let bad = [
            ("{\"format\":1,\"balls\":5,\"extra\":1}", "extra"),
            ("{\"format\":2,\"balls\":5}", "format 2"),
            ("{\"format\":1,\"balls\":1000000000}", "balls = 1000000000"),
            ("{\"format\":1,\"balls\":-5}", "not readable"),
            ("{\"format\":1,\"balls\":5,\"start\":{\"x_start[6]\":1}}", "x_start[6]"),
            ("{\"format\":1,\"balls\":5,\"start\":{\"x[1]\":1}}", "x[1] cannot be set"),
            ("{\"format\":1,\"balls\":5,\"start\":{\"ball.mass\":null}}", "not readable"),
            ("{\"format\":1,\"balls\":5,\"start\":{\"ball.mass\":\"heavy\"}}", "ball.mass = \"heavy\" is refused"),
            ("{\"format\":1,\"balls\":5,\"start\":{\"contact.model\":2}}", "contact.model = 2 is refused"),
            ("{\"format\":1,\"balls\":5,\"start\":{\"gravity\":1,\"gravity\":2}}", "gravity is given twice"),
        ];
        for (text, expected) in bad {
            let error =
                Recipe::from_json(text.as_bytes()).and_then(|recipe| recipe.settings()).unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
