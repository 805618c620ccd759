//! Model exchange of FMI 3.0: legal calls by phase (FMI 3.0.2, section 3.2), the same bits as in FMI 2.0, and one tick
//! for each onset and release.

use std::ffi::CString;
use std::ptr::null;

use newtons_cradle::fmi3::fmi3Status::fmi3Discard;

use super::*;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Instantiated,
    Configuration,
    Initialization,
    Event,
    Continuous,
    Terminated,
    Abandoned,
}

const PHASES: [(Phase, State); 7] = [
    (Phase::Instantiated, Instantiated),
    (Phase::Configuration, Configuration),
    (Phase::Initialization, Initialization),
    (Phase::Event, Event),
    // What may be called between events: a host sets and reads as between steps.
    (Phase::Continuous, Step),
    (Phase::Terminated, Terminated),
    (Phase::Abandoned, Abandoned),
];

const EVERY: &[Phase] = &[
    Phase::Instantiated,
    Phase::Configuration,
    Phase::Initialization,
    Phase::Event,
    Phase::Continuous,
    Phase::Terminated,
    Phase::Abandoned,
];
const CONTINUOUS: &[Phase] = &[Phase::Initialization, Phase::Event, Phase::Continuous, Phase::Terminated];

/// What is legal elsewhere than in co-simulation; `Step` there is `Continuous` here.
const OTHERWISE: [(&str, &[Phase]); 18] = [
    ("fmi3EnterStepMode", &[]),
    ("fmi3DoStep", &[]),
    ("fmi3GetOutputDerivatives", &[]),
    ("fmi3EnterContinuousTimeMode", &[Phase::Event]),
    ("fmi3CompletedIntegratorStep", &[Phase::Continuous]),
    ("fmi3SetTime", &[Phase::Continuous]),
    ("fmi3SetContinuousStates", &[Phase::Continuous]),
    ("fmi3GetContinuousStateDerivatives", CONTINUOUS),
    ("fmi3GetEventIndicators", CONTINUOUS),
    ("fmi3GetContinuousStates", CONTINUOUS),
    (
        "fmi3GetNominalsOfContinuousStates",
        &[Phase::Instantiated, Phase::Initialization, Phase::Event, Phase::Continuous, Phase::Terminated],
    ),
    ("fmi3GetNumberOfEventIndicators", EVERY),
    ("fmi3GetNumberOfContinuousStates", EVERY),
    // Discrete variables change in events only.
    ("fmi3SetInt64", &[Phase::Instantiated, Phase::Initialization, Phase::Event]),
    ("fmi3SetBoolean", &[Phase::Instantiated, Phase::Initialization, Phase::Event]),
    ("fmi3SetClock", &[Phase::Instantiated, Phase::Initialization, Phase::Event]),
    ("fmi3SetBinary", &[Phase::Instantiated, Phase::Initialization, Phase::Event]),
    ("fmi3SetUInt64", &[Phase::Configuration]),
];

/// An instance of model exchange with five balls, freed in the end.
struct Exchange(fmi3Instance);

impl Exchange {
    fn new() -> Self {
        let token = CString::new(Description::fmi3(&Settings::default_for(5)).guid()).unwrap();
        let c =
            unsafe { fmi3InstantiateModelExchange(c"test".as_ptr(), token.as_ptr(), null(), 0, 0, null_mut(), None) };
        assert!(!c.is_null());
        Self(c)
    }

    fn enter(&self) {
        assert_eq!(unsafe { fmi3EnterInitializationMode(self.0, 0, 0.0, 0.0, 0, 0.0) }, fmi3OK);
    }

    fn start(&self) {
        self.enter();
        assert_eq!(unsafe { fmi3ExitInitializationMode(self.0) }, fmi3OK);
    }

    fn to(phase: Phase) -> Self {
        let exchange = Self::new();
        let c = exchange.0;
        unsafe {
            match phase {
                Phase::Instantiated => {}
                Phase::Configuration => assert_eq!(fmi3EnterConfigurationMode(c), fmi3OK),
                Phase::Abandoned => assert_eq!(fmi3EnterStepMode(c), fmi3Error),
                Phase::Initialization => exchange.enter(),
                Phase::Event | Phase::Continuous | Phase::Terminated => exchange.start(),
            }
            match phase {
                Phase::Continuous => assert_eq!(fmi3EnterContinuousTimeMode(c), fmi3OK),
                Phase::Terminated => assert_eq!(fmi3Terminate(c), fmi3OK),
                _ => {}
            }
        }
        exchange
    }

    fn vector(
        &self,
        get: unsafe extern "C" fn(fmi3Instance, *mut f64, usize) -> fmi3Status,
        length: usize,
    ) -> Vec<f64> {
        let mut values = vec![f64::NAN; length];
        assert_eq!(unsafe { get(self.0, values.as_mut_ptr(), length) }, fmi3OK);
        values
    }

    fn floats<const N: usize>(&self, name: &str) -> [f64; N] {
        let mut values = [f64::NAN; N];
        assert_eq!(unsafe { fmi3GetFloat64(self.0, &vr(name), 1, values.as_mut_ptr(), N) }, fmi3OK);
        values
    }

    fn flags(&self, name: &str) -> [u8; 5] {
        let mut values = [0; 5];
        assert_eq!(unsafe { fmi3GetBoolean(self.0, &vr(name), 1, values.as_mut_ptr(), 5) }, fmi3OK);
        values
    }

    fn is_active(&self, clock: &str) -> bool {
        let mut active = 0;
        assert_eq!(unsafe { fmi3GetClock(self.0, &vr(clock), 1, &mut active) }, fmi3OK);
        active != 0
    }

    /// All ticks of an event: counts onsets and releases of each contact, and adds up the impulses.
    fn count_ticks(&self, onsets: &mut [u64; 5], releases: &mut [u64; 5], impulses: &mut [f64; 5]) -> bool {
        let mut changed = false;
        loop {
            if self.is_active("onset.clock") {
                onsets.iter_mut().zip(self.flags("onset.closed")).for_each(|(count, flag)| *count += u64::from(flag));
            }
            if self.is_active("release.clock") {
                releases
                    .iter_mut()
                    .zip(self.flags("release.opened"))
                    .for_each(|(count, flag)| *count += u64::from(flag));
                impulses.iter_mut().zip(self.floats::<5>("release.impulse")).for_each(|(sum, impulse)| *sum += impulse);
            }
            let (mut flags, mut time) = ([0_u8; 5], 0.0);
            let [again, terminate, nominals, values, defined] = &mut flags;
            let status =
                unsafe { fmi3UpdateDiscreteStates(self.0, again, terminate, nominals, values, defined, &mut time) };
            assert_eq!(status, fmi3OK);
            changed |= *values != 0;
            if *again == 0 {
                return changed;
            }
        }
    }
}

impl Drop for Exchange {
    fn drop(&mut self) {
        unsafe { fmi3FreeInstance(self.0) };
    }
}

/// The calls of the other kind of instance, with those that need arguments of their size.
fn asked(name: &str, other: Asked) -> Asked {
    match name {
        "fmi3SetContinuousStates" => |c| unsafe { fmi3SetContinuousStates(c, [0.0; 17].as_ptr(), 17) },
        "fmi3GetContinuousStateDerivatives" => {
            |c| unsafe { fmi3GetContinuousStateDerivatives(c, [0.0; 17].as_mut_ptr(), 17) }
        }
        "fmi3GetEventIndicators" => |c| unsafe { fmi3GetEventIndicators(c, [0.0; 10].as_mut_ptr(), 10) },
        "fmi3GetContinuousStates" => |c| unsafe { fmi3GetContinuousStates(c, [0.0; 17].as_mut_ptr(), 17) },
        "fmi3GetNominalsOfContinuousStates" => {
            |c| unsafe { fmi3GetNominalsOfContinuousStates(c, [0.0; 17].as_mut_ptr(), 17) }
        }
        _ => other,
    }
}

#[test]
fn calls_of_model_exchange_are_legal_where_the_standard_has_them() {
    let functions = functions();
    for (name, _) in OTHERWISE {
        assert!(functions.iter().any(|(known, ..)| *known == name), "{name}");
    }
    for (name, legal, other) in functions {
        let own = OTHERWISE.iter().find(|(known, _)| *known == name);
        let discrete = own.is_none() && legal == SET_DISCRETE;
        for (phase, alike) in PHASES {
            let is_legal = own.map_or(legal.contains(&alike), |(_, phases)| phases.contains(&phase));
            let expected = if is_legal && !(discrete && phase == Phase::Continuous) { fmi3OK } else { fmi3Error };
            assert_eq!(asked(name, other)(Exchange::to(phase).0), expected, "{name} in {phase:?}");
        }
    }
}

/// As an instance of FMI 2.0 has them: without the impulse that belongs to no contact.
fn own(mut states: Vec<f64>) -> Vec<f64> {
    assert_eq!(states.remove(14), 0.0);
    states
}

#[test]
fn the_bits_are_those_of_fmi_2_and_each_pulse_ticks() {
    // Mapped, and resolved by steps that take some to a contact.
    for (contacts, h) in [(2, 1e-3), (1, 2e-4)] {
        let other = cradle_host::Host::exchanging(5);
        let exchange = Exchange::new();
        let c = exchange.0;
        for (name, value) in [("contact.stiffness", 1e5), ("contact.damping", 1.0)] {
            assert_eq!(other.set(name, value), cradle_host::fmi2OK);
            assert_eq!(unsafe { fmi3SetFloat64(c, &vr(name), 1, &value, 1) }, fmi3OK);
        }
        assert_eq!(other.set_integer("exchange.contacts", contacts), cradle_host::fmi2OK);
        assert_eq!(unsafe { fmi3SetInt64(c, &vr("exchange.contacts"), 1, &i64::from(contacts), 1) }, fmi3OK);
        other.start();
        exchange.start();
        let (mut onsets, mut releases, mut impulses) = ([0; 5], [0; 5], [0.0; 5]);
        for k in 1..=8000 {
            let before = other.states();
            other.update();
            let changed = exchange.count_ticks(&mut onsets, &mut releases, &mut impulses);
            assert!(changed || before == other.states(), "{k}");
            let states = own(exchange.vector(fmi3GetContinuousStates, 17));
            assert_eq!(states, other.states(), "{k}");
            let rates = exchange.vector(fmi3GetContinuousStateDerivatives, 17);
            assert_eq!(own(rates.clone()), other.rates());
            let indicators = exchange.vector(fmi3GetEventIndicators, 10);
            assert_eq!([&indicators[..4], &indicators[5..9]].concat(), other.indicators());
            assert_eq!([indicators[4], indicators[9]], [1.0; 2]);
            assert_eq!(exchange.floats::<5>("z.contact"), indicators[..5]);
            assert_eq!(exchange.floats::<5>("z.clip"), indicators[5..]);
            assert_eq!(exchange.floats::<5>("q"), states[..5]);
            assert_eq!(exchange.floats::<5>("der(q)"), rates[..5]);
            assert_eq!(exchange.floats::<1>("E_total")[0], other.get("E_total"));
            let (mut next, time) = (exchange.vector(fmi3GetContinuousStates, 17), f64::from(k) * h);
            next.iter_mut().zip(&rates).for_each(|(y, rate)| *y += h * rate);
            other.place(time, &own(next.clone()));
            let (mut enter, mut terminate) = (0, 0);
            unsafe {
                assert_eq!(fmi3EnterContinuousTimeMode(c), fmi3OK);
                assert_eq!(fmi3SetTime(c, time), fmi3OK);
                assert_eq!(fmi3SetContinuousStates(c, next.as_ptr(), 17), fmi3OK);
                assert_eq!(fmi3CompletedIntegratorStep(c, 1, &mut enter, &mut terminate), fmi3OK);
                assert_eq!(enter != 0, other.completed());
                assert_eq!(fmi3EnterEventMode(c), fmi3OK);
                assert_eq!(newtons_cradle::fmi2::fmi2EnterEventMode(other.c), cradle_host::fmi2OK);
            }
        }
        other.update();
        exchange.count_ticks(&mut onsets, &mut releases, &mut impulses);
        let mut pulses = [0; 5];
        assert_eq!(unsafe { fmi3GetUInt64(c, &vr("pulses"), 1, pulses.as_mut_ptr(), 5) }, fmi3OK);
        let expected: Vec<u64> = (1..5).map(|i| other.get_integer(&format!("pulses[{i}]")) as u64).collect();
        assert_eq!(pulses[..4], expected);
        assert_eq!(onsets, pulses);
        assert!(pulses[..4].iter().all(|count| *count > 0) && pulses[4] == 0, "{pulses:?}");
        let closed = exchange.flags("inContact");
        for i in 0..5 {
            assert_eq!(releases[i] + u64::from(closed[i]), onsets[i]);
            let impulse = exchange.floats::<5>("impulse")[i];
            assert!(closed[i] != 0 || (impulses[i] - impulse).abs() <= 1e-12 * impulse, "{impulses:?} {impulse}");
        }
    }
}

/// In Continuous-Time Mode states can be set as variables, too; the time does not go back behind an event.
#[test]
fn states_are_set_as_variables() {
    let exchange = Exchange::to(Phase::Continuous);
    let c = exchange.0;
    let (mut expected, speeds) = (exchange.vector(fmi3GetContinuousStates, 17), [1.0, 2.0, 3.0, 4.0, 5.0]);
    unsafe {
        assert_eq!(fmi3SetFloat64(c, &vr("v"), 1, speeds.as_ptr(), 5), fmi3OK);
        assert_eq!(fmi3SetFloat64(c, &vr("E_dissipated"), 1, &0.25, 1), fmi3OK);
        assert_eq!(fmi3SetFloat64(c, &vr("E_dissipated"), 1, &f64::INFINITY, 1), fmi3Discard);
    }
    expected[5..10].copy_from_slice(&speeds);
    expected[15] = 0.25;
    assert_eq!(exchange.vector(fmi3GetContinuousStates, 17), expected);
    assert_eq!(exchange.floats::<5>("v"), speeds);
    unsafe {
        assert_eq!(fmi3SetTime(c, 0.1), fmi3OK);
        assert_eq!(fmi3EnterEventMode(c), fmi3OK);
        assert_eq!(update(c), fmi3OK);
        assert_eq!(fmi3EnterContinuousTimeMode(c), fmi3OK);
        assert_eq!(fmi3SetTime(c, 0.05), fmi3Error);
    }
}
