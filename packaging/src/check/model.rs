//! modelDescription.xml as far as the checks need it.

use fmi_schema::fmi2::{Causality, Initial, Variability};
use newtons_cradle::variables::MODEL_IDENTIFIER;

use super::Report;
use crate::archive::Entries;

/// A description.
pub struct Model {
    /// The whole text.
    pub text: String,
    pub fmi_version: String,
    pub name: String,
    pub guid: String,
    pub tool: String,
    pub date: Option<String>,
    pub structured: bool,
    pub co_simulation: Option<Interface>,
    pub model_exchange: Option<Interface>,
    pub experiment: Experiment,
    pub units: Vec<Unit>,
    pub types: Vec<SimpleType>,
    pub log_categories: Vec<String>,
    pub variables: Vec<Variable>,
    pub structure: Structure,
}

/// A kind of FMU that it can be.
pub struct Interface {
    pub kind: Kind,
    /// modelIdentifier, the name of its binaries.
    pub identifier: String,
    pub needs_tool: bool,
    pub sources: Vec<String>,
}

/// How it is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    CoSimulation,
    ModelExchange,
}

/// The default experiment, s.
#[derive(Default)]
pub struct Experiment {
    pub start: Option<f64>,
    pub stop: Option<f64>,
    pub step: Option<f64>,
    pub tolerance: Option<f64>,
}

/// A unit and its display units.
pub struct Unit {
    pub name: String,
    pub display: Vec<String>,
}

/// A type that variables can be declared with.
pub struct SimpleType {
    pub name: String,
    pub attributes: Attributes,
}

/// Type of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Type {
    Real,
    Integer,
    Boolean,
    String,
    Enumeration,
}

/// What an element `Real`, `Integer` and so on says, of a variable or of its type.
#[derive(Clone)]
pub struct Attributes {
    pub data_type: Type,
    pub declared_type: Option<String>,
    pub unit: Option<String>,
    pub display_unit: Option<String>,
    pub min: Option<f64>,
    pub max: Option<f64>,
    pub nominal: Option<f64>,
    pub start: Option<String>,
    /// One-based index of the variable this is the derivative of.
    pub derivative: Option<usize>,
    /// Integers of the items of an enumeration.
    pub items: Vec<i32>,
}

/// A scalar variable.
pub struct Variable {
    pub name: String,
    pub reference: u32,
    pub causality: Causality,
    pub variability: Variability,
    pub initial: Option<Initial>,
    pub attributes: Attributes,
}

/// ModelStructure.
#[derive(Default)]
pub struct Structure {
    pub outputs: Option<Vec<Unknown>>,
    pub derivatives: Option<Vec<Unknown>>,
    pub initial_unknowns: Option<Vec<Unknown>>,
}

/// An unknown: one-based indices of it and of what it depends on.
pub struct Unknown {
    pub index: usize,
    pub dependencies: Option<Vec<usize>>,
    pub kinds: Option<usize>,
}

impl Model {
    /// The kinds of FMU that it can be.
    pub fn interfaces(&self) -> impl Iterator<Item = &Interface> {
        self.co_simulation.iter().chain(&self.model_exchange)
    }

    /// Whether this program writes FMUs like it.
    pub fn is_own(&self) -> bool {
        self.name == MODEL_IDENTIFIER && self.tool.starts_with("newtons-cradle ")
    }

    /// The type of that name.
    pub fn declared(&self, name: &str) -> Option<&SimpleType> {
        self.types.iter().find(|kind| kind.name == name)
    }
}

/// What the attributes of the model and its interfaces must be.
pub fn attributes(model: &Model, entries: &Entries, report: &mut Report) {
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
    super::structure::unique("log category", model.log_categories.iter(), report);
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
