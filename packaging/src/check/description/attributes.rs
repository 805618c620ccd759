//! The attributes of the model, its interfaces and its default experiment: what no schema can say of them.

use super::model::{Experiment, Model};
use crate::archive::Entries;
use crate::check::report::Report;

/// Checks what the attributes of the model and its interfaces must be.
pub fn check(model: &Model, entries: &Entries, report: &mut Report) {
    if model.name.is_empty() {
        report.problem("modelName is empty");
    }
    if model.guid.is_empty() {
        report.problem("guid is empty");
    }
    if let Some(date) = &model.date
        && !is_date(date)
    {
        report.remark(format_args!("generationDateAndTime = \"{date}\"; should be YYYY-MM-DDThh:mm:ssZ"));
    }
    if model.interfaces().next().is_none() {
        report.problem("neither CoSimulation nor ModelExchange");
    }
    for interface in model.interfaces() {
        let identifier = &interface.identifier;
        let allowed = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if !identifier.chars().all(allowed)
            || identifier.starts_with(|c: char| c.is_ascii_digit())
            || identifier.is_empty()
        {
            report.problem(format_args!("modelIdentifier = \"{identifier}\" is no identifier of C"));
        }
        if identifier.len() > 63 {
            report.remark(format_args!("modelIdentifier has {} characters; some hosts take 63", identifier.len()));
        }
        if interface.needs_tool {
            report.remark("needsExecutionTool: the FMU does not run by itself");
        }
        for file in &interface.sources {
            if !entries.contains_key(&format!("sources/{file}")) {
                report.problem(format_args!("sources/{file} is listed in SourceFiles and missing"));
            }
        }
    }
    let Experiment { start, stop, step, tolerance } = model.experiment;
    let start = start.unwrap_or(0.0);
    if stop.is_some_and(|stop| stop <= start) {
        report.problem(format_args!("DefaultExperiment: stopTime is not after startTime = {start}"));
    }
    for (name, value) in [("stepSize", step), ("tolerance", tolerance)] {
        if value.is_some_and(|value| value <= 0.0) {
            report.problem(format_args!("DefaultExperiment: {name} is not positive"));
        }
    }
    report.duplicates("log category", model.log_categories.iter());
}

/// `YYYY-MM-DDThh:mm:ssZ`.
fn is_date(text: &str) -> bool {
    let shape = "dddd-dd-ddTdd:dd:ddZ";
    text.len() == shape.len()
        && text
            .chars()
            .zip(shape.chars())
            .all(|(c, wanted)| if wanted == 'd' { c.is_ascii_digit() } else { c == wanted })
}
