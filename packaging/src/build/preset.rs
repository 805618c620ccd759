//! Cradles with a name. Their parameter files are built into the program.

use newtons_cradle::variables::Settings;

use super::choice::Choice;
use crate::error::Error;

/// A cradle with a name, in the form of a parameter file.
pub struct Preset {
    /// What `--preset` calls it.
    pub name: &'static str,
    /// The parameter file; its first line says what it is.
    pub file: &'static str,
}

impl Preset {
    /// One line for the help.
    pub fn title(&self) -> &'static str {
        self.file.lines().next().unwrap_or_default().trim_start_matches("# ")
    }

    /// The preset of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        PRESETS.iter().find(|preset| preset.name == name)
    }

    /// Its start values.
    pub fn settings(&self) -> Result<Settings, Error> {
        let mut choice = Choice::default();
        choice.preset(self)?;
        choice.recipe()?.settings().map_err(|error| Error::Usage(error.to_string()))
    }
}

macro_rules! preset {
    ($name:literal) => {
        Preset { name: $name, file: include_str!(concat!("../../presets/", $name, ".toml")) }
    };
}

/// Every preset.
pub static PRESETS: &[Preset] =
    &[preset!("figure3"), preset!("figure4"), preset!("figure5"), preset!("figure6"), preset!("desk")];

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use newtons_cradle::variables::{Causality, Recipe, Shape, TABLE};

    use super::*;

    fn recipe(preset: &Preset) -> Recipe {
        let mut choice = Choice::default();
        choice.preset(preset).unwrap();
        choice.recipe().unwrap()
    }

    #[test]
    fn every_file_is_a_preset() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("presets");
        let mut files: Vec<String> =
            fs::read_dir(folder).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
        let mut presets: Vec<String> = PRESETS.iter().map(|preset| format!("{}.toml", preset.name)).collect();
        files.sort();
        presets.sort();
        assert_eq!(files, presets);
    }

    #[test]
    fn a_preset_states_every_parameter_that_has_an_effect() {
        for preset in PRESETS {
            let recipe = recipe(preset);
            let parameters = recipe.settings().unwrap().parameters;
            let stated = |name: &str| recipe.start.contains_key(name);
            for row in TABLE.iter().filter(|row| row.causality == Causality::Parameter && (row.used)(&parameters)) {
                let (preset, name) = (preset.name, row.name);
                match row.shape {
                    Shape::Scalar => assert!(stated(name) || name.starts_with("solver."), "{preset}: {name}"),
                    // The others are ratios, which are 1, and gaps, which are 0.
                    _ if name.ends_with("_start") => assert!(stated(&format!("{name}[1]")), "{preset}: {name}"),
                    _ => {}
                }
            }
        }
    }

    #[test]
    fn figures_4_and_5_are_of_the_same_run() {
        let [four, five] = ["figure4", "figure5"].map(|name| recipe(Preset::named(name).unwrap()));
        assert_eq!(four, five);
    }
}
