//! Model exchange of FMI 3.0: the same bits as in FMI 2.0, and one tick for each onset and release.

use newtons_cradle::fmi3::fmi3Status::fmi3Discard;

use super::*;

/// All ticks of an event: counts onsets and releases of each contact, and adds up the impulses.
fn count_ticks(host: &Host, onsets: &mut [u64; 5], releases: &mut [u64; 5], impulses: &mut [f64; 5]) -> bool {
    let mut changed = false;
    loop {
        for (clock, flags, counts) in
            [("onset.clock", "onset.closed", &mut *onsets), ("release.clock", "release.opened", &mut *releases)]
        {
            if host.is_active(clock) {
                counts.iter_mut().zip(host.flags(flags, 5)).for_each(|(count, flag)| *count += u64::from(flag));
            }
        }
        assert_eq!(host.counts("pulses", 5), *onsets, "they follow the ticks");
        if host.is_active("release.clock") {
            let released = host.floats("release.impulse", 5);
            impulses.iter_mut().zip(released).for_each(|(sum, impulse)| *sum += impulse);
        }
        let (status, again, values, _) = host.update();
        assert_eq!(status, fmi3OK);
        changed |= values;
        if !again {
            return changed;
        }
    }
}

/// As an instance of FMI 2.0 has them: without the impulse that belongs to no contact.
fn own(states: [f64; 17]) -> Vec<f64> {
    assert_eq!(states[14], 0.0);
    [&states[..14], &states[15..]].concat()
}

#[test]
fn fmi3_exchange_has_the_bits_of_fmi_2_and_a_tick_for_each_pulse() {
    // Mapped, and resolved by steps that take some to a contact.
    for (contacts, h) in [(2, 1e-3), (1, 2e-4)] {
        let other = cradle_host::Host::exchanging(5);
        let exchange = Host::exchanging();
        let c = exchange.c;
        assert_eq!([exchange.set("contact.stiffness", &[1e5]), exchange.set("contact.damping", &[1.0])], [fmi3OK; 2]);
        assert_eq!(unsafe { fmi3SetInt64(c, &vr("exchange.contacts"), 1, &contacts, 1) }, fmi3OK);
        other.give(&format!("contact.stiffness=1e5 contact.damping=1 exchange.contacts={contacts}"));
        other.start();
        exchange.start();
        let (mut onsets, mut releases, mut impulses) = ([0; 5], [0; 5], [0.0; 5]);
        for k in 1..=8000 {
            let before = other.states();
            other.update();
            let changed = count_ticks(&exchange, &mut onsets, &mut releases, &mut impulses);
            assert!(changed || before == other.states(), "{k}");
            let states = own(exchange.vector::<17>(fmi3GetContinuousStates));
            assert_eq!(states, other.states(), "{k}");
            let rates = exchange.vector::<17>(fmi3GetContinuousStateDerivatives);
            assert_eq!(own(rates), other.rates());
            let indicators = exchange.vector::<10>(fmi3GetEventIndicators);
            assert_eq!([&indicators[..4], &indicators[5..9]].concat(), other.indicators());
            assert_eq!([indicators[4], indicators[9]], [1.0; 2]);
            assert_eq!(exchange.floats("z.contact", 5), indicators[..5]);
            assert_eq!(exchange.floats("z.clip", 5), indicators[5..]);
            assert_eq!(exchange.floats("q", 5), states[..5]);
            assert_eq!(exchange.floats("der(q)", 5), rates[..5]);
            assert_eq!(exchange.floats("E_total", 1)[0], other.get("E_total"));
            let (mut next, time) = (exchange.vector::<17>(fmi3GetContinuousStates), f64::from(k) * h);
            next.iter_mut().zip(&rates).for_each(|(y, rate)| *y += h * rate);
            other.place(time, &own(next));
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
        count_ticks(&exchange, &mut onsets, &mut releases, &mut impulses);
        let pulses = exchange.counts("pulses", 5);
        let expected: Vec<u64> = (1..5).map(|i| other.get(&format!("pulses[{i}]")) as u64).collect();
        assert_eq!(pulses[..4], expected);
        assert_eq!(pulses, onsets);
        assert!(pulses[..4].iter().all(|count| *count > 0) && pulses[4] == 0, "{pulses:?}");
        let closed = exchange.flags("inContact", 5);
        for i in 0..5 {
            assert_eq!(releases[i] + u64::from(closed[i]), onsets[i]);
            let impulse = exchange.floats("impulse", 5)[i];
            assert!(closed[i] || (impulses[i] - impulse).abs() <= 1e-12 * impulse, "{impulses:?} {impulse}");
        }
    }
}

/// In Continuous-Time Mode states can be set as variables, too; the time does not go back behind an event.
#[test]
fn fmi3_exchange_states_are_set_as_variables() {
    let exchange = Host::exchanging();
    exchange.start();
    let c = exchange.c;
    assert_eq!(unsafe { fmi3EnterContinuousTimeMode(c) }, fmi3OK);
    let (mut expected, speeds) = (exchange.vector::<17>(fmi3GetContinuousStates), [1.0, 2.0, 3.0, 4.0, 5.0]);
    let lost = |energy| exchange.set("E_dissipated", &[energy]);
    assert_eq!((exchange.set("v", &speeds), lost(0.25), lost(f64::INFINITY)), (fmi3OK, fmi3OK, fmi3Discard));
    expected[5..10].copy_from_slice(&speeds);
    expected[15] = 0.25;
    assert_eq!(exchange.vector::<17>(fmi3GetContinuousStates), expected);
    assert_eq!(exchange.floats("v", 5), speeds);
    unsafe {
        assert_eq!(fmi3SetTime(c, 0.1), fmi3OK);
        assert_eq!(fmi3EnterEventMode(c), fmi3OK);
        assert_eq!(exchange.update().0, fmi3OK);
        assert_eq!(fmi3EnterContinuousTimeMode(c), fmi3OK);
        assert_eq!(fmi3SetTime(c, 0.05), fmi3Error);
    }
}
