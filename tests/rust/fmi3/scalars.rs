//! FMI 3.0 without arrays: the variables of FMI 2.0 with their value references.

use std::ffi::CString;

use newtons_cradle::fmi3::fmi3Status::fmi3Discard;
use newtons_cradle::variables::variables;

use super::*;

fn instantiated(co_simulation: Option<[bool; 2]>) -> Host {
    let token = Description { scalars: true, ..Description::fmi3(&Settings::default_for(5)) }.guid();
    Host::instantiated(&CString::new(token).unwrap(), co_simulation).unwrap()
}

#[test]
fn fmi3_scalars_description_has_the_variables_of_fmi_2() {
    for balls in [1, 2, 5, 13] {
        let settings = Settings::default_for(balls);
        let xml = Description { scalars: true, ..Description::fmi3(&settings) }.xml("2000-01-01T00:00:00Z");
        Fmi3ModelDescription::deserialize(&xml).unwrap();
        assert!(!xml.contains("<Dimension") && !xml.contains(" name=\"n\"") && !xml.contains(" name=\"q"));
        for variable in variables(balls).filter(|variable| variable.row.name != "t_next_isOnset") {
            let expected = format!(" name=\"{variable}\" valueReference=\"{}\"", variable.reference());
            assert!(xml.contains(&expected), "{expected}");
        }
        let count = |element: &str| xml.matches(&format!("<{element} ")).count();
        assert_eq!((count("ContinuousStateDerivative"), count("EventIndicator")), (3 * balls + 1, 2 * (balls - 1)));
        let mut references: Vec<&str> =
            xml.split(" name=\"").skip(1).filter_map(|rest| rest.split(" valueReference=\"").nth(1)).collect();
        references.iter_mut().for_each(|rest| *rest = rest.split('"').next().unwrap());
        assert_eq!(references.iter().collect::<BTreeSet<_>>().len(), references.len(), "each has its own");
    }
}

#[test]
fn fmi3_scalars_states_and_values_are_those_of_fmi_2() {
    let (host, other) = (instantiated(None), cradle_host::Host::exchanging(5));
    other.start();
    host.start();
    other.update();
    assert_eq!(host.update().0, fmi3OK);
    assert_eq!(host.vector::<16>(fmi3GetContinuousStates), other.states()[..]);
    for variable in variables(5).filter(|variable| variable.row.quantity.is_some()) {
        let mut value = f64::NAN;
        assert_eq!(unsafe { fmi3GetFloat64(host.c, &variable.reference(), 1, &mut value, 1) }, fmi3OK, "{variable}");
        assert_eq!(value, other.get(&variable.to_string()), "{variable}");
    }
    // Each state can be set as a variable.
    let references: Vec<u32> = newtons_cradle::variables::states(5).map(|(state, _)| state.reference()).collect();
    let values: Vec<f64> = (1..=16).map(f64::from).collect();
    unsafe {
        assert_eq!(fmi3EnterContinuousTimeMode(host.c), fmi3OK);
        assert_eq!(fmi3SetFloat64(host.c, references.as_ptr(), 16, values.as_ptr(), 16), fmi3OK);
        assert_eq!(host.vector::<16>(fmi3GetContinuousStates), values[..]);
        assert_eq!(fmi3SetFloat64(host.c, &references[3], 1, &f64::NAN, 1), fmi3Discard);
    }
}

#[test]
fn fmi3_scalars_know_no_arrays_and_no_n() {
    for name in ["n", "q", "x", "onset.closed"] {
        let (host, mut values) = (instantiated(Some([true, true])), [0.0; 5]);
        host.start();
        assert_eq!(unsafe { fmi3GetFloat64(host.c, &vr(name), 1, values.as_mut_ptr(), 5) }, fmi3Error, "{name}");
        assert!(host.log().concat().contains("value reference"), "{name}");
    }
    // An element of a clocked array belongs to a contact.
    let host = instantiated(Some([true, true]));
    host.start();
    let reference = |index| Variable::array("release.impulse").unwrap().element(index).reference();
    let mut value = f64::NAN;
    assert_eq!(unsafe { fmi3GetFloat64(host.c, &reference(3), 1, &mut value, 1) }, fmi3OK);
    assert_eq!(unsafe { fmi3GetFloat64(host.c, &reference(4), 1, &mut value, 1) }, fmi3Error);
}
