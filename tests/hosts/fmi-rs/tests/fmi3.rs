//! FMI 3.0 with the `fmi` crate as the host: cradles of any size, their events and clocks. For FMI 2.0, fmi-sim is a
//! host of that crate (`test_hosts.py`).

use fmi::EventFlags;
use fmi::fmi3::import::Fmi3Import;
use fmi::fmi3::{CoSimulation, Common, Fmi3Model, GetSet};
use newtons_cradle::engine::{Engine, Results};
use newtons_cradle::variables::{START_TIME, STOP_TIME, Settings, Variable};

fn vr(name: &str) -> u32 {
    Variable::array(name).unwrap().reference()
}

/// Ticks of the current Event Mode: counts onsets and releases of each contact.
fn count_ticks(instance: &mut impl Common, onsets: &mut [u64], releases: &mut [u64]) -> EventFlags {
    let mut flags = EventFlags::default();
    loop {
        for (clock, which, counts) in
            [("onset.clock", "onset.closed", &mut *onsets), ("release.clock", "release.opened", &mut *releases)]
        {
            let (mut active, mut closed) = ([false], vec![false; counts.len()]);
            instance.get_clock(&[vr(clock)], &mut active).unwrap();
            instance.get_boolean(&[vr(which)], &mut closed).unwrap();
            counts.iter_mut().zip(closed).for_each(|(count, closed)| *count += u64::from(active[0] && closed));
        }
        instance.update_discrete_states(&mut flags).unwrap();
        if !flags.discrete_states_need_update {
            return flags;
        }
    }
}

#[test]
fn steps_end_at_the_events_of_a_cradle_of_any_size() {
    let import: Fmi3Import = fmi::import::from_path(cradle_host_fmi_rs::fmu3()).unwrap();
    for balls in [1, 2, 5, 13, 1000] {
        let mut instance = import.instantiate_cs("cradle", false, true, true, true, &[]).unwrap();
        assert_eq!(instance.get_version(), "3.0");
        instance.enter_configuration_mode().unwrap();
        instance.set_uint64(&[vr("n")], &[balls as u64]).unwrap();
        instance.exit_configuration_mode().unwrap();
        instance.enter_initialization_mode(None, START_TIME, None).unwrap();
        instance.exit_initialization_mode().unwrap();
        let (mut onsets, mut releases) = (vec![0; balls], vec![0; balls]);
        count_ticks(&mut instance, &mut onsets, &mut releases);
        instance.enter_step_mode().unwrap();

        let settings = Settings::default_for(balls);
        let mut engine = Engine::new(&settings.parameters, &settings.inputs, START_TIME).unwrap();
        let stop = if balls == 1000 { 1.0 } else { STOP_TIME };
        let mut time = START_TIME;
        while time < stop {
            let (mut events, mut terminate, mut early, mut reached) = (false, false, false, time);
            instance.do_step(time, stop - time, true, &mut events, &mut terminate, &mut early, &mut reached).unwrap();
            assert!(reached > time && !terminate && (events || !early));
            time = reached;
            if events {
                instance.enter_event_mode().unwrap();
                count_ticks(&mut instance, &mut onsets, &mut releases);
                instance.enter_step_mode().unwrap();
            }
        }
        engine.advance(stop, &mut Vec::new()).unwrap();
        let (mut x, mut pulses) = (vec![f64::NAN; balls], vec![0; balls]);
        instance.get_float64(&[vr("x")], &mut x).unwrap();
        instance.get_uint64(&[vr("pulses")], &mut pulses).unwrap();
        let expected: Vec<u64> = (0..balls).map(|i| engine.x(i).to_bits()).collect();
        assert_eq!(x.iter().map(|x| x.to_bits()).collect::<Vec<u64>>(), expected);
        let counted: Vec<u64> = (0..balls - 1).map(|i| engine.pulses(i)).chain([0]).collect();
        assert_eq!((&pulses, &onsets), (&counted, &counted));
        assert!(balls == 1 || pulses.iter().any(|count| *count > 0));
        assert!(instance.set_uint64(&[vr("n")], &[3]).is_err());
    }
}
