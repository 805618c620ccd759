//! The description for any number of balls, read by third-party code, against the table, and the dependencies of its
//! InitialUnknowns against those found by trial in Initialization Mode.
//! tests/hosts/test_description.py checks names, and the rules of the standard by FMPy's validation.

use std::collections::{BTreeMap, BTreeSet};

use cradle_host::{Host, fmi2OK};
use fmi_schema::fmi2::{Fmi2ModelDescription, Fmi2Unit};
use fmi_schema::traits::FmiModelDescription;
use newtons_cradle::variables::{Description, Settings, Type, Variable, variables};

use crate::differences::dependencies;

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
fn description_is_the_table() {
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
fn description_names_no_other_variable() {
    for name in ["", "x", "x[0]", "x[6]", "x[01]", "x[+1]", "x[1", "x1]", "F[5]", "gravity[1]", "x[1][1]", "nothing"] {
        assert!(Variable::named(name, 5).is_none(), "{name}");
    }
}

#[test]
fn description_numbers_read_back_and_markup_is_escaped() {
    use newtons_cradle::variables::{Number, escaped};

    let samples = [0.0, 9.81, 1.0, 2.6e-6, 1e30, -1e30, 0.0313, 2.1e11, 1e-14, f64::MAX, 5e-324, 0.1 + 0.2];
    for value in samples {
        assert_eq!(Number(value).to_string().parse::<f64>().unwrap().to_bits(), value.to_bits());
    }
    assert_eq!([1e10, -0.1, f64::NAN].map(|value| Number(value).to_string()), ["1e10", "-0.1", "NaN"]);
    assert_eq!(escaped(r#"a<b & "c">d"#), "a&lt;b &amp; &quot;c&quot;&gt;d");
}

#[test]
fn description_units_have_the_right_base_units() {
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
fn description_display_units_suit_small_and_large_numbers() {
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

const BALLS: usize = 5;

/// The unknowns in Initialization Mode, bit by bit; none if no run can start like this.
fn values(host: &Host, unknowns: &[Variable]) -> Option<Vec<u64>> {
    unknowns.iter().map(|unknown| host.read(*unknown).map(f64::to_bits)).collect()
}

/// A host in Initialization Mode.
fn initializing(settings: &str) -> Host {
    let host = Host::default();
    host.give(settings);
    assert_eq!((host.set_up(0.0), host.enter()), (fmi2OK, fmi2OK));
    host
}

/// Balls that overlap and approach or part, for the compliant laws.
const PRESSED: &str = "contact.deadBand=1e-6 x_start=3e-5,1e-5,-1e-5,-2e-5,-4e-5 v_start=1e-3,2e-3,-1e-3,-3e-3,1e-3 \
                       contact.exponent=1.2 contact.damping=10 contact.huntCrossley=0.1 contact.relaxationTime=1e-4 \
                       pendulum.drag=0.1 F_ext=1,-2,0.5,-0.3,1.5 a_support=0.2";

/// Of balls that are pressed.
const LAWS: [&str; 8] = [
    "",
    "contact.dampingLaw=kelvinVoigtNoPull",
    "contact.dampingLaw=huntCrossley",
    "contact.model=hertz contact.dampingLaw=huntCrossley",
    "contact.dampingLaw=viscoelastic",
    "contact.model=hertz contact.dampingLaw=viscoelastic",
    "contact.dampingLaw=constantRestitution contact.restitution=0.9",
    "solver.method=bdf",
];

/// Rigid balls at rest in touch, pushed against each other.
const TOUCHING: &str = "contact.model=rigid contact.deadBand=0 x_start=0 F_ext[1]=5 F_ext[5]=-3";

/// Every known is changed in every set-up: unknowns change exactly if they list it. Only the time of the next onset
/// lists everything, in a long row nothing.
#[test]
fn description_dependencies_are_those_found_by_trial() {
    let xml = xml(BALLS);
    let mut described = dependencies(xml.split_once("<InitialUnknowns>").unwrap().1, BALLS);
    assert!(described.is_sorted_by_key(|(unknown, _)| unknown.reference()));
    let settable = |balls| variables(balls).filter(|known| known.row.settable()).map(|known| known.to_string());
    let everything: BTreeSet<String> = settable(BALLS).collect();
    let all = described.extract_if(.., |(_, on)| on.as_ref() == Some(&everything));
    assert_eq!(all.map(|(unknown, _)| unknown.to_string()).collect::<Vec<_>>(), ["t_next"]);
    let long = self::xml(11);
    let long = dependencies(long.split_once("<InitialUnknowns>").unwrap().1, 11);
    let unlisted = long.iter().filter(|(_, on)| on.is_none()).map(|(unknown, _)| unknown.to_string());
    assert_eq!(unlisted.collect::<Vec<_>>(), ["t_next"]);
    let unknowns: Vec<Variable> = described.iter().map(|(unknown, _)| *unknown).collect();
    let mut seen: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let others = ["", "solver.method=rk4 solver.fixedStep=1e-3", TOUCHING].map(str::to_owned);
    for settings in LAWS.map(|law| format!("{law} {PRESSED}")).into_iter().chain(others) {
        let host = initializing(&settings);
        let before = values(&host, &unknowns).unwrap();
        for known in variables(BALLS).filter(|variable| variable.row.settable()) {
            let name = known.to_string();
            let real = known.row.access.data_type() == Type::Real;
            let old = host.get(&name);
            let others: &[f64] = if real {
                &[0.7 * old, 1.3 * old, old - 1e-3, old - 1e-5, old + 1e-5, old + 1e-3]
            } else {
                &[1.0, 2.0, 3.0, 4.0]
            };
            for other in others.iter().filter(|other| **other != old) {
                if host.set(&name, *other) != fmi2OK {
                    continue;
                }
                let after = values(&host, &unknowns).unwrap_or_else(|| before.clone());
                for (unknown, (before, after)) in unknowns.iter().zip(before.iter().zip(&after)) {
                    if before != after {
                        seen.entry(unknown.to_string()).or_default().insert(name.clone());
                    }
                }
            }
            host.give(&format!("{name}={old}"));
            assert_eq!(values(&host, &unknowns).as_ref(), Some(&before), "{name}");
        }
    }
    for (unknown, dependencies) in described {
        let mut seen = seen.remove(&unknown.to_string()).unwrap_or_default();
        // Small swings on arcs may have the same digits.
        let model = "pendulum.model".to_owned();
        seen.extend(dependencies.iter().flatten().filter(|name| **name == model).cloned());
        assert_eq!(Some(seen), dependencies, "{unknown}");
    }
}

/// The force between rigid balls at rest against each other depends on all of them, so it appears when the run begins.
#[test]
fn description_rigid_contacts_transmit_nothing_before_the_run() {
    let host = initializing(TOUCHING);
    let t_next = host.get("t_next");
    for name in ["F", "F_mean", "F_peak", "pulses"] {
        assert_eq!(host.each(name), [0.0; 4], "{name}");
    }
    assert_eq!(host.each("t_onset"), [-1e30; 4]);
    assert!((1..BALLS).all(|i| host.sensitivity(&format!("F[{i}]"), "F_ext[1]") == 0.0));
    assert_eq!(host.exit(), fmi2OK);
    for name in ["F", "F_mean", "F_peak"] {
        let forces = host.each(name);
        assert!(forces.iter().zip([4.6, 4.2, 3.8, 3.4]).all(|(own, force)| (own - force).abs() < 1e-14), "{forces:?}");
    }
    assert_eq!([host.each("pulses"), host.each("t_onset")], [[1.0; 4], [0.0; 4]]);
    assert_eq!(host.get("t_next"), t_next);
}
