//! What a modelDescription.xml says, as far as the checks need it. Data alone: `reader` fills it in.

use fmi_schema::fmi2::{Causality, Initial, Variability};
use newtons_cradle::variables::{MODEL_IDENTIFIER, Type};

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
    pub event_indicators: usize,
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
}

impl Variable {
    /// What `initial` is, given or by default; nothing for inputs and the independent variable.
    pub fn initial_or_default(&self) -> Option<Initial> {
        match (&self.causality, self.variability, &self.initial) {
            (Causality::Input | Causality::Independent, ..) => None,
            (_, _, Some(initial)) => Some(initial.clone()),
            (Causality::Parameter, ..) | (_, Variability::Constant, None) => Some(Initial::Exact),
            _ => Some(Initial::Calculated),
        }
    }
}
