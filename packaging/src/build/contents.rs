//! What is in an FMU.

use newtons_cradle::variables::{Description, FILE_NAME, MODEL_IDENTIFIER, Recipe};

use super::standard::Standard;
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

/// What connects to the support and to the balls.
const TERMINALS: &str = include_str!("../../assets/terminalsAndIcons.xml");

/// The files of an FMU for the cradle of `recipe` with these binaries.
pub fn entries(recipe: &Recipe, binaries: Vec<Binary>, standard: Standard) -> Result<Entries, Error> {
    let start = recipe.settings().map_err(|error| Error::Usage(error.to_string()))?;
    let mut entries = Entries::new();
    let mut add = |path: String, contents: Vec<u8>| _ = entries.insert(path, contents);
    let picture = include_bytes!("../../assets/model.png");
    if let Standard::Fmi3 { clocks } = standard {
        let description = Description::fmi3(&start);
        let description = if clocks { description } else { description.without_clocks() };
        add("modelDescription.xml".into(), description.xml(&date::generation()?).into());
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
            entries.insert(platform.binary_path(MODEL_IDENTIFIER), contents);
            continue;
        }
        let parts = platform.by_tuple(MODEL_IDENTIFIER, &contents);
        for (path, part) in parts.map_err(|error| Error::Failure(format!("{}: {error}", platform.folder)))? {
            add_library(&mut entries, path, part)?;
        }
    }
    Ok(entries)
}

/// Adds a shared library. A place can be asked for twice: FMUs of FMI 2.0 may have one for Linux on ARM in two folders.
fn add_library(entries: &mut Entries, path: String, library: Vec<u8>) -> Result<(), Error> {
    if entries.get(&path).is_some_and(|other| *other != library) {
        return Err(Error::Failure(format!("two different shared libraries are for {path}; allowed: one")));
    }
    entries.insert(path, library);
    Ok(())
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

    #[test]
    fn a_place_is_for_one_shared_library() {
        let mut entries = Entries::new();
        let mut add =
            |library: &[u8]| add_library(&mut entries, "binaries/aarch64-linux/a.so".into(), library.to_vec());
        assert!(add(b"arm").is_ok() && add(b"arm").is_ok());
        assert!(
            add(b"another")
                .unwrap_err()
                .to_string()
                .contains("two different shared libraries are for binaries/aarch64")
        );
        assert_eq!(entries["binaries/aarch64-linux/a.so"], b"arm");
    }
}
