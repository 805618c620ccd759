//! modelDescription.xml: the template with everything filled in that depends on n, the start values or the table.

use std::fmt::{self, Write};

use super::elements::{write_arrays, write_types, write_units, write_variables};
use super::log_category::{LOG_CATEGORIES, LogCategory};
use super::structure::{write_structure, write_structure_of_arrays};
use crate::variables::arrays::Array;
use crate::variables::settings::Settings;
use crate::variables::text::{Escaped, Number};

/// Model name, model identifier and file name.
pub const MODEL_IDENTIFIER: &str = "NewtonsCradle";
/// Start of the default experiment, s.
pub const START_TIME: f64 = 0.0;
/// End of the default experiment, s.
pub const STOP_TIME: f64 = 10.0;
/// Communication step of the default experiment, s.
pub const STEP_SIZE: f64 = 0.01;

/// The prose and the fixed attributes; `build.rs` has filled in what Cargo knows and checked the placeholders.
const TEMPLATE: &str = include_str!(concat!(env!("OUT_DIR"), "/modelDescription.xml"));
/// The same for FMI 3.0.
const TEMPLATE_OF_FMI3: &str = include_str!(concat!(env!("OUT_DIR"), "/modelDescription.fmi3.xml"));

/// Namespace of the GUIDs: any constant will do, as long as it stays.
const NAMESPACE: uuid::Uuid = uuid::Uuid::from_u128(0x6c1f_9a52_54f0_4b0e_9c4e_27a5_8d31_70b6);

/// The description of the FMU whose start values are `start`.
pub struct Description<'a> {
    start: &'a Settings,
    fmi3: bool,
    clocks: bool,
}

impl<'a> Description<'a> {
    /// Describes the FMU whose start values are `start`.
    pub fn of(start: &'a Settings) -> Self {
        Self { start, fmi3: false, clocks: false }
    }

    /// The same as an FMU of FMI 3.0, where the GUID is called instantiation token.
    pub fn fmi3(start: &'a Settings) -> Self {
        Self { start, fmi3: true, clocks: true }
    }

    /// The same without clocks and their variables, for hosts that take none.
    pub fn without_clocks(self) -> Self {
        Self { clocks: false, ..self }
    }

    /// The description of an FMU of FMI 3.0 with these start values whose token this is, with or without clocks.
    pub fn of_token(start: &'a Settings, token: &str) -> Option<Self> {
        [Self::fmi3(start), Self::fmi3(start).without_clocks()].into_iter().find(|own| own.guid() == token)
    }

    /// GUID: a hash of the description less GUID and date, in braces. It is what ties a binary to its description.
    pub fn guid(&self) -> String {
        let hash = uuid::Uuid::new_v5(&NAMESPACE, self.render("", "").as_bytes());
        format!("{{{}}}", hash.hyphenated())
    }

    /// The whole of modelDescription.xml; `date` is the time of generation as `YYYY-MM-DDThh:mm:ssZ`.
    pub fn xml(&self, date: &str) -> String {
        self.render(&self.guid(), date)
    }

    /// The variables of FMI 3.0.
    fn arrays(&self) -> impl Iterator<Item = Array> + Clone + use<> {
        let clocks = self.clocks;
        Array::all().filter(move |array| clocks || !array.needs_clocks())
    }

    fn render(&self, guid: &str, date: &str) -> String {
        let mut out = String::with_capacity(64 * 1024);
        let mut pieces = if self.fmi3 { TEMPLATE_OF_FMI3 } else { TEMPLATE }.split("{{");
        out.push_str(pieces.next().unwrap_or_default());
        for piece in pieces {
            let (key, rest) = piece.split_once("}}").unwrap_or_default();
            // Writing to a string cannot fail.
            let _ = self.fill(key, guid, date, &mut out);
            out.push_str(rest);
        }
        out
    }

    /// Every key that `build.rs` leaves for us.
    fn fill(&self, key: &str, guid: &str, date: &str, out: &mut String) -> fmt::Result {
        match key {
            "model" => out.write_str(MODEL_IDENTIFIER),
            "guid" => out.write_str(guid),
            "date" => out.write_str(date),
            "start_time" => write!(out, "{}", Number(START_TIME)),
            "stop_time" => write!(out, "{}", Number(STOP_TIME)),
            "step_size" => write!(out, "{}", Number(STEP_SIZE)),
            "indicators" => write!(out, "{}", 2 * (self.start.balls() - 1)),
            "units" => write_units(out),
            "types" => write_types(out, self.fmi3),
            "variables" if self.fmi3 => write_arrays(out, self.start, self.arrays()),
            "variables" => write_variables(out, self.start),
            "structure" if self.fmi3 => write_structure_of_arrays(out, self.arrays()),
            "structure" => write_structure(out, self.start),
            // In FMI 2.0 every refused call is an error.
            "log_categories" => {
                LOG_CATEGORIES.iter().filter(|of| self.fmi3 || **of != LogCategory::Discard).try_for_each(|category| {
                    let (name, description) = category.texts();
                    writeln!(out, "    <Category name=\"{name}\" description=\"{}\"/>", Escaped(description))
                })
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_left_to_fill_in() {
        let xml = Description::of(&Settings::default_for(5)).xml("2000-01-01T00:00:00Z");
        assert!(!xml.contains("{{") && !xml.contains("}}"));
        assert!(xml.contains("generationDateAndTime=\"2000-01-01T00:00:00Z\""));
        assert!(xml.contains("name=\"x_start[2]\""));
    }

    #[test]
    fn guid_follows_the_start_values_and_not_the_date() {
        let start = Settings::default_for(5);
        let mut other = start.clone();
        other.parameters.x_start[0] = -0.2;
        let guid = Description::of(&start).guid();
        assert_eq!(guid.len(), 38);
        assert!(Description::of(&start).xml("a").contains(&guid) && Description::of(&start).xml("b").contains(&guid));
        assert_ne!(guid, Description::of(&other).guid());
        assert_ne!(guid, Description::of(&Settings::default_for(4)).guid());
    }
}
