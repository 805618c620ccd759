//! The parts of a modelDescription.xml that this program needs.
//!
//! The text is untrusted. roxmltree reads it without recursion, and refuses a DTD.

use newtons_cradle::variables::MODEL_IDENTIFIER;
use roxmltree::{Document, Node};

use super::report::{Report, one_line};
use crate::archive::Entries;

/// The path of the description in an FMU.
pub const FILE: &str = "modelDescription.xml";

/// The generation tool in FMUs of this version of this program.
pub const TOOL: &str = concat!("newtons-cradle ", env!("CARGO_PKG_VERSION"));

/// A description, with empty texts for absent parts. Texts have no control characters.
pub struct Model {
    pub fmi_version: String,
    pub name: String,
    /// The `guid`, or the `instantiationToken` in FMI 3.0.
    pub guid: String,
    pub tool: String,
    pub date: String,
    /// Elements such as `CoSimulation`, each with its modelIdentifier.
    pub interfaces: Vec<[String; 2]>,
    /// Start time, stop time and step size of the default experiment.
    pub experiment: [String; 3],
    /// Causality of each variable.
    pub causalities: Vec<String>,
}

impl Model {
    /// Reads the description of an FMU; none if it is not XML, or not of FMI 2.0 or 3.0.
    pub fn of(entries: &Entries, report: &mut Report) -> Option<Self> {
        let text = report.accept(format_args!("{FILE}: not in UTF-8"), std::str::from_utf8(entries.get(FILE)?))?;
        let document = report.accept(format_args!("{FILE}: not well-formed XML"), Document::parse(text))?;
        let root = document.root_element();
        if !root.has_tag_name("fmiModelDescription") {
            report.problem(format_args!("{FILE}: its root is {}, not fmiModelDescription", root.tag_name().name()));
            return None;
        }
        let model = Self::read(root);
        let version = &model.fmi_version;
        let known = model.is_fmi3() || version == "2.0";
        report.require(known, format_args!("{FILE}: fmiVersion = \"{version}\"; only 2.0 and 3.0 can be read"));
        known.then_some(model)
    }

    /// Whether it is of FMI 3.0.
    pub fn is_fmi3(&self) -> bool {
        self.fmi_version.starts_with("3.0")
    }

    /// Whether the FMU is one of this program, of any version.
    pub fn is_own(&self) -> bool {
        self.name == MODEL_IDENTIFIER && self.tool.starts_with("newtons-cradle ")
    }

    fn read(root: Node) -> Self {
        let attribute = |node: Node, name| one_line(node.attribute(name).unwrap_or_default());
        let child = |name| root.children().find(|child| child.has_tag_name(name));
        let interface = |child: Node| {
            let kind = child.tag_name().name();
            let known = matches!(kind, "CoSimulation" | "ModelExchange" | "ScheduledExecution");
            known.then(|| [kind.to_owned(), attribute(child, "modelIdentifier")])
        };
        let experiment = |name| child("DefaultExperiment").map(|child| attribute(child, name)).unwrap_or_default();
        let variables = child("ModelVariables").into_iter().flat_map(|list| list.children());
        Self {
            fmi_version: attribute(root, "fmiVersion"),
            name: attribute(root, "modelName"),
            guid: attribute(root, "guid") + &attribute(root, "instantiationToken"),
            tool: attribute(root, "generationTool"),
            date: attribute(root, "generationDateAndTime"),
            interfaces: root.children().filter_map(interface).collect(),
            experiment: ["startTime", "stopTime", "stepSize"].map(experiment),
            causalities: variables.filter(Node::is_element).map(|variable| attribute(variable, "causality")).collect(),
        }
    }
}
