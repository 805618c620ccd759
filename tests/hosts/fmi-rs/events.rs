//! Runs an FMU of the cradle of FMI 3.0 by the crate `fmi`, with event mode and early return, in a step from each event
//! to the next:
//!
//!     events FMU BALLS STOP
//!
//! Prints x, `pulses`, and how often the clocks have told the onset and the release of each contact, a line each.

use fmi::EventFlags;
use fmi::fmi3::import::Fmi3Import;
use fmi::fmi3::{CoSimulation, Common, Fmi3Model, GetSet};
use fmi::traits::FmiImport;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [fmu, balls, stop] = arguments.as_slice() else { panic!("see the source") };
    let (balls, stop): (usize, f64) = (balls.parse().unwrap(), stop.parse().unwrap());
    let import: Fmi3Import = fmi::import::from_path(fmu).unwrap();
    let variables = &import.model_description().model_variables;
    let vr = |name: &str| variables.find_by_name(name).unwrap().value_reference();

    let mut instance = import.instantiate_cs("cradle", false, true, true, true, &[]).unwrap();
    assert_eq!(instance.get_version(), "3.0");
    instance.enter_configuration_mode().unwrap();
    instance.set_uint64(&[vr("n")], &[balls as u64]).unwrap();
    instance.exit_configuration_mode().unwrap();
    instance.enter_initialization_mode(None, 0.0, None).unwrap();
    instance.exit_initialization_mode().unwrap();
    let clocks = [("onset.clock", "onset.closed"), ("release.clock", "release.opened")];
    let (mut ticks, mut time, mut events) = ([vec![0_u64; balls], vec![0; balls]], 0.0, true);
    loop {
        if events {
            let mut flags = EventFlags { discrete_states_need_update: true, ..EventFlags::default() };
            while flags.discrete_states_need_update {
                for ((clock, which), counts) in clocks.into_iter().zip(&mut ticks) {
                    let (mut active, mut told) = ([false], vec![false; balls]);
                    instance.get_clock(&[vr(clock)], &mut active).unwrap();
                    instance.get_boolean(&[vr(which)], &mut told).unwrap();
                    counts.iter_mut().zip(told).for_each(|(count, told)| *count += u64::from(active[0] && told));
                }
                instance.update_discrete_states(&mut flags).unwrap();
            }
            instance.enter_step_mode().unwrap();
        }
        if time >= stop {
            break;
        }
        let (mut terminate, mut early, mut reached) = (false, false, time);
        instance.do_step(time, stop - time, true, &mut events, &mut terminate, &mut early, &mut reached).unwrap();
        assert!(reached > time && !terminate && (events || !early));
        time = reached;
        if events {
            instance.enter_event_mode().unwrap();
        }
    }
    let (mut x, mut pulses) = (vec![f64::NAN; balls], vec![0; balls]);
    instance.get_float64(&[vr("x")], &mut x).unwrap();
    instance.get_uint64(&[vr("pulses")], &mut pulses).unwrap();
    assert!(instance.set_uint64(&[vr("n")], &[3]).is_err());
    println!("{x:?}\n{pulses:?}\n{:?}\n{:?}", ticks[0], ticks[1]);
}
