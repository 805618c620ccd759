//! What is in an FMU.

use std::fs;
use std::path::PathBuf;

use newtons_cradle::variables::{Description, FILE_NAME, MODEL_IDENTIFIER, Recipe};

use crate::archive::Entries;
use crate::platform::Platform;
use crate::{Error, date, page};

/// The files of an FMU for the cradle of `recipe` with these binaries.
pub fn entries(recipe: &Recipe, binaries: &[(Platform, PathBuf)]) -> Result<Entries, Error> {
    let start = recipe.settings().map_err(|error| error.to_string())?;
    let mut entries = Entries::new();
    let mut add = |path: String, contents: Vec<u8>| entries.insert(path, contents);
    add("modelDescription.xml".into(), Description::of(&start).xml(&date::generation()?).into());
    add("model.png".into(), include_bytes!("../assets/model.png").into());
    add(format!("resources/{FILE_NAME}"), recipe.to_json().into());
    add("documentation/index.html".into(), page::html(&start).into());
    add("documentation/licenses/LICENSE-MIT.txt".into(), include_bytes!("../../LICENSE-MIT").into());
    add("documentation/licenses/LICENSE-APACHE.txt".into(), include_bytes!("../../LICENSE-APACHE").into());
    for (platform, file) in binaries {
        let contents = fs::read(file).map_err(|error| format!("cannot read {}: {error}", file.display()))?;
        add(format!("binaries/{}/{MODEL_IDENTIFIER}.{}", platform.folder, platform.extension), contents);
    }
    Ok(entries)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_standard() {
        let platform = Platform { folder: "linux64", extension: "so" };
        let binary = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"));
        let entries = entries(&Recipe::default(), &[(platform, binary)]).unwrap();
        let names: Vec<&str> = entries.keys().map(String::as_str).collect();
        assert_eq!(
            names,
            [
                "binaries/linux64/NewtonsCradle.so",
                "documentation/index.html",
                "documentation/licenses/LICENSE-APACHE.txt",
                "documentation/licenses/LICENSE-MIT.txt",
                "model.png",
                "modelDescription.xml",
                "resources/cradle.json",
            ]
        );
        assert!(entries.values().all(|contents| !contents.is_empty()));
        assert!(entries["model.png"].starts_with(b"\x89PNG"));
    }

    #[test]
    fn a_missing_binary_is_named() {
        let platform = Platform { folder: "linux64", extension: "so" };
        let error = entries(&Recipe::default(), &[(platform, "/nowhere/lib.so".into())]).unwrap_err();
        assert!(error.contains("/nowhere/lib.so"), "{error}");
    }
}
