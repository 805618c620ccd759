//! Validation of an FMU that this program has written, possibly with binaries from elsewhere: its entries, description
//! and binaries. Damage is reported in any file, foreign ones included.
//!
//! [`bytes()`] checks a whole FMU and returns a [`Report`]. `open`, which gives entries and description, and `Library`,
//! which looks into a binary, also serve for inspection.

mod binary;
mod model;
mod report;
mod unpack;

use std::path::Path;

use newtons_cradle::files;
use newtons_cradle::variables::{Description, FILE_NAME, MODEL_IDENTIFIER, Recipe};

use crate::archive::Entries;
use crate::error::Error;
use crate::platform::libraries;

pub(crate) use binary::Library;
pub(crate) use model::{Model, TOOL};
pub use report::Report;
pub(crate) use report::one_line;

/// The largest FMU that is read, and the largest sum of its unpacked files, bytes.
pub const MAX_BYTES: u64 = 512 << 20;

/// The bytes of an FMU, or of a binary for one.
pub fn read(path: &Path) -> Result<Vec<u8>, Error> {
    files::read(path, MAX_BYTES).map_err(|error| Error::Usage(format!("cannot read {}: {error}", path.display())))
}

/// The recipe of an FMU of this program, if it can be read.
pub(crate) fn recipe(entries: &Entries) -> Option<Recipe> {
    Recipe::from_json(entries.get(&format!("resources/{FILE_NAME}"))?).ok()
}

/// Checks an FMU in memory, without loading its binaries; unpacks at most `limit` bytes. Returns the entries for
/// further checks, if it is an FMU of this version of this program.
pub fn bytes(bytes: &[u8], limit: u64) -> (Report, Option<Entries>) {
    let (entries, model, mut report) = open(bytes, limit);
    let complete = model.is_some_and(|model| contents(&entries, &model, &mut report));
    (report, complete.then_some(entries))
}

/// The entries of an FMU, its description if it can be read, and the problems so far.
pub(crate) fn open(bytes: &[u8], limit: u64) -> (Entries, Option<Model>, Report) {
    let mut report = Report::default();
    let entries = unpack::unpack(bytes, limit, &mut report);
    let model = Model::of(&entries, &mut report);
    (entries, model, report)
}

/// Checks description and binaries. Returns whether this version could check everything.
pub(crate) fn contents(entries: &Entries, model: &Model, report: &mut Report) -> bool {
    if !model.is_own() {
        let (name, tool) = (&model.name, &model.tool);
        report.problem(format_args!(
            "\"{name}\" of \"{tool}\" is not an FMU of this program; `fmpy validate FILE` checks those of others"
        ));
        return false;
    }
    let libraries = libraries(entries, MODEL_IDENTIFIER, model.is_fmi3());
    report.require(!libraries.is_empty(), format_args!("binaries: none for {MODEL_IDENTIFIER} on any platform"));
    for (platform, path, library) in libraries {
        if report.accept(&path, platform.check(library)).is_some() {
            binary::check(&path, library, report);
        }
    }
    belongs_together(entries, model, report)
}

/// Checks that description, resources and GUID match. Returns whether this version could check it.
fn belongs_together(entries: &Entries, model: &Model, report: &mut Report) -> bool {
    let place = format!("resources/{FILE_NAME}");
    let recipe = entries.get(&place).map_or_else(|| Ok(Recipe::default()), |text| Recipe::from_json(text));
    let Some(settings) = report.accept(place, recipe.and_then(|recipe| recipe.settings())) else { return false };
    if model.tool != TOOL {
        report.remark(format_args!("written by {}: this version cannot check its GUID", model.tool));
        return false;
    }
    let descriptions = Description::all(&settings, model.is_fmi3());
    let description = descriptions.iter().find(|own| own.guid() == model.guid).unwrap_or(&descriptions[0]);
    let guid = description.guid();
    if model.guid != guid {
        report.problem(format_args!("guid = \"{}\"; that of the resources is {guid}", model.guid));
    } else if entries.get(model::FILE).is_none_or(|text| *text != description.xml(&model.date).as_bytes()) {
        report.problem("modelDescription.xml: not the description that belongs to its GUID");
    }
    let picture = if model.is_fmi3() { "terminalsAndIcons/icon.png" } else { "model.png" };
    for name in ["documentation/index.html", "documentation/licenses/third-party.txt", picture] {
        report.require(entries.contains_key(name), format_args!("{name}: missing"));
    }
    true
}
