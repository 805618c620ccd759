//! The attributes of the model, its interfaces and its default experiment: what no schema can say of them.

use super::model::{Experiment, Model};
use crate::archive::Entries;
use crate::check::report::Report;

/// Checks what the attributes of the model and its interfaces must be.
pub fn check(model: &Model, entries: &Entries, report: &mut Report) {
    report.require(!model.name.is_empty(), "modelName is empty");
    report.require(!model.guid.is_empty(), "guid is empty");
    if let Some(date) = &model.date {
        let text = format_args!("generationDateAndTime = \"{date}\"; should be YYYY-MM-DDThh:mm:ssZ");
        report.advise(is_date(date), text);
    }
    report.require(model.interfaces().next().is_some(), "neither CoSimulation nor ModelExchange");
    for interface in model.interfaces() {
        let identifier = &interface.identifier;
        let letter = |c: char| c.is_ascii_alphabetic() || c == '_';
        let is_identifier =
            identifier.starts_with(letter) && identifier.chars().all(|c| letter(c) || c.is_ascii_digit());
        report.require(is_identifier, format_args!("modelIdentifier = \"{identifier}\" is not a C identifier"));
        let length = identifier.len();
        report.advise(length <= 63, format_args!("modelIdentifier has {length} characters; some hosts take 63"));
        report.advise(!interface.needs_tool, "needsExecutionTool: the FMU does not run by itself");
        for file in &interface.sources {
            let there = entries.contains_key(&format!("sources/{file}"));
            report.require(there, format_args!("sources/{file} is listed in SourceFiles but missing"));
        }
    }
    let Experiment { start, stop, step, tolerance } = model.experiment;
    let start = start.unwrap_or(0.0);
    let not_after = stop.is_some_and(|stop| stop <= start);
    report.require(!not_after, format_args!("DefaultExperiment: stopTime is not after startTime = {start}"));
    for (name, value) in [("stepSize", step), ("tolerance", tolerance)] {
        let not_positive = value.is_some_and(|value| value <= 0.0);
        report.require(!not_positive, format_args!("DefaultExperiment: {name} is not positive"));
    }
    report.duplicates("log category", model.log_categories.iter());
}

/// `YYYY-MM-DDThh:mm:ssZ`.
fn is_date(text: &str) -> bool {
    let shape = "dddd-dd-ddTdd:dd:ddZ";
    let fits = |(c, wanted): (u8, u8)| if wanted == b'd' { c.is_ascii_digit() } else { c == wanted };
    text.len() == shape.len() && text.bytes().zip(shape.bytes()).all(fits)
}
