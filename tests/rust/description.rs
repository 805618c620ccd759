//! The description for any number of balls, read by third-party code, against the table.
//! tests/hosts/test_description.py checks names, and the rules of the standard by FMPy's validation.

use fmi_schema::fmi2::{Fmi2ModelDescription, Fmi2Unit};
use fmi_schema::traits::FmiModelDescription;
use newtons_cradle::variables::{Description, Settings, Type, Variable, variables};

fn xml(balls: usize) -> String {
    Description::of(&Settings::default_for(balls)).xml("2000-01-01T00:00:00Z")
}

fn read(xml: &str) -> Fmi2ModelDescription {
    Fmi2ModelDescription::deserialize(xml).unwrap()
}

/// What is between the first `begin` in a text and the first `end` after it.
fn between<'a>(text: &'a str, begin: &str, end: &str) -> &'a str {
    let (_, rest) = text.split_once(begin).unwrap_or_else(|| panic!("no {begin}"));
    rest.split_once(end).unwrap().0
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
            let (name, row) = (variable.to_string(), variable.row);
            assert_eq!((&described.name, described.value_reference), (&name, variable.reference()));
            assert_eq!(Variable::named(&name, balls).unwrap().reference(), variable.reference());
            assert_eq!(Variable::at(variable.reference(), balls).unwrap().to_string(), name);
            assert!(!described.description.as_ref().unwrap().contains(['{', '}']));

            let own = between(&xml, &format!(" name=\"{variable}\""), "</ScalarVariable>");
            let kind = format!("causality=\"{:?}\" variability=\"{:?}\"", row.causality, row.variability);
            assert!(own.to_lowercase().contains(&kind.to_lowercase()), "{own}, not {kind}");
            assert!(own.contains(&format!("<{:?}", row.access.data_type())), "{own}");
            let number = |name: &str| Some(own.split_once(name)?.1.split_once('"').unwrap().0.parse::<f64>().unwrap());
            assert_eq!(own.contains(" start=\""), row.settable(), "{variable}");
            if row.settable() {
                // Ranges are those that setters allow.
                assert_eq!([" min=\"", " max=\""].map(number), [row.range.min, row.range.max], "{variable}");
                assert_eq!(own.contains("0 itself is refused"), row.range.above_min, "{variable}");
                let start = number(" start=\"").unwrap();
                assert!(row.access.data_type() != Type::Real || variable.check(start).is_ok(), "{variable}");
            }
        }
    }
}

#[test]
fn what_does_not_exist_is_not_found() {
    for name in ["", "x", "x[0]", "x[6]", "x[01]", "x[+1]", "x[1", "x1]", "F[5]", "gravity[1]", "x[1][1]", "nothing"] {
        assert!(Variable::named(name, 5).is_none(), "{name}");
    }
}

#[test]
fn numbers_are_short_and_read_back_and_markup_is_escaped() {
    use newtons_cradle::variables::{Number, escaped};

    let samples = [0.0, 9.81, 1.0, 2.6e-6, 1e30, -1e30, 0.0313, 2.1e11, 1e-14, f64::MAX, 5e-324, 0.1 + 0.2];
    for value in samples {
        assert_eq!(Number(value).to_string().parse::<f64>().unwrap().to_bits(), value.to_bits());
    }
    assert_eq!([1e10, -0.1, f64::NAN].map(|value| Number(value).to_string()), ["1e10", "-0.1", "NaN"]);
    assert_eq!(escaped(r#"a<b & "c">d"#), "a&lt;b &amp; &quot;c&quot;&gt;d");
}

#[test]
fn quantities_have_their_units_and_these_the_right_base_units() {
    let text = xml(5);
    let units = read(&text).unit_definitions.unwrap().units;
    let exponents = |name: &str| {
        let unit: &Fmi2Unit = units.iter().find(|unit| unit.name == name).expect(name);
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
            let units = between(text, &format!("<Unit name=\"{unit}\">"), "</Unit>");
            assert!(units.contains(&format!("<DisplayUnit name=\"{unit}\"/>")), "{units}");
            assert!(units.contains(&format!("<DisplayUnit name=\"{shown}\" factor=\"{factor}\"/>")), "{units}");
            let variable = between(text, &format!(" name=\"{name}"), "/>");
            let named = format!("Type name=\"{}\"", between(variable, "declaredType=\"", "\""));
            assert!(between(text, &named, "\n").contains(&declared), "{name}: {named}");
        }
        let variable = between(&two, &format!(" name=\"{name}"), "/>");
        assert!(variable.contains(&format!(" unit=\"{unit}\" displayUnit=\"{shown}\"")), "{name}");
    }
}
