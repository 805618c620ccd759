//! Parameter sets and reference results in the FMU, with which any host can check itself: FMI-LS-REF, a layered
//! standard of FMI (<https://github.com/modelica/fmi-ls-ref>), version 1.0.0-beta.1.
//!
//! `cases` are the cradles that a host makes of the FMU by setting parameters. `record` runs the FMU's own binary for
//! the expected results, [`add`] puts them into the FMU, and [`check()`] runs the binary again.

mod cases;
mod host;
mod record;

use std::path::{Path, PathBuf};

use newtons_cradle::variables::{Description, MODEL_IDENTIFIER, Number, START_TIME, STEP_SIZE, STOP_TIME, escaped};

use crate::archive::{self, Entries};
use crate::check::{self, Report};
use crate::error::Error;
use cases::{Case, cases};
use record::{EXPERIMENT, Failure, record};

pub use record::run;

/// The folder of the layered standard in an FMU.
const FOLDER: &str = "extra/org.fmi-standard.fmi-ls-ref";
/// The version of the layered standard that has labels. (Its text still gives the version before; its schema takes
/// any.)
const VERSION: &str = "1.0.0-beta.1";
/// The description that the standard prescribes.
const DESCRIPTION: &str = "Layered Standard providing information on related files included in an FMU.";
const PAGE: &str = include_str!("../../assets/fmi-ls-ref.txt");
/// Tolerance for other hosts, relative to the largest value of a variable.
const TOLERANCE: f64 = 1e-6;

/// Adds parameter sets and reference results to the FMU with this description. A case that its binary cannot run is
/// left out; without a binary for this machine only the sets are added. Returns what is missing and why, as ends of
/// sentences.
pub fn add(entries: &mut Entries, description: &Description) -> Vec<String> {
    let mut cases = cases(description.start);
    let names: Vec<&str> = cases.iter().map(|case| case.name).collect();
    let (mut missing, mut put) = (Vec::new(), Entries::new());
    let mut add = |name: &str, text: String| put.insert(format!("{FOLDER}/{name}"), text.into_bytes());
    let results = record(entries, &names).and_then(any);
    let with_results = results.is_ok();
    match results {
        Ok(results) => {
            let mut results = results.into_iter();
            cases.retain(|case| match results.next() {
                Some(Err(reason)) => {
                    missing.push(format!(" of {}: {reason}", case.name));
                    false
                }
                Some(Ok(csv)) => add(&format!("{}.csv", case.name), csv).is_none(),
                None => true,
            });
        }
        Err(reason) => missing.push(format!(": {reason}")),
    }
    for case in &cases {
        add(&format!("{}.ssv", case.name), case.ssv(!description.scalars));
    }
    add("fmi-ls-manifest.xml", manifest(&cases, with_results));
    entries.append(&mut put);
    entries.insert("documentation/fmi-ls-ref.txt".to_owned(), PAGE.as_bytes().to_vec());
    missing
}

/// The results, if any case has some; else the first case's reason for having none.
fn any(results: Vec<Result<String, String>>) -> Result<Vec<Result<String, String>>, Failure> {
    match results.first() {
        Some(Err(reason)) if results.iter().all(Result::is_err) => Err(Failure::Binary(reason.clone())),
        _ => Ok(results),
    }
}

/// Checks that the FMU's binary for this machine computes the FMU's reference results.
pub fn check(entries: &Entries, report: &mut Report) {
    let start = check::recipe(entries).and_then(|recipe| recipe.settings().ok());
    let cases = start.map(|start| cases(&start)).unwrap_or_default();
    let stored = |case: &Case| Some((case.name, entries.get(&format!("{FOLDER}/{}.csv", case.name))?));
    let (names, stored): (Vec<&str>, Vec<&Vec<u8>>) = cases.iter().filter_map(stored).unzip();
    if names.is_empty() {
        return report.remark("nothing was run: the FMU has no reference results");
    }
    let results = match record(entries, &names) {
        Err(reason @ Failure::Machine(_)) => return report.remark(format_args!("nothing was run: {reason}")),
        results => report.accept("reference results", results).unwrap_or_default(),
    };
    for ((name, stored), result) in names.iter().zip(stored).zip(results) {
        let Some(csv) = report.accept(format_args!("reference results: {name}"), result) else { continue };
        let same = *stored == csv.as_bytes();
        report.require(same, format_args!("{name}.csv: the binary for this machine gives other results"));
    }
}

/// Writes the reference results of the default experiment and its options in the form of FMI's tool pages,
/// `NAME_ref.csv` and `NAME_ref.opt`, for an FMU named `NAME.fmu`. Returns their paths.
pub fn beside(entries: &Entries, fmu: &Path, folder: &Path) -> Result<[PathBuf; 2], Error> {
    let results = record(entries, &[EXPERIMENT]).and_then(any);
    let csv: String = results
        .map_err(|reason| Error::Failure(format!("cannot make reference results: {reason}")))?
        .into_iter()
        .flatten()
        .collect();
    let stem = fmu.file_stem().map_or(MODEL_IDENTIFIER.into(), |stem| stem.to_string_lossy());
    let [start, stop, step, tolerance] = [START_TIME, STOP_TIME, STEP_SIZE, TOLERANCE].map(Number);
    let options = format!(
        "StartTime, {start}\nStopTime, {stop}\nStepSize, {step}\nRelTol, {tolerance}\nSolverType, FixedStep\n\
         OutputIntervalLength, {step}\n"
    );
    let files = ["csv", "opt"].map(|extension| folder.join(format!("{stem}_ref.{extension}")));
    archive::replace(&files[0], csv.as_bytes())?;
    archive::replace(&files[1], options.as_bytes())?;
    Ok(files)
}

fn manifest(cases: &[Case], results: bool) -> String {
    let mut xml = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <fmiReferences xmlns:fmi-ls=\"http://fmi-standard.org/fmi-ls-manifest\"\n    \
         fmi-ls:fmi-ls-name=\"org.fmi-standard.fmi-ls-ref\"\n    fmi-ls:fmi-ls-version=\"{VERSION}\"\n    \
         fmi-ls:fmi-ls-description=\"{DESCRIPTION}\">\n"
    );
    let mut related = |of_type: &str, source: &str, role: &str, description: &str, end: &str| {
        let description = escaped(description);
        xml += &format!(
            "  <Related type=\"{of_type}\" source=\"{source}\" role=\"{role}\" description=\"{description}\"{end}\n"
        );
    };
    for case in cases {
        let Case { name, title, .. } = case;
        let label = format!(">\n    <Label name=\"cradle:{name}\"/>\n  </Related>");
        let set = format!("{name}.ssv");
        related("application/x-ssp-parameter-set", &set, "parameter", title, &label);
        if results {
            related("text/csv", &format!("{name}.csv"), "result", &format!("Results with {set}."), &label);
        }
    }
    related("text/plain", "../../documentation/fmi-ls-ref.txt", "document", "How to use these files.", "/>");
    related("text/html", "../../documentation/index.html", "document", "Documentation of the FMU.", "/>");
    xml.push_str("</fmiReferences>\n");
    xml
}
