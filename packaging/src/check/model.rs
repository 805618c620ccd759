//! The parts of a modelDescription.xml that this program needs.
//!
//! The text is untrusted. It is read as a stream, element by element, without recursion.

use std::error::Error;

use newtons_cradle::variables::MODEL_IDENTIFIER;
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use super::report::Report;
use crate::archive::Entries;

/// The file in an FMU.
pub const FILE: &str = "modelDescription.xml";

/// What FMUs of this version of this program give as their generation tool.
pub const TOOL: &str = concat!("newtons-cradle ", env!("CARGO_PKG_VERSION"));

/// A description, with empty texts for absent parts.
#[derive(Default)]
pub struct Model {
    pub fmi_version: String,
    pub name: String,
    /// Its `guid`, or `instantiationToken` in FMI 3.0.
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
        let mut model = Self::default();
        let filled = model.fill(text.trim_start_matches('\u{feff}'));
        report.accept(format_args!("{FILE}: not well-formed XML"), filled)?;
        let version = &model.fmi_version;
        let known = model.is_fmi3() || version == "2.0";
        report.require(known, format_args!("{FILE}: fmiVersion = \"{version}\"; only 2.0 and 3.0 can be read"));
        known.then_some(model)
    }

    /// Whether it is one of FMI 3.0.
    pub fn is_fmi3(&self) -> bool {
        self.fmi_version.starts_with("3.0")
    }

    /// Whether this program writes FMUs like it.
    pub fn is_own(&self) -> bool {
        self.name == MODEL_IDENTIFIER && self.tool.starts_with("newtons-cradle ")
    }

    fn fill(&mut self, text: &str) -> Result<(), Box<dyn Error>> {
        let mut reader = Reader::from_str(text);
        reader.config_mut().expand_empty_elements = true;
        let mut outer: Vec<String> = Vec::new();
        loop {
            match reader.read_event()? {
                Event::Start(element) => {
                    let name = element.name().as_ref().to_owned();
                    self.take(&outer, &name, &element)?;
                    outer.push(name);
                }
                Event::End(_) => _ = outer.pop(),
                Event::Eof if outer.is_empty() => return Ok(()),
                Event::Eof => return Err("it ends within an element".into()),
                _ => {}
            }
        }
    }

    /// Takes what is needed from an element within others.
    fn take(&mut self, outer: &[String], name: &str, element: &BytesStart) -> Result<(), Box<dyn Error>> {
        match (outer, name) {
            ([], "fmiModelDescription") => {
                let token;
                [self.fmi_version, self.name, self.tool, self.date, self.guid, token] = attributes(element, ROOT)?;
                self.guid += &token;
            }
            ([_], "CoSimulation" | "ModelExchange" | "ScheduledExecution") => {
                let [identifier] = attributes(element, ["modelIdentifier"])?;
                self.interfaces.push([name.to_owned(), identifier]);
            }
            ([_], "DefaultExperiment") => {
                self.experiment = attributes(element, ["startTime", "stopTime", "stepSize"])?;
            }
            ([_, list], _) if list == "ModelVariables" => {
                self.causalities.extend(attributes(element, ["causality"])?);
            }
            _ => {}
        }
        Ok(())
    }
}

const ROOT: [&str; 6] =
    ["fmiVersion", "modelName", "generationTool", "generationDateAndTime", "guid", "instantiationToken"];

/// The values of attributes, empty where the element has none of a name.
fn attributes<const N: usize>(element: &BytesStart, names: [&str; N]) -> Result<[String; N], Box<dyn Error>> {
    let mut values = names.map(|_| String::new());
    for (value, name) in values.iter_mut().zip(names) {
        if let Some(found) = element.try_get_attribute(name)? {
            *value = found.normalized_value(XmlVersion::Implicit1_0)?.into_owned();
        }
    }
    Ok(values)
}
