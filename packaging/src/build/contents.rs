//! What is in an FMU.

use newtons_cradle::variables::{Description, FILE_NAME, MODEL_IDENTIFIER, Recipe};

use super::{date, page};
use crate::archive::Entries;
use crate::error::Error;
use crate::platform::Platform;

/// A shared library and the platform it was made for.
pub struct Binary {
    /// What it was compiled for.
    pub platform: &'static Platform,
    /// The shared library.
    pub contents: Vec<u8>,
}

/// The version of the standard that an FMU follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Standard {
    /// FMI 2.0.
    #[default]
    Fmi2,
    /// FMI 3.0.
    Fmi3,
}

/// What connects to the support and to the balls.
const TERMINALS: &str = include_str!("../../assets/terminalsAndIcons.xml");

/// The files of an FMU for the cradle of `recipe` with these binaries.
pub fn entries(recipe: &Recipe, binaries: Vec<Binary>, standard: Standard) -> Result<Entries, Error> {
    let start = recipe.settings().map_err(|error| Error::Usage(error.to_string()))?;
    let mut entries = Entries::new();
    let mut add = |path: String, contents: Vec<u8>| entries.insert(path, contents);
    let picture = include_bytes!("../../assets/model.png");
    if standard == Standard::Fmi3 {
        add("modelDescription.xml".into(), Description::fmi3(&start).xml(&date::generation()?).into());
        add("terminalsAndIcons/terminalsAndIcons.xml".into(), TERMINALS.into());
        add("terminalsAndIcons/icon.png".into(), picture.into());
    } else {
        add("modelDescription.xml".into(), Description::of(&start).xml(&date::generation()?).into());
        add("model.png".into(), picture.into());
    }
    add(format!("resources/{FILE_NAME}"), recipe.to_json().into());
    add("documentation/index.html".into(), page::html(&start, standard).into());
    add("documentation/licenses/LICENSE-MIT.txt".into(), include_bytes!("../../../LICENSE-MIT").into());
    add("documentation/licenses/LICENSE-APACHE.txt".into(), include_bytes!("../../../LICENSE-APACHE").into());
    // Kept in the sources, so that packing needs neither Cargo nor a network; a test compares it with what Cargo knows.
    add("documentation/licenses/third-party.txt".into(), include_bytes!("../../assets/third-party.txt").into());
    for Binary { platform, contents } in binaries {
        if standard == Standard::Fmi2 {
            add(platform.binary_path(MODEL_IDENTIFIER), contents);
            continue;
        }
        let parts = platform.by_tuple(MODEL_IDENTIFIER, &contents);
        for (path, part) in parts.map_err(|error| Error::Failure(format!("{}: {error}", platform.folder)))? {
            add(path, part);
        }
    }
    Ok(entries)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_standard() {
        let binary = Binary { platform: Platform::named("linux64").unwrap(), contents: b"binary".to_vec() };
        let entries = entries(&Recipe::default(), vec![binary], Standard::Fmi2).unwrap();
        let names: Vec<&str> = entries.keys().map(String::as_str).collect();
        assert_eq!(
            names,
            [
                "binaries/linux64/NewtonsCradle.so",
                "documentation/index.html",
                "documentation/licenses/LICENSE-APACHE.txt",
                "documentation/licenses/LICENSE-MIT.txt",
                "documentation/licenses/third-party.txt",
                "model.png",
                "modelDescription.xml",
                "resources/cradle.json",
            ]
        );
        assert!(entries.values().all(|contents| !contents.is_empty()));
        assert!(entries["model.png"].starts_with(b"\x89PNG"));
    }
}
