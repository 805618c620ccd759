//! The files of an FMU.

use std::time::{Duration, UNIX_EPOCH};

use newtons_cradle::variables::{Description, FILE_NAME, MODEL_IDENTIFIER, Recipe};

use super::page;
use crate::archive::Entries;
use crate::error::Error;
use crate::platform::Platform;

/// A platform, and a shared library for it.
pub type Binary = (&'static Platform, Vec<u8>);

/// Licences in every FMU. The third-party licences are kept in the sources, so that packing needs neither Cargo nor a
/// network; a test compares them with Cargo's list.
const LICENSES: [(&str, &str); 3] = [
    ("LICENSE-MIT", include_str!("../../../LICENSE-MIT")),
    ("LICENSE-APACHE", include_str!("../../../LICENSE-APACHE")),
    ("third-party", include_str!("../../assets/third-party.txt")),
];

/// The terminals of the support and the balls, with `{i}` for the index of a ball.
const TERMINALS: &str = include_str!("../../assets/terminalsAndIcons.xml.in");

/// The terminals of a cradle of `balls` balls. With `arrays` an array is one member, without each of its elements is.
fn terminals(balls: usize, arrays: bool) -> String {
    let with = |line: &str, index: &str| line.replace("{i}", index) + "\n";
    let members = |line: &str| match arrays || !line.contains("{i}") {
        true => with(line, ""),
        false => (1..=balls).map(|index| with(line, &format!("[{index}]"))).collect(),
    };
    TERMINALS.lines().map(members).collect()
}

/// The files of an FMU of the cradle of `recipe`, with its description and these binaries.
pub fn entries(recipe: &Recipe, description: &Description, binaries: Vec<Binary>) -> Result<Entries, Error> {
    let mut entries = Entries::new();
    let mut add = |path: &str, contents: &[u8]| _ = entries.insert(path.to_owned(), contents.to_vec());
    add("modelDescription.xml", description.xml(&date()?).as_bytes());
    let picture = if description.fmi3 { "terminalsAndIcons/icon.png" } else { "model.png" };
    add(picture, include_bytes!("../../assets/model.png"));
    // FMI 2.0 has terminals since 2.0.4, with the schema of FMI 3.0.
    add("terminalsAndIcons/terminalsAndIcons.xml", terminals(recipe.balls, !description.scalars).as_bytes());
    add(&format!("resources/{FILE_NAME}"), recipe.to_json().as_bytes());
    add("documentation/index.html", page::html(description).as_bytes());
    for (name, text) in LICENSES {
        add(&format!("documentation/licenses/{name}.txt"), text.as_bytes());
    }
    for (platform, contents) in binaries {
        if !description.fmi3 {
            entries.insert(platform.path(platform.folder, MODEL_IDENTIFIER), contents);
            continue;
        }
        let parts = platform.by_tuple(MODEL_IDENTIFIER, &contents);
        for (path, part) in parts.map_err(|error| Error::Failure(format!("{}: {error}", platform.folder)))? {
            // Two binaries may get the same path: FMUs of FMI 2.0 may have Linux on ARM in two folders.
            if entries.get(&path).is_some_and(|other| *other != part) {
                return Err(Error::Failure(format!("two different shared libraries are for {path}; allowed: one")));
            }
            entries.insert(path, part);
        }
    }
    Ok(entries)
}

/// 1980-01-01, the earliest time that a zip file can hold, s since 1970.
const ZIP_EPOCH: u64 = 315_532_800;

/// The end of the year 9999, s since 1970.
const MAX_SECONDS: u64 = 253_402_300_799;

/// The time of generation as `YYYY-MM-DDThh:mm:ssZ`: `SOURCE_DATE_EPOCH`, or 1980-01-01, but not the clock, so that the
/// same arguments give the same bytes.
fn date() -> Result<String, Error> {
    let seconds = match std::env::var("SOURCE_DATE_EPOCH") {
        Ok(text) => text.parse().ok().filter(|seconds| *seconds <= MAX_SECONDS).ok_or_else(|| {
            Error::Usage(format!("SOURCE_DATE_EPOCH = {text} is refused; allowed: 0 to {MAX_SECONDS} s"))
        })?,
        Err(_) => ZIP_EPOCH,
    };
    Ok(humantime::format_rfc3339_seconds(UNIX_EPOCH + Duration::from_secs(seconds)).to_string())
}
