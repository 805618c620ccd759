//! modelDescription.xml of FMI 2.0 and 3.0: the template filled in from n, the start values and the table.
//! [`Description`] provides it with its GUID; [`LogCategory`] lists its log categories.

mod elements;
mod structure;

use std::fmt::{self, Write};

pub use elements::padding;

use super::settings::Settings;
use super::text::escaped;
use super::variable::{Variable, states, variables};
use crate::model::{Item, enumerations};
use crate::number::Number;
use elements::{write_types, write_units, write_variables};
use structure::{Contents, write_structure};

/// Model name, model identifier and file name.
pub const MODEL_IDENTIFIER: &str = "NewtonsCradle";
/// Start of the default experiment, s.
pub const START_TIME: f64 = 0.0;
/// End of the default experiment, s.
pub const STOP_TIME: f64 = 10.0;
/// Communication step of the default experiment, s.
pub const STEP_SIZE: f64 = 0.01;

/// The prose and the fixed attributes of FMI 2.0's description.
const TEMPLATE: &str = include_str!("../../../modelDescription.xml.in");
/// The prose and the fixed attributes of FMI 3.0's description.
const TEMPLATE_OF_FMI3: &str = include_str!("../../fmi3/modelDescription.xml.in");

/// Namespace of the GUIDs: any constant, but never another one.
const NAMESPACE: uuid::Uuid = uuid::Uuid::from_u128(0x6c1f_9a52_54f0_4b0e_9c4e_27a5_8d31_70b6);

enumerations! {
    /// A category of log lines, with its name in the description and in the host's log, and a text for the user.
    LogCategory {
        Events = 0 "logEvents" "One line for each finished pulse: contact, onset, release, peak force, impulse and time of the peak",
        Solver "logSolver" "What the solver does with the settings it was given",
        Warning "logStatusWarning" "Warnings",
        Discard "logStatusDiscard" "Values that are refused, or that do not exist, with the reason",
        Error "logStatusError" "Refused calls and failed steps, with the reason",
    }
}

/// The text of [`LogCategory::Discard`] in FMI 2.0, where a refused value is an error.
const DISCARD_OF_FMI2: &str = "Values that do not exist in the states that a solver tries, with the reason";

/// The description of the FMU whose start values are `start`.
pub struct Description<'a> {
    /// Start values.
    pub start: &'a Settings,
    /// Whether it is a description of FMI 3.0.
    pub fmi3: bool,
    /// Whether it has clocks and their variables, which some hosts do not support.
    pub clocks: bool,
    /// Whether elements of arrays are scalars, with the value references of FMI 2.0: some hosts support no arrays.
    pub scalars: bool,
    /// Whether only real variables are outputs, and the others locals: some hosts read every output as a real number.
    pub real_outputs: bool,
}

impl<'a> Description<'a> {
    /// Describes the FMU whose start values are `start`.
    pub fn of(start: &'a Settings) -> Self {
        Self { start, fmi3: false, clocks: false, scalars: true, real_outputs: false }
    }

    /// Describes it as an FMU of FMI 3.0, where the GUID is called instantiation token.
    pub fn fmi3(start: &'a Settings) -> Self {
        Self { fmi3: true, clocks: true, scalars: false, ..Self::of(start) }
    }

    /// All descriptions with these start values: of FMI 2.0, or of FMI 3.0 with or without clocks or arrays; without
    /// clocks, also with outputs that are all real.
    pub fn all(start: &'a Settings, fmi3: bool) -> Vec<Self> {
        let plain = if !fmi3 {
            vec![Self::of(start)]
        } else {
            let options = [(true, false), (false, false), (true, true), (false, true)];
            options.map(|(clocks, scalars)| Self { clocks, scalars, ..Self::fmi3(start) }).into()
        };
        let is_without = |own: &&Self| !own.clocks;
        let real: Vec<Self> = plain.iter().filter(is_without).map(|own| Self { real_outputs: true, ..*own }).collect();
        plain.into_iter().chain(real).collect()
    }

    /// GUID: a hash of the description without GUID and date, in braces. It ties a binary to its description.
    pub fn guid(&self) -> String {
        let hash = uuid::Uuid::new_v5(&NAMESPACE, self.render("", "").as_bytes());
        format!("{{{}}}", hash.hyphenated())
    }

    /// The whole of modelDescription.xml; `date` is the time of generation as `YYYY-MM-DDThh:mm:ssZ`.
    pub fn xml(&self, date: &str) -> String {
        self.render(&self.guid(), date)
    }

    /// The variables in their order.
    pub fn variables(&self) -> Vec<Variable> {
        let balls = self.start.balls();
        if !self.fmi3 {
            return variables(balls).collect();
        }
        let arrays = Variable::arrays().filter(|array| self.clocks || !array.needs_clocks());
        match self.scalars {
            true => arrays.flat_map(|array| (0..balls).filter_map(move |i| array.scalar(i, balls))).collect(),
            false => arrays.collect(),
        }
    }

    /// What the variables and ModelStructure are written from.
    fn contents(&self) -> Contents<'a> {
        let Self { start, fmi3, real_outputs, .. } = *self;
        Contents { start, fmi3, real_outputs, states: self.states(), variables: self.variables() }
    }

    /// The states with their derivatives.
    fn states(&self) -> Vec<(Variable, Variable)> {
        if self.scalars { states(self.start.balls()).collect() } else { Variable::states().collect() }
    }

    fn render(&self, guid: &str, date: &str) -> String {
        let mut out = String::with_capacity(64 * 1024);
        // The GUID is a hash of this text: a checkout with other line ends must not change it.
        let template = if self.fmi3 { TEMPLATE_OF_FMI3 } else { TEMPLATE }.replace("\r\n", "\n");
        let mut pieces = template.split("{{");
        out.push_str(pieces.next().unwrap_or_default());
        for piece in pieces {
            let (key, rest) = piece.split_once("}}").unwrap_or_default();
            // Writing to a string cannot fail.
            let _ = self.fill(key, guid, date, &mut out);
            out.push_str(rest);
        }
        out
    }

    /// Fills in a key of the templates; unknown ones stay visible.
    fn fill(&self, key: &str, guid: &str, date: &str, out: &mut String) -> fmt::Result {
        match key {
            "version" => out.write_str(env!("CARGO_PKG_VERSION")),
            // Cargo separates authors by colons.
            "authors" => write!(out, "{}", escaped(&env!("CARGO_PKG_AUTHORS").replace(':', ", "))),
            "license" => write!(out, "{}", escaped(env!("CARGO_PKG_LICENSE"))),
            "description" => write!(out, "{}", escaped(env!("CARGO_PKG_DESCRIPTION"))),
            "model" => out.write_str(MODEL_IDENTIFIER),
            "guid" => out.write_str(guid),
            "date" => out.write_str(date),
            "start_time" => write!(out, "{}", Number(START_TIME)),
            "stop_time" => write!(out, "{}", Number(STOP_TIME)),
            "step_size" => write!(out, "{}", Number(STEP_SIZE)),
            "indicators" => write!(out, "{}", 2 * (self.start.balls() - 1)),
            "units" => write_units(out),
            "types" => write_types(out, self.fmi3),
            "variables" => write_variables(out, &self.contents()),
            "structure" => write_structure(out, &self.contents()),
            "log_categories" => LogCategory::ITEMS.iter().try_for_each(|Item { name, value, description }| {
                let of_discard = *value == LogCategory::Discard as i32;
                let description = if of_discard && !self.fmi3 { DISCARD_OF_FMI2 } else { description };
                writeln!(out, "    <Category name=\"{name}\" description=\"{}\"/>", escaped(description))
            }),
            _ => write!(out, "{{{{{key}}}}}"),
        }
    }
}
