//! Reading modelDescription.xml. The schema itself is `fmi-schema`'s business.

use std::panic::catch_unwind;
use std::str::FromStr;

use fmi_schema::fmi2::Fmi2ModelDescription;
use fmi_schema::fmi3::Fmi3ModelDescription;
use fmi_schema::traits::FmiModelDescription;
use newtons_cradle::variables::Type;
use roxmltree::{Document, Node, ParsingOptions};

use super::model::{
    Array, ArrayUnknown, Attributes, Experiment, Interface, Kind, Model, SimpleType, Structure, Unit, Unknown, Variable,
};
use crate::check::report::Report;

impl Model {
    /// Reads a description; nothing if it is no XML or not of FMI 2.0.
    pub fn read(bytes: &[u8], report: &mut Report) -> Option<Self> {
        let place = "modelDescription.xml";
        let text = report.accept(format_args!("{place}: not in UTF-8"), std::str::from_utf8(bytes))?;
        let text = text.trim_start_matches('\u{feff}');
        let options = ParsingOptions { nodes_limit: 20_000_000, ..ParsingOptions::default() };
        let document = Document::parse_with_options(text, options);
        let document = report.accept(format_args!("{place}: not well-formed XML"), document)?;
        let root = document.root_element();
        let version = root.attribute("fmiVersion").unwrap_or_default();
        let fmi3 = version.starts_with("3.0");
        if root.tag_name().name() != "fmiModelDescription" || !(fmi3 || version == "2.0") {
            report.problem(format_args!("{place}: fmiVersion = \"{version}\"; only 2.0 and 3.0 can be checked"));
            return None;
        }
        check_schema(text, &root, fmi3, report);
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
            guid: reader.text(root, if fmi3 { "instantiationToken" } else { "guid" }),
            tool: root.attribute("generationTool").unwrap_or_default().to_owned(),
            date: root.attribute("generationDateAndTime").map(str::to_owned),
            structured: root.attribute("variableNamingConvention") == Some("structured"),
            co_simulation: interface(Kind::CoSimulation, reader),
            model_exchange: interface(Kind::ModelExchange, reader),
            event_indicators: root
                .attribute("numberOfEventIndicators")
                .and_then(|number| number.parse().ok())
                .unwrap_or_default(),
            experiment: child(root, "DefaultExperiment").map(|node| reader.experiment(node)).unwrap_or_default(),
            units: list(root, ["UnitDefinitions", "Unit"]).map(|node| reader.unit(node)).collect(),
            types: list(root, ["TypeDefinitions", "SimpleType"])
                .filter_map(|node| {
                    Some(SimpleType { name: reader.text(node, "name"), attributes: reader.attributes(node)? })
                })
                .collect(),
            log_categories: list(root, ["LogCategories", "Category"]).map(|node| reader.text(node, "name")).collect(),
            variables: list(root, ["ModelVariables", "ScalarVariable"])
                .filter_map(|node| reader.variable(node))
                .collect(),
            structure: child(root, "ModelStructure").map(|node| reader.structure(node)).unwrap_or_default(),
            arrays: elements(root, "ModelVariables").filter(|_| fmi3).filter_map(|node| reader.array(node)).collect(),
            type_names: elements(root, "TypeDefinitions")
                .filter_map(|node| node.attribute("name"))
                .map(str::to_owned)
                .collect(),
            unknowns: elements(root, "ModelStructure")
                .filter(|_| fmi3)
                .filter_map(|node| reader.array_unknown(node))
                .collect(),
        })
    }
}

/// The schema, as strictly as `fmi-schema` has it.
fn check_schema(text: &str, root: &Node, fmi3: bool, report: &mut Report) {
    // It takes for granted what a schema would check first.
    let read = catch_unwind(|| match fmi3 {
        true => Fmi3ModelDescription::deserialize(text).map(|_| ()).map_err(|error| error.to_string()),
        false => Fmi2ModelDescription::deserialize(text).map(|_| ()).map_err(|error| error.to_string()),
    });
    let error = match read {
        Ok(Ok(_)) => return,
        Ok(Err(error)) => error,
        Err(_) => "an element that is not where it belongs".to_owned(),
    };
    let text = format!("modelDescription.xml: does not follow the schema: {error}");
    // References to a schema are allowed, and it does not know them; nor does it know all attributes of FMI 3.0.
    if root.namespaces().len() > 0 || fmi3 { report.remark(text) } else { report.problem(text) }
}

fn child<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Option<Node<'a, 'input>> {
    node.children().find(|child| child.has_tag_name(name))
}

fn children<'a, 'input: 'a>(node: Node<'a, 'input>, name: &'static str) -> impl Iterator<Item = Node<'a, 'input>> {
    node.children().filter(move |child| child.has_tag_name(name))
}

fn list<'a, 'input: 'a>(root: Node<'a, 'input>, names: [&'static str; 2]) -> impl Iterator<Item = Node<'a, 'input>> {
    child(root, names[0]).into_iter().flat_map(move |list| children(list, names[1]))
}

/// All elements of a list.
fn elements<'a, 'input: 'a>(root: Node<'a, 'input>, list: &'static str) -> impl Iterator<Item = Node<'a, 'input>> {
    child(root, list).into_iter().flat_map(|list| list.children()).filter(Node::is_element)
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
            self.report.problem(format_args!("{}: {key} is not a list of indices", place(node)));
        }
        indices.ok()
    }

    fn experiment(&mut self, node: Node) -> Experiment {
        let [start, stop, step, tolerance] =
            ["startTime", "stopTime", "stepSize", "tolerance"].map(|key| self.value(node, key));
        Experiment { start, stop, step, tolerance }
    }

    fn unit(&mut self, node: Node) -> Unit {
        let display = children(node, "DisplayUnit").map(|node| self.text(node, "name")).collect();
        Unit { name: self.text(node, "name"), display }
    }

    fn attributes(&mut self, node: Node) -> Option<Attributes> {
        let types = [Type::Real, Type::Integer, Type::Boolean, Type::String, Type::Enumeration];
        let named = |name: &str| types.into_iter().find(|known| format!("{known:?}") == name);
        let Some((node, data_type)) = node.children().find_map(|node| Some((node, named(node.tag_name().name())?)))
        else {
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

    fn array(&mut self, node: Node) -> Option<Array> {
        let owned = |key: &str| node.attribute(key).map(str::to_owned);
        let list =
            |text: Option<&str>| text.unwrap_or_default().split_whitespace().filter_map(|n| n.parse().ok()).collect();
        let dimension = |dimension: Node| match dimension.attribute("valueReference") {
            Some(reference) => Ok(reference.parse().unwrap_or(u32::MAX)),
            None => Err(dimension.attribute("start").and_then(|size| size.parse().ok()).unwrap_or(0)),
        };
        let element = node.tag_name().name().to_owned();
        let variability = owned("variability");
        let usual = if matches!(element.as_str(), "Float64" | "Float32") { "continuous" } else { "discrete" };
        Some(Array {
            name: self.text(node, "name"),
            reference: self.value(node, "valueReference")?,
            causality: owned("causality").unwrap_or_else(|| "local".to_owned()),
            variability: variability.unwrap_or_else(|| usual.to_owned()),
            initial: owned("initial"),
            start: owned("start"),
            declared_type: owned("declaredType"),
            unit: owned("unit"),
            dimensions: children(node, "Dimension").map(dimension).collect(),
            clocks: list(node.attribute("clocks")),
            element,
        })
    }

    fn array_unknown(&mut self, node: Node) -> Option<ArrayUnknown> {
        let dependencies = self.indices(node, "dependencies");
        Some(ArrayUnknown {
            list: node.tag_name().name().to_owned(),
            reference: self.value(node, "valueReference")?,
            // Of `usize` and not `u32` only because the reader of lists is that of FMI 2.0.
            dependencies: dependencies.map(|list| list.into_iter().map(|of| of as u32).collect()),
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
