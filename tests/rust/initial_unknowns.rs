//! InitialUnknowns: their dependencies in the description, against those found by trial in Initialization Mode.

use std::collections::{BTreeMap, BTreeSet};

use cradle_host::{Host, fmi2OK};
use newtons_cradle::variables::{Description, Settings, Type, Variable, variables};

use crate::differences::dependencies;

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
const LAWS: [&str; 7] = [
    "",
    "contact.dampingLaw=kelvinVoigtNoPull",
    "contact.dampingLaw=huntCrossley",
    "contact.model=hertz contact.dampingLaw=huntCrossley",
    "contact.dampingLaw=viscoelastic",
    "contact.model=hertz contact.dampingLaw=viscoelastic",
    "solver.method=bdf",
];

/// Rigid balls at rest in touch, pushed against each other.
const TOUCHING: &str = "contact.model=rigid contact.deadBand=0 x_start=0 F_ext[1]=5 F_ext[5]=-3";

/// Every known is changed in every set-up: unknowns change exactly if they list it. Only the time of the next onset
/// lists nothing.
#[test]
fn dependencies_are_those_of_the_values() {
    let xml = Description::of(&Settings::default_for(BALLS)).xml("2000-01-01T00:00:00Z");
    let mut described = dependencies(xml.split_once("<InitialUnknowns>").unwrap().1, BALLS);
    assert!(described.is_sorted_by_key(|(unknown, _)| unknown.reference()));
    let all = described.extract_if(.., |(_, on)| on.is_none()).map(|(unknown, _)| unknown.to_string());
    assert_eq!(all.collect::<Vec<_>>(), ["t_next"]);
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
fn rigid_contacts_transmit_nothing_before_the_run() {
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
