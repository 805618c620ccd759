//! What a modelDescription.xml says, as far as the checks need it. Data alone: `reader` fills it in.

use fmi_schema::fmi2::{Causality, Initial, Variability};
use newtons_cradle::variables::{MODEL_IDENTIFIER, Type};

use crate::platform::Platform;

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
    /// Variables and structure of FMI 3.0, whose FMUs have none of the two above.
    pub arrays: Vec<Array>,
    pub unknowns: Vec<ArrayUnknown>,
    pub type_names: Vec<String>,
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

/// A variable of FMI 3.0.
pub struct Array {
    /// Name of its element, which is its type.
    pub element: String,
    pub name: String,
    pub reference: u32,
    pub causality: String,
    pub variability: String,
    pub initial: Option<String>,
    pub start: Option<String>,
    pub declared_type: Option<String>,
    pub unit: Option<String>,
    /// Value references of the structural parameters that it is sized by, or sizes.
    pub dimensions: Vec<Result<u32, usize>>,
    pub clocks: Vec<u32>,
}

/// An entry of ModelStructure in FMI 3.0: the name of its element, whose it is, and what that depends on.
pub struct ArrayUnknown {
    pub list: String,
    pub reference: u32,
    pub dependencies: Option<Vec<u32>>,
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

    /// Whether it is one of FMI 3.0.
    pub fn is_fmi3(&self) -> bool {
        self.fmi_version.starts_with('3')
    }

    /// Where the FMU has the shared library for this machine, if it can have one.
    pub fn host_binary(&self, identifier: &str) -> Option<String> {
        let platform = Platform::host().ok()?;
        if self.is_fmi3() { platform.host_path(identifier) } else { Some(platform.binary_path(identifier)) }
    }

    /// Number of balls of one of our own.
    pub fn balls(&self) -> usize {
        let start = self.arrays.iter().find(|array| array.name == "n").and_then(|array| array.start.as_deref());
        let elements = self.variables.iter().filter(|variable| variable.name.starts_with("x[")).count();
        start.and_then(|start| start.parse().ok()).unwrap_or(elements)
    }

    /// Number of elements of a variable of FMI 3.0 with the start values of the structural parameters.
    pub fn elements(&self, array: &Array) -> usize {
        let size = |reference: &u32| {
            let parameter = self.arrays.iter().find(|other| other.reference == *reference)?;
            parameter.start.as_deref()?.trim().parse::<usize>().ok()
        };
        array
            .dimensions
            .iter()
            .map(|dimension| dimension.as_ref().map_or_else(|size| *size, |of| size(of).unwrap_or(0)))
            .product()
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
