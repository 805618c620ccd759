//! What a host has to set, also as a parameter set in SSV, the format of System Structure and Parameterization 1.0.

use std::fmt::Write;

use newtons_cradle::variables::{
    Access, Causality, ENUMERATIONS, Escaped, Number, Settings, Shape, Variable, variables,
};

use super::case::Case;

/// The parameters that make an FMU with the start values `own` the cradle `wanted`, whatever else a host leaves as it
/// is: every scalar, and of the arrays what is not the default or not what the FMU has.
pub fn parameters(wanted: &Settings, own: &Settings) -> Vec<Variable> {
    let balls = wanted.balls();
    let default = Settings::default_for(balls);
    let differs =
        |variable: &Variable| [&default, own].iter().any(|other| variable.real(other) != variable.real(wanted));
    variables(balls)
        .filter(|variable| variable.row.causality == Causality::Parameter)
        .filter(|variable| variable.row.shape == Shape::Scalar || differs(variable))
        .collect()
}

/// Whether a host that knows arrays as a whole can be told all of them: they are scalars.
pub fn fits_scalars(case: &Case, own: &Settings) -> bool {
    parameters(&case.settings, own).iter().all(|variable| variable.row.shape == Shape::Scalar)
}

/// The file of a case.
pub fn ssv(case: &Case, own: &Settings) -> String {
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    // Writing to a string cannot fail.
    let _ = write(&mut xml, case, own);
    xml
}

fn write(xml: &mut String, case: &Case, own: &Settings) -> std::fmt::Result {
    writeln!(
        xml,
        "<ssv:ParameterSet xmlns:ssv=\"http://ssp-standard.org/SSP1/SystemStructureParameterValues\"\n    \
         xmlns:ssc=\"http://ssp-standard.org/SSP1/SystemStructureCommon\"\n    \
         version=\"1.0\" name=\"{}\" description=\"{}\">\n  <ssv:Parameters>",
        case.name,
        Escaped(case.title)
    )?;
    for variable in parameters(&case.settings, own) {
        write!(xml, "    <ssv:Parameter name=\"{variable}\">")?;
        if let Access::Enumeration(enumeration) = variable.row.access {
            let item = variable.item(&case.settings).and_then(|value| enumeration.item(value));
            let name = item.map_or("", |item| item.name);
            write!(xml, "<ssv:Enumeration value=\"{name}\" name=\"{}\"/>", enumeration.type_name)?;
        } else if let Some(value) = variable.real(&case.settings) {
            write!(xml, "<ssv:Real value=\"{}\"/>", Number(value))?;
        }
        writeln!(xml, "</ssv:Parameter>")?;
    }
    writeln!(xml, "  </ssv:Parameters>\n  <ssv:Enumerations>")?;
    for enumeration in ENUMERATIONS {
        writeln!(xml, "    <ssc:Enumeration name=\"{}\">", enumeration.type_name)?;
        for item in enumeration.items {
            writeln!(xml, "      <ssc:Item name=\"{}\" value=\"{}\"/>", item.name, item.value)?;
        }
        writeln!(xml, "    </ssc:Enumeration>")?;
    }
    writeln!(xml, "  </ssv:Enumerations>\n</ssv:ParameterSet>")
}
