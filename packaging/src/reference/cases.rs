//! The cases with reference results: the FMU's own start values, and the presets with the same number of balls; each
//! with the parameters that a host must set, also as a parameter set (SSV) of System Structure and Parameterization,
//! version 1.0, or 2.0 for arrays.

use std::iter::once;

use newtons_cradle::variables::{
    Access, Causality, Number, QUANTITIES, Settings, Shape, Variable, enumerations, escaped, padding, variables,
};

use crate::build::PRESETS;

/// From this number of balls on, the run is short.
const MANY_BALLS: usize = 101;

/// The case of the FMU's own start values.
pub const START: &str = "start";

/// A cradle that the FMU becomes by setting parameters.
pub struct Case {
    /// The name of its files.
    pub name: &'static str,
    /// One line on it.
    pub title: &'static str,
    /// Its start values.
    pub settings: Settings,
    /// The parameters and inputs to set: every scalar, and elements of arrays that are not the default or differ from the
    /// FMU's.
    pub parameters: Vec<Variable>,
}

/// The FMU's own start values first, then the presets.
pub fn cases(own: &Settings) -> Vec<Case> {
    let default = Settings::default_for(own.balls());
    let case = |(name, title, settings): (_, _, Settings)| {
        let differs = |variable: &Variable| {
            [&default, own].iter().any(|other| variable.value(other) != variable.value(&settings))
        };
        let parameters = variables(own.balls())
            .filter(|variable| matches!(variable.row.causality, Causality::Parameter | Causality::Input))
            .filter(|variable| variable.row.shape == Shape::Scalar || differs(variable))
            .collect();
        Case { name, title, settings, parameters }
    };
    let presets =
        PRESETS.iter().filter_map(|preset| Some((preset.name, preset.title(), preset.recipe().ok()?.settings().ok()?)));
    let all = once((START, "The start values of this FMU.", own.clone())).chain(presets);
    all.filter(|(.., settings)| settings.balls() == own.balls()).map(case).collect()
}

/// The communication points of the results in the FMU, s: ten seconds, or one of many balls, in steps of 0.1 s.
pub fn times(balls: usize) -> Vec<f64> {
    (0..=if balls < MANY_BALLS { 100 } else { 10 }).map(|step| f64::from(step) / 10.0).collect()
}

/// The recorded variables, at most ten: balls at both ends, the impulses of the contacts there, momentum and energy.
pub fn recorded(balls: usize) -> Vec<Variable> {
    let mut names = Vec::new();
    for (name, count, of) in [("x", 3, balls), ("impulse", 1, balls - 1)] {
        let ends = (1..=of).filter(|index| *index <= count || *index + count > of);
        names.extend(ends.map(|index| format!("{name}[{index}]")));
    }
    names.extend(["p_total", "E_total"].map(str::to_owned));
    names.iter().filter_map(|name| Variable::named(name, balls)).collect()
}

impl Case {
    /// The parameter set; with `arrays` that of an FMU that has them: in the version of SSP that knows arrays, if the
    /// set has any.
    pub fn ssv(&self, arrays: bool) -> String {
        let (name, title) = (self.name, escaped(self.title));
        let is_array = |variable: &Variable| arrays && variable.row.shape != Shape::Scalar;
        let version = if self.parameters.iter().any(is_array) { "2.0" } else { "1.0" };
        let mut xml = format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
             <ssv:ParameterSet xmlns:ssv=\"http://ssp-standard.org/SSP1/SystemStructureParameterValues\"\n    \
             xmlns:ssc=\"http://ssp-standard.org/SSP1/SystemStructureCommon\"\n    \
             version=\"{version}\" name=\"{name}\" description=\"{title}\">\n  <ssv:Parameters>\n"
        );
        // Of an array, the first of its variables stands for all.
        let of_one = |first: &Variable, second: &Variable| arrays && first.position == second.position;
        for variable in self.parameters.chunk_by(of_one).map(|variables| &variables[0]) {
            let is_array = is_array(variable);
            let name = if is_array { variable.row.name.to_owned() } else { variable.to_string() };
            let (value, unit) = (variable.text(&self.settings).unwrap_or_default(), variable.row.unit());
            let value = if is_array {
                let (values, size) = (self.elements(variable), self.settings.balls());
                format!("<ssv:Float64 value=\"{values}\" unit=\"{unit}\"/><ssc:Dimension size=\"{size}\"/>")
            } else if let Access::Enumeration(enumeration) = variable.row.access {
                format!("<ssv:Enumeration value=\"{value}\" name=\"{}\"/>", enumeration.type_name)
            } else {
                format!("<ssv:Real value=\"{value}\" unit=\"{unit}\"/>")
            };
            xml += &format!("    <ssv:Parameter name=\"{name}\">{value}</ssv:Parameter>\n");
        }
        xml.push_str("  </ssv:Parameters>\n  <ssv:Enumerations>\n");
        for enumeration in enumerations(false) {
            xml += &format!("    <ssc:Enumeration name=\"{}\">\n", enumeration.type_name);
            for item in enumeration.items {
                xml += &format!("      <ssc:Item name=\"{}\" value=\"{}\"/>\n", item.name, item.value);
            }
            xml.push_str("    </ssc:Enumeration>\n");
        }
        xml.push_str("  </ssv:Enumerations>\n  <ssv:Units>\n");
        for (quantity, _) in QUANTITIES {
            let (unit, base) = (quantity.unit, quantity.base_units());
            xml += &format!("    <ssc:Unit name=\"{unit}\"><ssc:BaseUnit{base}/></ssc:Unit>\n");
        }
        xml.push_str("  </ssv:Units>\n</ssv:ParameterSet>\n");
        xml
    }

    /// All elements of a variable's array, as many as there are balls.
    fn elements(&self, variable: &Variable) -> String {
        let element = |index| Variable { index, ..*variable }.value(&self.settings);
        let values = (0..self.settings.balls()).map(|index| element(index).unwrap_or_else(|| padding(variable.row)));
        values.map(|value| Number(value).to_string()).collect::<Vec<_>>().join(" ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reference_records_at_most_ten_variables() {
        let names = |balls| recorded(balls).iter().map(Variable::to_string).collect::<Vec<_>>().join(" ");
        assert_eq!(names(1), "x[1] p_total E_total");
        assert_eq!(names(2), "x[1] x[2] impulse[1] p_total E_total");
        assert_eq!(names(13), "x[1] x[2] x[3] x[11] x[12] x[13] impulse[1] impulse[12] p_total E_total");
    }
}
