//! Balls that touch, at rest or pressed: an announced event changes something, so that events do not follow each other
//! for ever.

use cradle_host::exchange::{Master, rk4};
use proptest::prelude::*;

use super::exchanging;

/// Events that may follow each other without an onset.
const MOST: usize = 12;

/// Events of a whole run, whatever they do.
const TOTAL: usize = 300;

/// Integrates balls up to `time` (s), in which events without an onset come to an end; the onsets.
fn onsets(balls: usize, settings: &str, time: f64) -> usize {
    let onsets = |run: &Master| run.pulses().into_iter().sum::<i32>() as usize;
    let mut run = exchanging(balls, settings);
    let (mut before, mut at, mut most) = (onsets(&run), run.events, 0);
    while run.time < time && most <= MOST && run.events < TOTAL {
        run.step((run.time + 1e-5).min(run.next).min(time), rk4);
        let now = onsets(&run);
        (before, at) = if now > before { (now, run.events) } else { (before, at) };
        most = most.max(run.events - at);
    }
    assert!(most <= MOST && run.events < TOTAL, "{most} events without an onset, {} in all", run.events);
    before
}

#[test]
fn exchange_touching_balls_pressed_by_drag_close_once() {
    for (heavy, model) in [(1, "powerLaw"), (1, "hertz"), (2, "powerLaw")] {
        for contacts in ["resolved", "mapped"] {
            let of_all = "x_start=-0.03 contact.deadBand=0 pendulum.drag=0.02 contact.stiffness=1e7";
            let own = format!("ball.massRatio[{heavy}]=2 contact.model={model} exchange.contacts={contacts}");
            // The lighter ball is braked more: it is pressed if it goes ahead.
            assert_eq!(onsets(2, &format!("{of_all} {own}"), 5e-4), usize::from(heavy == 1), "{model}, {contacts}");
        }
    }
}

prop_compose! {
    /// A row that touches but for next to nothing: balls and settings.
    fn touching()(
        balls in 2..6_usize, model in 1..=2_u8, law in 1..=5_u8, contacts in 1..=2_u8,
        [mass, length, gravity, drag, force, shift] in prop::array::uniform6(0..3_usize),
        rows in prop::array::uniform5((
            0.5..2.0_f64, 0.8..1.2_f64, prop::sample::select(vec![0.0, 0.0, 1e-22, -1e-22, 1e-17, -1e-12]),
            prop::sample::select(vec![0.0, 0.0, 1e-17, -1e-17, 1e-9]), -20.0..20.0_f64,
        )),
    ) -> (usize, String) {
        let mut values = format!(
            "contact.deadBand=0 contact.stiffness=1e7 ball.youngModulus=2e8 contact.exponent={} gravity={} \
             pendulum.drag={} contact.damping={} contact.huntCrossley={} contact.relaxationTime={} \
             contact.restitution={} a_support={} \
             contact.model={model} contact.dampingLaw={law} exchange.contacts={contacts}",
            [1.0, 1.5, 2.0][force], [9.81, 9.81, 0.0][gravity], [0.0, 0.02, 1.0][drag], [0.0, 10.0, 1e3][drag],
            [0.0, 0.1, 1.0][drag], [0.0, 1e-6, 1e-5][drag], [1.0, 0.9, 0.3][drag], [0.0, 1.0, -3.0][shift],
        );
        for (i, (own_mass, own_length, nudge, rate, own_force)) in (1..=balls).zip(rows) {
            values += &format!(
                " ball.massRatio[{i}]={} pendulum.lengthRatio[{i}]={} x_start[{i}]={} v_start[{i}]={} F_ext[{i}]={}",
                if mass == 0 { 1.0 } else { own_mass }, if length == 0 { 1.0 } else { own_length },
                [0.0, -0.03, 1e-3][shift] + nudge, [0.0, 0.1, 0.0][mass] + rate,
                if force == 0 { 0.0 } else { own_force },
            );
        }
        (balls, values)
    }
}

proptest! {
    #[test]
    fn exchange_events_without_onsets_end((balls, values) in touching()) {
        onsets(balls, &values, 3e-4);
    }
}
