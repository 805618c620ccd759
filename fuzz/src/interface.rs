//! The interface as a host knows it: from the description's XML alone.

use newtons_cradle::fmi2::{fmi2GetBoolean, fmi2GetInteger, fmi2GetReal};
use newtons_cradle::variables::{Description, Settings};
use roxmltree::{Document, Node};

use cradle_host::{Host, fmi2OK};

/// Type of a variable; an enumeration has the integers of its items.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    Real,
    Integer,
    Boolean,
    Enumeration(Vec<i32>),
}

/// A scalar variable.
#[derive(Clone, Debug)]
pub struct Variable {
    pub name: String,
    pub reference: u32,
    pub kind: Kind,
    pub causality: String,
    pub variability: String,
    pub start: Option<f64>,
    pub min: f64,
    /// `min` itself is refused.
    pub above_min: bool,
    pub max: f64,
}

impl Variable {
    /// Whether a host may ever set it.
    pub fn settable(&self) -> bool {
        self.is("parameter") || self.is("input")
    }

    pub fn is(&self, causality: &str) -> bool {
        self.causality == causality
    }

    /// Its value now.
    pub fn read(&self, host: &Host) -> f64 {
        self.try_read(host).unwrap_or_else(|| panic!("{}: {:?}", self.name, host.log()))
    }

    /// Its value now, unless that is refused.
    pub fn try_read(&self, host: &Host) -> Option<f64> {
        let (mut real, mut integer) = (f64::NAN, 0);
        let status = unsafe {
            match self.kind {
                Kind::Real => fmi2GetReal(host.c, &self.reference, 1, &mut real),
                Kind::Boolean => fmi2GetBoolean(host.c, &self.reference, 1, &mut integer),
                _ => fmi2GetInteger(host.c, &self.reference, 1, &mut integer),
            }
        };
        (status == fmi2OK).then_some(if self.kind == Kind::Real { real } else { integer.into() })
    }

    /// Whether it may have this value.
    pub fn admits(&self, value: f64) -> bool {
        match &self.kind {
            Kind::Enumeration(items) => items.iter().any(|item| f64::from(*item) == value),
            _ => value.is_finite() && self.min <= value && value <= self.max && !(self.above_min && value == self.min),
        }
    }
}

/// All variables.
pub struct Interface {
    pub variables: Vec<Variable>,
}

impl Default for Interface {
    /// That of the default FMU.
    fn default() -> Self {
        Self::of(5)
    }
}

impl Interface {
    /// That of the FMU of so many balls.
    pub fn of(balls: usize) -> Self {
        let xml = Description::of(&Settings::default_for(balls)).xml("2000-01-01T00:00:00Z");
        let document = Document::parse(&xml).unwrap();
        let all = |name: &'static str| document.descendants().filter(move |node| node.has_tag_name(name));
        let items = |of: &str| {
            let this = all("SimpleType").find(|node| node.attribute("name") == Some(of)).unwrap();
            let items = this.descendants().filter(|node| node.has_tag_name("Item"));
            items.map(|item| item.attribute("value").unwrap().parse().unwrap()).collect()
        };
        Self { variables: all("ScalarVariable").map(|node| variable(node, items)).collect() }
    }

    /// The variable with this value reference.
    pub fn at(&self, reference: u32) -> Option<&Variable> {
        self.variables.iter().find(|variable| variable.reference == reference)
    }

    /// The value reference of the variable of this name.
    pub fn named(&self, name: &str) -> u32 {
        self.variables.iter().find(|variable| variable.name == name).unwrap().reference
    }
}

fn variable(node: Node<'_, '_>, items: impl Fn(&str) -> Vec<i32>) -> Variable {
    let text = |name: &str| node.attribute(name).unwrap_or_default().to_owned();
    let element = node.first_element_child().unwrap();
    let number = |name: &str| element.attribute(name).map(|number| number.parse().unwrap());
    Variable {
        name: text("name"),
        reference: text("valueReference").parse().unwrap(),
        kind: match element.tag_name().name() {
            "Real" => Kind::Real,
            "Integer" => Kind::Integer,
            "Boolean" => Kind::Boolean,
            "Enumeration" => Kind::Enumeration(items(element.attribute("declaredType").unwrap())),
            other => panic!("a variable of type {other}"),
        },
        causality: text("causality"),
        variability: text("variability"),
        start: number("start"),
        min: number("min").unwrap_or(f64::NEG_INFINITY),
        above_min: text("description").ends_with("0 itself is refused"),
        max: number("max").unwrap_or(f64::INFINITY),
    }
}
