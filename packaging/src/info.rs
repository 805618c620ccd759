//! The contents of an FMU, as text. Names and texts from the FMU are shown without control characters.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;

use newtons_cradle::variables::Variable;

use crate::archive::Entries;
use crate::check::{self, Library, MAX_BYTES, Model};
use crate::error::Error;
use crate::platform::libraries;

/// A summary of the FMU in a file.
pub fn of(path: &Path) -> Result<String, Error> {
    let (entries, model, report) = check::open(&check::read(path)?, MAX_BYTES);
    let reason = || report.problems.first().map_or("", String::as_str);
    let model = model.ok_or_else(|| Error::Usage(format!("cannot read {}: {}", path.display(), reason())))?;
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write(&mut out, &model, &entries);
    Ok(out)
}

fn write(out: &mut String, model: &Model, entries: &Entries) -> std::fmt::Result {
    let kinds: Vec<&str> = model.interfaces.iter().map(|[kind, _]| kind.as_str()).collect();
    writeln!(out, "model        {} (FMI {}, {})", model.name, model.fmi_version, kinds.join(", "))?;
    writeln!(out, "{:12} {}", if model.is_fmi3() { "token" } else { "guid" }, model.guid)?;
    writeln!(out, "written by   {}, {}", model.tool, if model.date.is_empty() { "no date" } else { &model.date })?;
    if let Some(recipe) = check::recipe(entries).filter(|_| model.is_own()) {
        writeln!(out, "balls        {}", recipe.balls)?;
        // Start values that are not the defaults.
        match recipe.settings() {
            Ok(settings) => {
                for variable in recipe.start.keys().filter_map(|name| Variable::named(name, recipe.balls)) {
                    let value = variable.row.quantified(variable.text(&settings).unwrap_or_default());
                    writeln!(out, "             {variable} = {value}")?;
                }
            }
            Err(refusal) => writeln!(out, "             {}", check::one_line(refusal))?,
        }
    }
    let seconds = |value: &String| if value.is_empty() { "-".to_owned() } else { format!("{value} s") };
    let [start, stop, step] = model.experiment.each_ref().map(seconds);
    writeln!(out, "experiment   start {start}, stop {stop}, step {step}")?;
    let all = &model.causalities;
    let counted = [&["parameter", "calculatedParameter"][..], &["input"], &["output"], &["local", ""]];
    let [parameters, inputs, outputs, locals] =
        counted.map(|kinds| all.iter().filter(|own| kinds.contains(&own.as_str())).count());
    let all = all.len();
    writeln!(out, "variables    {all}: {parameters} parameters, {inputs} inputs, {outputs} outputs, {locals} locals")?;
    let identifiers: BTreeSet<&String> = model.interfaces.iter().map(|[_, identifier]| identifier).collect();
    let libraries = identifiers.into_iter().flat_map(|identifier| libraries(entries, identifier, model.is_fmi3()));
    let libraries: Vec<_> = libraries.collect();
    for (_, path, library) in &libraries {
        write_library(out, path.split('/').nth(1).unwrap_or_default(), library)?;
    }
    writeln!(out, "files")?;
    let mut others = entries.iter().filter(|(name, _)| libraries.iter().all(|(_, path, _)| path != *name));
    others.try_for_each(|(name, contents)| writeln!(out, "{:>12} {}", contents.len(), check::one_line(name)))
}

fn write_library(out: &mut String, folder: &str, bytes: &[u8]) -> std::fmt::Result {
    write!(out, "{folder:12} {} kB", bytes.len().div_ceil(1000))?;
    let libraries = match Library::read(bytes) {
        Ok(libraries) => libraries,
        Err(error) => return writeln!(out, ", {error}"),
    };
    for library in &libraries {
        if libraries.len() > 1 {
            write!(out, "; {:?}", library.architecture)?;
        }
        if let Some((major, minor)) = library.glibc {
            write!(out, ", for glibc {major}.{minor} or newer")?;
        }
        if let Some((major, minor)) = library.macos {
            let signed = if library.signed { "signed" } else { "not signed" };
            write!(out, ", for macOS {major}.{minor} or newer, {signed}")?;
        }
        let linked: Vec<&str> = library.libraries.iter().map(String::as_str).collect();
        write!(out, ", linked with {}", linked.join(", "))?;
    }
    writeln!(out)
}
