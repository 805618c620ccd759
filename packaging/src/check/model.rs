//! What a modelDescription.xml says, as far as this program needs it.
//!
//! The text may be anybody's. It is read as a stream, element by element: nothing here recurses, however deep elements
//! are nested.

use std::collections::BTreeMap;

use newtons_cradle::variables::MODEL_IDENTIFIER;
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use super::report::Report;

/// A description. What is absent is empty.
#[derive(Default)]
pub struct Model {
    /// The whole text.
    pub text: String,
    pub fmi_version: String,
    pub name: String,
    /// Its `guid`, or `instantiationToken` in FMI 3.0.
    pub guid: String,
    pub tool: String,
    pub date: String,
    /// Elements such as `CoSimulation`, each with its modelIdentifier.
    pub interfaces: Vec<(String, String)>,
    /// Start time, stop time and step size of the default experiment.
    pub experiment: [String; 3],
    /// How many variables there are of each causality.
    pub variables: BTreeMap<String, usize>,
    /// Number of balls of one of our own.
    pub balls: usize,
}

impl Model {
    /// Reads a description; nothing if it is no XML, or not of FMI 2.0 or 3.0.
    pub fn read(bytes: &[u8], report: &mut Report) -> Option<Self> {
        let place = "modelDescription.xml";
        let text = report.accept(format_args!("{place}: not in UTF-8"), std::str::from_utf8(bytes))?;
        let text = text.trim_start_matches('\u{feff}');
        let mut model = Self { text: text.to_owned(), ..Self::default() };
        report.accept(format_args!("{place}: not well-formed XML"), model.fill(text))?;
        let version = &model.fmi_version;
        if !(model.is_fmi3() || version == "2.0") {
            report.problem(format_args!("{place}: fmiVersion = \"{version}\"; only 2.0 and 3.0 can be read"));
            return None;
        }
        Some(model)
    }

    /// Whether it is one of FMI 3.0.
    pub fn is_fmi3(&self) -> bool {
        self.fmi_version.starts_with("3.0")
    }

    /// Whether this program writes FMUs like it.
    pub fn is_own(&self) -> bool {
        self.name == MODEL_IDENTIFIER && self.tool.starts_with("newtons-cradle ")
    }

    fn fill(&mut self, text: &str) -> Result<(), String> {
        let mut reader = Reader::from_str(text);
        let (mut depth, mut list) = (0, String::new());
        loop {
            let event = reader.read_event().map_err(|error| error.to_string())?;
            match &event {
                Event::Start(element) | Event::Empty(element) => {
                    match depth {
                        0 => self.root(element)?,
                        1 => {
                            list = element.name().as_ref().to_owned();
                            self.part(&list, element)?;
                        }
                        2 if list == "ModelVariables" => self.variable(element)?,
                        _ => {}
                    }
                    depth += usize::from(matches!(event, Event::Start(_)));
                }
                Event::End(_) => depth -= 1,
                Event::Eof if depth == 0 => return Ok(()),
                Event::Eof => return Err("it ends within an element".to_owned()),
                _ => {}
            }
        }
    }

    fn root(&mut self, element: &BytesStart) -> Result<(), String> {
        if element.name().as_ref() != "fmiModelDescription" {
            return Ok(());
        }
        self.fmi_version = attribute(element, "fmiVersion")?;
        self.name = attribute(element, "modelName")?;
        self.guid = attribute(element, if self.is_fmi3() { "instantiationToken" } else { "guid" })?;
        self.tool = attribute(element, "generationTool")?;
        self.date = attribute(element, "generationDateAndTime")?;
        Ok(())
    }

    fn part(&mut self, name: &str, element: &BytesStart) -> Result<(), String> {
        match name {
            "CoSimulation" | "ModelExchange" | "ScheduledExecution" => {
                self.interfaces.push((name.to_owned(), attribute(element, "modelIdentifier")?));
            }
            "DefaultExperiment" => {
                for (value, name) in self.experiment.iter_mut().zip(["startTime", "stopTime", "stepSize"]) {
                    *value = attribute(element, name)?;
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn variable(&mut self, element: &BytesStart) -> Result<(), String> {
        let (name, causality) = (attribute(element, "name")?, attribute(element, "causality")?);
        let causality = if causality.is_empty() { "local".to_owned() } else { causality };
        *self.variables.entry(causality).or_default() += 1;
        if self.is_fmi3() && name == "n" {
            self.balls = attribute(element, "start")?.parse().unwrap_or_default();
        }
        self.balls += usize::from(name.starts_with("x["));
        Ok(())
    }
}

/// The value of an attribute; empty if the element has none of this name.
fn attribute(element: &BytesStart, name: &str) -> Result<String, String> {
    let Some(found) = element.try_get_attribute(name).map_err(|error| error.to_string())? else {
        return Ok(String::new());
    };
    let value = found.normalized_value(XmlVersion::Implicit1_0).map_err(|error| error.to_string())?;
    Ok(value.into_owned())
}
