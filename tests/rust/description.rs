//! The description for any number of balls, read by third-party code, against the table.
//! tests/hosts/test_description.py checks names, and the rules of the standard by FMPy's validation.

use fmi_schema::fmi2::{self, Fmi2ModelDescription, ScalarVariableElement};
use fmi_schema::traits::FmiModelDescription;
use newtons_cradle::variables::{Description, Settings, Type, Variable, variables};

fn xml(balls: usize) -> String {
    Description::of(&Settings::default_for(balls)).xml("2000-01-01T00:00:00Z")
}

fn read(xml: &str) -> Fmi2ModelDescription {
    Fmi2ModelDescription::deserialize(xml).unwrap()
}

#[test]
fn the_description_is_the_table() {
    for balls in [1, 2, 5, 13, 100] {
        let xml = xml(balls);
        assert!(!xml.contains("{{") && !xml.contains("}}"));
        let description = read(&xml);
        let described = &description.model_variables.variables;
        assert_eq!(described.len(), variables(balls).count());
        for (described, variable) in described.iter().zip(variables(balls)) {
            assert_eq!((&described.name, described.value_reference), (&variable.to_string(), variable.reference()));
            assert_eq!(Variable::named(&described.name, balls).unwrap().reference(), variable.reference());
            assert_eq!(Variable::at(variable.reference(), balls).unwrap().to_string(), described.name);
            assert_eq!(
                described.causality.to_string().to_lowercase(),
                format!("{:?}", variable.row.causality).to_lowercase()
            );
            let variability = described.variability.unwrap().to_string();
            assert_eq!(variability, format!("{:?}", variable.row.variability).to_lowercase());
            let actual = match &described.elem {
                ScalarVariableElement::Real(real) => {
                    assert_eq!(real.start.is_some(), variable.row.settable(), "{variable}");
                    assert!(real.start.is_none_or(|start| variable.check_real(start).is_ok()), "{variable}");
                    Type::Real
                }
                ScalarVariableElement::Integer(_) => Type::Integer,
                ScalarVariableElement::Boolean(_) => Type::Boolean,
                ScalarVariableElement::Enumeration => Type::Enumeration,
                ScalarVariableElement::String => Type::String,
            };
            assert_eq!(actual, variable.row.access.data_type());
            assert!(!described.description.as_ref().unwrap().contains(['{', '}']));
        }
    }
}

#[test]
fn ranges_are_those_that_setters_allow() {
    let text = xml(5);
    for variable in variables(5).filter(|variable| variable.row.settable()) {
        let (_, rest) = text.split_once(&format!(" name=\"{variable}\"")).unwrap();
        let (own, _) = rest.split_once("</ScalarVariable>").unwrap();
        let limit = |name: &str| Some(own.split_once(name)?.1.split_once('"').unwrap().0.parse::<f64>().unwrap());
        let range = variable.row.range;
        assert_eq!([limit(" min=\""), limit(" max=\"")], [range.min, range.max], "{variable}");
        assert_eq!(own.contains("0 itself is refused"), range.above_min, "{variable}");
    }
}

#[test]
fn quantities_have_their_units_and_these_the_right_base_units() {
    let text = xml(5);
    let units = read(&text).unit_definitions.unwrap().units;
    let exponents = |name: &str| {
        let unit: &fmi2::Fmi2Unit = units.iter().find(|unit| unit.name == name).expect(name);
        let base = unit.base_unit.as_ref().unwrap();
        assert!(base.factor.is_none() && base.offset.is_none());
        [base.kg, base.m, base.s].map(Option::unwrap_or_default)
    };
    for (quantity, unit, expected) in [
        ("Ratio", "1", [0, 0, 0]),
        ("Angle", "rad", [0, 0, 0]),
        ("Length", "m", [0, 1, 0]),
        ("Time", "s", [0, 0, 1]),
        ("Mass", "kg", [1, 0, 0]),
        ("Velocity", "m/s", [0, 1, -1]),
        ("Momentum", "kg.m/s", [1, 1, -1]),
        ("Impulse", "N.s", [1, 1, -1]),
        ("Damping", "N.s/m", [1, 0, -1]),
        ("Drag", "kg/s", [1, 0, -1]),
        ("Slowness", "s/m", [0, -1, 1]),
        ("Force", "N", [1, 1, -2]),
        ("Stiffness", "N/m", [1, 0, -2]),
        ("Energy", "J", [1, 2, -2]),
        ("Power", "W", [1, 2, -3]),
        ("ElasticModulus", "Pa", [1, -1, -2]),
        ("Acceleration", "m/s2", [0, 1, -2]),
    ] {
        assert_eq!(exponents(unit), expected, "{unit}");
        let declared = format!("name=\"{quantity}\"><Real quantity=\"{quantity}\" unit=\"{unit}\"/>");
        assert!(text.contains(&declared), "{declared}");
    }
    assert_eq!(units.len(), 17);
}

#[test]
fn small_and_large_numbers_are_shown_in_other_units() {
    let (two, settings) = (xml(2), Settings::default_for(2));
    let three = Description::fmi3(&settings).xml("2000-01-01T00:00:00Z");
    for (name, quantity, unit, shown, factor) in [
        ("ball.radius", "Length", "m", "mm", "1000"),
        ("contact.gap", "Length", "m", "um", "1e6"),
        ("overlap", "Length", "m", "um", "1e6"),
        ("contact.relaxationTime", "Time", "s", "us", "1e6"),
        ("F_peak", "Force", "N", "kN", "0.001"),
        ("contact.stiffness", "Stiffness", "N/m", "N/um", "1e-6"),
        ("ball.youngModulus", "ElasticModulus", "Pa", "GPa", "1e-9"),
    ] {
        let declared = format!("quantity=\"{quantity}\" unit=\"{unit}\" displayUnit=\"{shown}\"");
        for text in [&two, &three] {
            let (_, units) = text.split_once(&format!("<Unit name=\"{unit}\">")).unwrap();
            let (units, _) = units.split_once("</Unit>").unwrap();
            assert!(units.contains(&format!("<DisplayUnit name=\"{unit}\"/>")), "{units}");
            assert!(units.contains(&format!("<DisplayUnit name=\"{shown}\" factor=\"{factor}\"/>")), "{units}");
            let (_, variable) = text.split_once(&format!(" name=\"{name}")).unwrap();
            let (_, of) = variable.split_once("declaredType=\"").unwrap();
            let named = format!("Type name=\"{}\"", of.split('"').next().unwrap());
            assert!(text.split_once(&named).unwrap().1.lines().next().unwrap().contains(&declared), "{name}: {named}");
        }
        let (_, variable) = two.split_once(&format!(" name=\"{name}")).unwrap();
        let (_, element) = variable.split_once("<Real").unwrap();
        let own = format!(" unit=\"{unit}\" displayUnit=\"{shown}\"");
        assert!(element.split_once("/>").unwrap().0.contains(&own), "{name}");
    }
}
