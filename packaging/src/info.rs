//! What is in an FMU, for people.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;

use newtons_cradle::variables::{FILE_NAME, Recipe, Variable};

use crate::archive::Entries;
use crate::build;
use crate::check::{self, Library, MAX_BYTES, Model, Report};
use crate::error::Error;
use crate::platform::PLATFORMS;

/// A page of text on the FMU in a file.
pub fn of(path: &Path) -> Result<String, Error> {
    bytes(&check::read(path)?, MAX_BYTES)
        .map_err(|reason| Error::Usage(format!("cannot read {}: {reason}", path.display())))
}

/// The same of an FMU in memory, of which at most `limit` bytes are unpacked; else why it cannot be read.
pub fn bytes(bytes: &[u8], limit: u64) -> Result<String, String> {
    let mut report = Report::default();
    let entries = check::unpack(bytes, limit, &mut report).unwrap_or_default();
    let Some(model) = entries.get("modelDescription.xml").and_then(|text| Model::read(text, &mut report)) else {
        return Err(report.problems.first().cloned().unwrap_or_default());
    };
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write(&mut out, &model, &entries);
    Ok(out)
}

fn write(out: &mut String, model: &Model, entries: &Entries) -> std::fmt::Result {
    let kinds: Vec<&str> = model.interfaces.iter().map(|(kind, _)| kind.as_str()).collect();
    writeln!(out, "model        {} (FMI {}, {})", model.name, model.fmi_version, kinds.join(", "))?;
    writeln!(out, "{:12} {}", if model.is_fmi3() { "token" } else { "guid" }, model.guid)?;
    writeln!(out, "written by   {}, {}", model.tool, if model.date.is_empty() { "no date" } else { &model.date })?;
    write_cradle(out, model, entries)?;
    let seconds = |value: &String| if value.is_empty() { "-".to_owned() } else { format!("{value} s") };
    let [start, stop, step] = model.experiment.each_ref().map(seconds);
    writeln!(out, "experiment   start {start}, stop {stop}, step {step}")?;
    let count = |causality: &str| model.variables.get(causality).copied().unwrap_or_default();
    writeln!(
        out,
        "variables    {}: {} parameters, {} inputs, {} outputs, {} locals",
        model.variables.values().sum::<usize>(),
        count("parameter") + count("calculatedParameter"),
        count("input"),
        count("output"),
        count("local")
    )?;
    let identifiers: BTreeSet<&String> = model.interfaces.iter().map(|(_, identifier)| identifier).collect();
    for identifier in identifiers {
        for platform in PLATFORMS {
            for path in platform.paths(identifier, model.is_fmi3()) {
                if let Some(bytes) = entries.get(&path) {
                    write_library(out, path.split('/').nth(1).unwrap_or_default(), bytes)?;
                }
            }
        }
    }
    writeln!(out, "files")?;
    entries.iter().try_for_each(|(name, contents)| writeln!(out, "{:>12} {name}", contents.len()))
}

/// Number of balls and start values that are not the defaults.
fn write_cradle(out: &mut String, model: &Model, entries: &Entries) -> std::fmt::Result {
    let Some(Ok(recipe)) = entries.get(&format!("resources/{FILE_NAME}")).map(|text| Recipe::from_json(text)) else {
        return Ok(());
    };
    if !model.is_own() {
        return Ok(());
    }
    writeln!(out, "balls        {}", recipe.balls)?;
    for (name, value) in &recipe.start {
        if let Some(variable) = Variable::named(name, recipe.balls) {
            writeln!(out, "             {}", build::in_words(variable, value))?;
        }
    }
    Ok(())
}

fn write_library(out: &mut String, folder: &str, bytes: &[u8]) -> std::fmt::Result {
    write!(out, "{folder:12} {} kB", bytes.len().div_ceil(1000))?;
    match Library::read(bytes) {
        Ok(libraries) => {
            let universal = libraries.len() > 1;
            libraries.into_iter().try_for_each(|library| write_one(out, library, universal))?;
            writeln!(out)
        }
        Err(error) => writeln!(out, ", {error}"),
    }
}

fn write_one(out: &mut String, library: Library, universal: bool) -> std::fmt::Result {
    if universal {
        write!(out, "; {:?}", library.architecture)?;
    }
    if let Some((major, minor)) = library.glibc {
        write!(out, ", for glibc {major}.{minor} or newer")?;
    }
    if let Some((major, minor)) = library.macos {
        let signed = if library.signed { "signed" } else { "not signed" };
        write!(out, ", for macOS {major}.{minor} or newer, {signed}")?;
    }
    let libraries: Vec<String> = library.libraries.into_iter().collect();
    write!(out, ", linked with {}", libraries.join(", "))
}
