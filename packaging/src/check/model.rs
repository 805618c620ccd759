//! modelDescription.xml as far as the checks need it. The schema itself is `fmi-schema`'s business.

use std::panic::catch_unwind;
use std::str::FromStr;

use fmi_schema::fmi2::{Causality, Fmi2ModelDescription, Initial, Variability};
use fmi_schema::traits::FmiModelDescription;
use newtons_cradle::variables::MODEL_IDENTIFIER;
use roxmltree::{Document, Node, ParsingOptions};

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
    /// Reads a description; nothing if it is no XML or not of FMI 2.0.
    pub fn read(bytes: &[u8], report: &mut Report) -> Option<Self> {
        let place = "modelDescription.xml";
        let text = match std::str::from_utf8(bytes) {
            Ok(text) => text.trim_start_matches('\u{feff}'),
            Err(error) => {
                report.problem(format_args!("{place}: not in UTF-8: {error}"));
                return None;
            }
        };
        let options = ParsingOptions { nodes_limit: 20_000_000, ..ParsingOptions::default() };
        let document = match Document::parse_with_options(text, options) {
            Ok(document) => document,
            Err(error) => {
                report.problem(format_args!("{place}: not well-formed XML: {error}"));
                return None;
            }
        };
        let root = document.root_element();
        if root.tag_name().name() != "fmiModelDescription" || root.attribute("fmiVersion") != Some("2.0") {
            let version = root.attribute("fmiVersion").unwrap_or_default();
            report.problem(format_args!("{place}: fmiVersion = \"{version}\"; only 2.0 can be checked"));
            return None;
        }
        check_schema(text, &root, report);
        let reader = &mut Reader { report };
        let interface = |kind: Kind, reader: &mut Reader| {
            let node = child(root, if kind == Kind::CoSimulation { "CoSimulation" } else { "ModelExchange" })?;
            let files = child(node, "SourceFiles").into_iter().flat_map(|node| children(node, "File"));
            Some(Interface {
                kind,
                identifier: reader.text(node, "modelIdentifier"),
                needs_tool: matches!(node.attribute("needsExecutionTool"), Some("true" | "1")),
                sources: files.map(|file| reader.text(file, "name")).collect(),
            })
        };
        Some(Self {
            text: text.to_owned(),
            fmi_version: reader.text(root, "fmiVersion"),
            name: reader.text(root, "modelName"),
            guid: reader.text(root, "guid"),
            tool: root.attribute("generationTool").unwrap_or_default().to_owned(),
            date: root.attribute("generationDateAndTime").map(str::to_owned),
            structured: root.attribute("variableNamingConvention") == Some("structured"),
            co_simulation: interface(Kind::CoSimulation, reader),
            model_exchange: interface(Kind::ModelExchange, reader),
            experiment: child(root, "DefaultExperiment").map(|node| reader.experiment(node)).unwrap_or_default(),
            units: list(root, "UnitDefinitions", "Unit").map(|node| reader.unit(node)).collect(),
            types: list(root, "TypeDefinitions", "SimpleType").filter_map(|node| reader.simple_type(node)).collect(),
            log_categories: list(root, "LogCategories", "Category").map(|node| reader.text(node, "name")).collect(),
            variables: list(root, "ModelVariables", "ScalarVariable")
                .filter_map(|node| reader.variable(node))
                .collect(),
            structure: child(root, "ModelStructure").map(|node| reader.structure(node)).unwrap_or_default(),
        })
    }

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

/// The schema, as strictly as `fmi-schema` has it.
fn check_schema(text: &str, root: &Node, report: &mut Report) {
    // It takes for granted what a schema would check first.
    let read = catch_unwind(|| Fmi2ModelDescription::deserialize(text).map_err(|error| error.to_string()));
    let error = match read {
        Ok(Ok(_)) => return,
        Ok(Err(error)) => error,
        Err(_) => "an element that is not where it belongs".to_owned(),
    };
    let text = format!("modelDescription.xml: not what the schema asks for: {error}");
    // References to a schema are allowed, and it does not know them.
    if root.namespaces().len() > 0 { report.remark(text) } else { report.problem(text) }
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

fn child<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Option<Node<'a, 'input>> {
    node.children().find(|child| child.has_tag_name(name))
}

fn children<'a, 'input: 'a>(node: Node<'a, 'input>, name: &'static str) -> impl Iterator<Item = Node<'a, 'input>> {
    node.children().filter(move |child| child.has_tag_name(name))
}

fn list<'a, 'input: 'a>(
    root: Node<'a, 'input>,
    list: &'static str,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'input>> {
    child(root, list).into_iter().flat_map(move |list| children(list, name))
}

/// Reads attributes, and reports those that are missing or cannot be read.
struct Reader<'a> {
    report: &'a mut Report,
}

impl Reader<'_> {
    fn text(&mut self, node: Node, key: &str) -> String {
        if let Some(text) = node.attribute(key) {
            return text.to_owned();
        }
        self.report.problem(format_args!("{}: {key} is missing", place(node)));
        String::new()
    }

    /// An attribute that may be absent.
    fn value<T: FromStr>(&mut self, node: Node, key: &str) -> Option<T> {
        let text = node.attribute(key)?;
        let value = text.trim().parse().ok();
        if value.is_none() {
            self.report.problem(format_args!("{}: {key} = \"{text}\" cannot be read", place(node)));
        }
        value
    }

    fn indices(&mut self, node: Node, key: &str) -> Option<Vec<usize>> {
        let text = node.attribute(key)?;
        let indices: Result<Vec<usize>, _> = text.split_whitespace().map(str::parse).collect();
        if indices.is_err() {
            self.report.problem(format_args!("{}: {key} is no list of indices", place(node)));
        }
        indices.ok()
    }

    fn experiment(&mut self, node: Node) -> Experiment {
        Experiment {
            start: self.value(node, "startTime"),
            stop: self.value(node, "stopTime"),
            step: self.value(node, "stepSize"),
            tolerance: self.value(node, "tolerance"),
        }
    }

    fn unit(&mut self, node: Node) -> Unit {
        let display = children(node, "DisplayUnit").map(|node| self.text(node, "name")).collect();
        Unit { name: self.text(node, "name"), display }
    }

    fn simple_type(&mut self, node: Node) -> Option<SimpleType> {
        Some(SimpleType { name: self.text(node, "name"), attributes: self.attributes(node)? })
    }

    fn attributes(&mut self, node: Node) -> Option<Attributes> {
        const TYPES: [(&str, Type); 5] = [
            ("Real", Type::Real),
            ("Integer", Type::Integer),
            ("Boolean", Type::Boolean),
            ("String", Type::String),
            ("Enumeration", Type::Enumeration),
        ];
        let element =
            |node: Node<'_, '_>| TYPES.iter().find(|(name, _)| node.has_tag_name(*name)).map(|(_, kind)| *kind);
        let Some((node, data_type)) = node.children().find_map(|node| Some((node, element(node)?))) else {
            self.report.problem(format_args!("{}: has no data type", place(node)));
            return None;
        };
        let owned = |key: &str| node.attribute(key).map(str::to_owned);
        Some(Attributes {
            data_type,
            declared_type: owned("declaredType"),
            unit: owned("unit"),
            display_unit: owned("displayUnit"),
            min: self.value(node, "min"),
            max: self.value(node, "max"),
            nominal: self.value(node, "nominal"),
            start: owned("start"),
            derivative: self.value(node, "derivative"),
            items: children(node, "Item").filter_map(|item| self.value(item, "value")).collect(),
        })
    }

    fn variable(&mut self, node: Node) -> Option<Variable> {
        Some(Variable {
            name: self.text(node, "name"),
            reference: self.value(node, "valueReference")?,
            causality: self.value(node, "causality").unwrap_or_default(),
            variability: self.value(node, "variability").unwrap_or_default(),
            initial: self.value(node, "initial"),
            attributes: self.attributes(node)?,
        })
    }

    fn structure(&mut self, node: Node) -> Structure {
        let mut unknowns = |name| {
            let list = child(node, name)?;
            Some(children(list, "Unknown").filter_map(|node| self.unknown(node)).collect())
        };
        Structure {
            outputs: unknowns("Outputs"),
            derivatives: unknowns("Derivatives"),
            initial_unknowns: unknowns("InitialUnknowns"),
        }
    }

    fn unknown(&mut self, node: Node) -> Option<Unknown> {
        Some(Unknown {
            index: self.value(node, "index")?,
            dependencies: self.indices(node, "dependencies"),
            kinds: node.attribute("dependenciesKind").map(|kinds| kinds.split_whitespace().count()),
        })
    }
}

/// Where a finding is: the element with its name, if it has one.
fn place(node: Node) -> String {
    let named = node.ancestors().find_map(|node| node.attribute("name"));
    let name = named.map(|name| format!(" of {name}")).unwrap_or_default();
    format!("{}{name}", node.tag_name().name())
}
