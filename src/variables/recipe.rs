//! What the producer writes into the FMU's resources and the instance reads from there: n and changed start values.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::error::VariableError;
use super::settings::Settings;
use super::table::row::{Access, Type};
use super::variable::{DEFAULT_BALLS, MAX_BALLS, MIN_BALLS, Variable};

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
    #[serde(default)]
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

/// Why a recipe cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RecipeError {
    /// Not the JSON that is expected.
    Damaged(String),
    /// Written by a newer version.
    Format(u32),
    /// Number of balls outside of what is allowed.
    Balls(usize),
    /// A start value that is not accepted.
    Start(VariableError),
}

impl std::fmt::Display for RecipeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Damaged(reason) => write!(f, "not readable: {reason}"),
            Self::Format(format) => write!(f, "format {format} is unknown; known: {FORMAT}"),
            Self::Balls(balls) => write!(f, "balls = {balls} is refused; allowed: {MIN_BALLS} to {MAX_BALLS}"),
            Self::Start(refused) => write!(f, "{refused}"),
        }
    }
}

impl std::error::Error for RecipeError {}

impl From<VariableError> for RecipeError {
    fn from(error: VariableError) -> Self {
        Self::Start(error)
    }
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
    pub fn from_json(text: &[u8]) -> Result<Self, RecipeError> {
        let recipe: Self = serde_json::from_slice(text).map_err(|error| RecipeError::Damaged(error.to_string()))?;
        if recipe.format == FORMAT { Ok(recipe) } else { Err(RecipeError::Format(recipe.format)) }
    }

    /// The text of the file.
    pub fn to_json(&self) -> String {
        // Numbers and texts always serialize; a NaN would become null and be refused when it is read.
        let mut text = serde_json::to_string_pretty(self).unwrap_or_default();
        text.push('\n');
        text
    }

    /// The start values, each checked as a setter checks it.
    pub fn settings(&self) -> Result<Settings, RecipeError> {
        if !(MIN_BALLS..=MAX_BALLS).contains(&self.balls) {
            return Err(RecipeError::Balls(self.balls));
        }
        let mut settings = Settings::default_for(self.balls);
        for (name, value) in &self.start {
            let Some(variable) = Variable::named(name, self.balls) else {
                return Err(VariableError::UnknownName { name: name.clone(), balls: self.balls }.into());
            };
            start(variable, value, &mut settings)?;
        }
        Ok(settings)
    }
}

fn start(variable: Variable, value: &StartValue, settings: &mut Settings) -> Result<(), VariableError> {
    match value {
        StartValue::Number(value) => {
            variable.check_settable(Type::Real, false)?;
            variable.check_real(*value)?;
            variable.set_real(settings, *value);
        }
        StartValue::Item(name) => {
            variable.check_settable(Type::Integer, false)?;
            let Access::Enumeration(enumeration) = variable.row.access else {
                return Err(variable.wrong_type(Type::Enumeration));
            };
            let Some(item) = enumeration.named(name) else {
                return Err(VariableError::not_allowed(variable, name, enumeration));
            };
            variable.set_item(settings, item.value);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::DampingLaw;

    #[test]
    fn a_recipe_survives_its_file_bit_for_bit() {
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
    fn damage_is_told() {
        let bad = [
            ("", "not readable"),
            ("{\"format\":1,\"balls\":5", "not readable"),
            ("{\"format\":1,\"balls\":5,\"extra\":1}", "extra"),
            ("{\"format\":2,\"balls\":5}", "format 2"),
            ("{\"format\":1,\"balls\":0}", "balls = 0 is refused; allowed: 1 to 10000"),
            ("{\"format\":1,\"balls\":1000000000}", "balls = 1000000000"),
            ("{\"format\":1,\"balls\":-5}", "not readable"),
            ("{\"format\":1,\"balls\":5,\"start\":{\"x_start[6]\":1}}", "x_start[6]"),
            ("{\"format\":1,\"balls\":5,\"start\":{\"x[1]\":1}}", "x[1] cannot be set"),
            ("{\"format\":1,\"balls\":5,\"start\":{\"ball.mass\":0}}", "ball.mass = 0 kg"),
            ("{\"format\":1,\"balls\":5,\"start\":{\"ball.mass\":null}}", "not readable"),
            ("{\"format\":1,\"balls\":5,\"start\":{\"ball.mass\":\"heavy\"}}", "ball.mass is of type Real"),
            (
                "{\"format\":1,\"balls\":5,\"start\":{\"contact.model\":\"glue\"}}",
                "powerLaw (1) or hertz (2) or rigid (3)",
            ),
        ];
        for (text, expected) in bad {
            let error =
                Recipe::from_json(text.as_bytes()).and_then(|recipe| recipe.settings()).unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
