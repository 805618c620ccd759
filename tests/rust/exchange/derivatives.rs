//! Directional derivatives by states and inputs: against differences, and against the structure in the description.

use std::collections::{BTreeMap, BTreeSet};

use cradle_host::exchange::{Master, rk4};
use cradle_host::{Host, fmi2OK};
use newtons_cradle::model::ContactModel;
use newtons_cradle::variables::{Causality, Description, Settings, Type, Variable, states, variables};

use super::exchanging;
use crate::differences::{by_differences, dependencies};

const BALLS: usize = 5;

/// Compliant contacts of all laws.
const LAWS: [&str; 8] = [
    "",
    "contact.dampingLaw=kelvinVoigtNoPull",
    "contact.dampingLaw=huntCrossley contact.exponent=1.5",
    "contact.dampingLaw=viscoelastic contact.exponent=2.3",
    "contact.model=hertz",
    "contact.model=hertz contact.dampingLaw=viscoelastic",
    "contact.exponent=3",
    "contact.dampingLaw=constantRestitution contact.exponent=1.5 contact.restitution=0.9 contact.lossRatio=1,0,2,0.5",
];
const RIGID: &str = "contact.model=rigid";
const ARCS: &str = "pendulum.model=circular";

/// A component with contacts that are closed from the start.
fn pressed(settings: &str) -> Master {
    let placed = if settings == RIGID {
        "x_start=0"
    } else {
        "x_start=3e-6,1e-6,-1e-6,1.2,1.1999985 v_start=0.1,0.04,-0.02,-0.08,-0.14"
    };
    let all = "ball.massRatio=1,1.2,1.4,1.6,1.8 F_ext=5,3,1,-1,-3 a_support=0.7 pendulum.drag=0.3 contact.deadBand=0 \
               contact.damping=1e2 contact.huntCrossley=0.2 contact.relaxationTime=1e-6 exchange.contacts=resolved";
    exchanging(BALLS, &format!("{all} {placed} {settings}"))
}

/// Outputs and derivatives of states that are continuous.
fn unknowns() -> Vec<Variable> {
    let continuous = |v: &Variable| v.row.access.data_type() == Type::Real && v.row.derivative.is_some();
    let outputs = variables(BALLS).filter(|v| v.row.causality == Causality::Output);
    let rates = states(BALLS).map(|(_, rate)| rate).filter(|rate| rate.row.causality != Causality::Output);
    outputs.chain(rates).filter(continuous).filter(|v| !["t_next", "F_peak"].contains(&v.row.name)).collect()
}

/// The states with their places and steps for differences, and the inputs.
fn knowns(host: &Host) -> Vec<(Variable, Option<usize>, f64)> {
    let nominals = host.nominals();
    let of_states = states(BALLS).enumerate().map(|(place, (state, _))| (state, Some(place), 1e-4 * nominals[place]));
    let inputs = variables(BALLS).filter(|variable| variable.row.causality == Causality::Input);
    of_states.chain(inputs.map(|input| (input, None, 1e-2))).collect()
}

#[test]
fn exchange_derivatives_agree_with_differences() {
    let unknowns = unknowns();
    let on_arcs = LAWS.map(|law| format!("{law} {ARCS}"));
    for law in LAWS.into_iter().chain([RIGID]).map(str::to_owned).chain(on_arcs) {
        let host = pressed(&law);
        assert!(host.get("F[1]") > 0.0);
        let (base, y) = (host.values(&unknowns), host.states());
        for (known, place, step) in knowns(&host) {
            let exact = host.along(&unknowns, &[known], &[1.0]);
            let old = host.get(&known.to_string());
            let shifted = |by: f64| {
                match place {
                    Some(place) => {
                        let mut y = y.clone();
                        y[place] += by;
                        host.place(0.0, &y);
                    }
                    None => assert_eq!(host.set(&known.to_string(), old + by), fmi2OK),
                }
                host.values(&unknowns)
            };
            let (differences, rounding) = by_differences(step, false, shifted);
            shifted(0.0);
            for (i, unknown) in unknowns.iter().enumerate() {
                let (exact, difference) = (exact[i], differences[i]);
                // On arcs the strings bear a part of the contact forces, which nearly cancel.
                let supports = law.contains(ARCS) && unknown.row.name.starts_with("F_support");
                let size = if supports {
                    base.iter().fold(0.0, |most: f64, value| most.max(value.abs()))
                } else {
                    base[i].abs()
                };
                let allowed = 1e-4 * exact.abs() + 1e-13 * rounding * size + 1e-9;
                assert!((exact - difference).abs() <= allowed, "{law}: {unknown} by {known}: {exact} {difference}");
            }
        }
        assert_eq!(host.values(&unknowns), base);
    }
}

#[test]
fn exchange_structure_lists_what_depends() {
    let unknowns = unknowns();
    for (rigid, laws) in [(false, &LAWS[..]), (true, &[RIGID])] {
        let mut settings = Settings::default_for(BALLS);
        if rigid {
            settings.parameters.contact_model = ContactModel::Rigid;
        }
        let xml = Description::of(&settings).xml("2000-01-01T00:00:00Z");
        let described = dependencies(xml.split_once("<InitialUnknowns>").unwrap().0, BALLS);
        let described: BTreeMap<String, BTreeSet<String>> =
            described.into_iter().map(|(unknown, on)| (unknown.to_string(), on.unwrap())).collect();
        let mut seen: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for law in laws {
            let host = pressed(law);
            for (known, ..) in knowns(&host) {
                let exact = host.along(&unknowns, &[known], &[1.0]);
                for (unknown, _) in unknowns.iter().zip(&exact).filter(|(_, derivative)| **derivative != 0.0) {
                    seen.entry(unknown.to_string()).or_default().insert(known.to_string());
                }
            }
        }
        for unknown in &unknowns {
            let name = unknown.to_string();
            let seen = seen.remove(&name).unwrap_or_default();
            assert!(seen.is_subset(&described[&name]), "{name}: {seen:?} {:?}", described[&name]);
            // Listed dependencies on closed compliant contacts are not 0.
            let excess: Vec<&String> = described[&name].difference(&seen).collect();
            let of_open = |known: &&&String| !["overlap[3]", "v[3]", "v[4]"].contains(&known.as_str());
            assert!(rigid || excess.iter().filter(of_open).count() == 0, "{name}: {excess:?}");
        }
    }
}

#[test]
fn exchange_rates_are_the_derivative_variables() {
    let mut run = exchanging(BALLS, "");
    let (states, rates): (Vec<_>, Vec<_>) = states(BALLS).unzip();
    let arrays = Variable::states().flat_map(|(array, _)| (0..array.len(BALLS)).map(move |i| array.element(i)));
    assert!(states.iter().enumerate().all(|(i, state)| state.state_place(BALLS, true) == Some(i)));
    assert!(arrays.enumerate().all(|(i, state)| state.state_place(BALLS, false) == Some(i)));
    for k in 1..20 {
        run.steps(0.1 * f64::from(k), 1e-3, rk4);
        assert_eq!([run.values(&states), run.values(&rates)], [run.states(), run.rates()]);
    }
}
