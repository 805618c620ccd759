//! Communication points have no effect.

use newtons_cradle::engine::{Chain, Engine, InvalidState, Pulse, Results, Simulation};
use newtons_cradle::model::Inputs;
use proptest::collection::vec;
use proptest::prelude::*;

use super::config;
use super::cradles::{ANY, ARCS, Case, cradles, ended_early, rigid};
use crate::methods::{METHODS, bits, default_by};

fn pulse_bits(pulses: &[Pulse]) -> Vec<(usize, [u64; 5])> {
    let numbers = |pulse: &Pulse| Pulse::VALUES.map(|(_, of)| of(pulse).to_bits());
    pulses.iter().map(|pulse| (pulse.contact, numbers(pulse))).collect()
}

/// What two runs of `case` leave at their common `times`, the second with `between` more communication points in each
/// stretch, at which everything is read, the inputs are set to what they are, and the run goes on from a snapshot.
/// Returns the pulses.
fn compare(case: &Case, times: &[f64], between: &[f64]) -> Result<Vec<Pulse>, TestCaseError> {
    let (mut coarse, n) = (Simulation::new(&case.p, &case.inputs, 0.0).map_err(ended_early)?, case.p.balls());
    let mut fine = coarse.clone();
    let (mut coarse_pulses, mut fine_pulses) = (Vec::new(), Vec::new());
    let mut last = 0.0;
    for &time in times {
        coarse.advance(time, &mut coarse_pulses).map_err(ended_early)?;
        for share in between {
            let point = last + share * (time - last);
            if point > fine.time() && point < time {
                fine.advance(point, &mut fine_pulses).map_err(ended_early)?;
                bits(&*fine, n);
                fine.next_onset();
                fine.hold(&case.inputs, &[]).map_err(ended_early)?;
                fine.retune(&case.p.tunables()).map_err(ended_early)?;
                let restored = Simulation::restore(case.p.clone(), 0.0, fine.snapshot(), false, |_| true);
                fine = restored.map_err(|InvalidState(reason)| TestCaseError::fail(reason))?;
            }
        }
        fine.advance(time, &mut fine_pulses).map_err(ended_early)?;
        prop_assert_eq!(bits(&*coarse, n), bits(&*fine, n), "at {}", time);
        // The progress of a look ahead depends on earlier looks, its result does not.
        if let (Some(coarse), Some(fine)) = (coarse.next_onset().found(), fine.next_onset().found()) {
            prop_assert_eq!(coarse.to_bits(), fine.to_bits(), "t_next at {}", time);
        }
        last = time;
    }
    prop_assert_eq!(pulse_bits(&coarse_pulses), pulse_bits(&fine_pulses));
    Ok(coarse_pulses)
}

/// The same for the methods that integrate the whole chain.
#[test]
fn observing_other_methods_changes_nothing() {
    let between: Vec<f64> = (1..100).map(|k| f64::from(k) / 100.0).collect();
    for (method, ..) in METHODS {
        let case = Case { p: default_by(method), inputs: Inputs::zero(5), time: 2.8 };
        assert!(compare(&case, &[0.7, 1.4, 2.1, 2.8], &between).unwrap().len() > 5, "{method:?}");
    }
}

/// Points at which two runs are compared, and points between which one of them steps; as shares of the time.
fn points() -> impl Strategy<Value = (Vec<f64>, Vec<f64>)> {
    (vec(0.0..1.0, 1..5), vec(0.0..1.0, 1..100))
}

/// Points within the first pulses, rising; as shares of the time, as `shares` of each pulse.
pub fn within(pulses: &[Pulse], shares: &[f64], time: f64) -> Vec<f64> {
    let of_pulse = |pulse: &Pulse| {
        let (onset, length) = (pulse.onset, pulse.release - pulse.onset);
        shares.iter().map(|share| (onset + share * length) / time).collect::<Vec<_>>()
    };
    let mut points: Vec<f64> = pulses.iter().take(20).flat_map(of_pulse).filter(|point| *point < 1.0).collect();
    points.sort_by(f64::total_cmp);
    points
}

/// At random points, at some within the first contacts, and in pieces that end whenever they have spent some effort.
fn looks_change_nothing(
    case: &Case,
    (mut common, mut between): (Vec<f64>, Vec<f64>),
    shares: &[f64],
    effort: u64,
) -> Result<(), TestCaseError> {
    common.iter_mut().for_each(|share| *share *= case.time);
    common.push(case.time);
    common.sort_by(f64::total_cmp);
    between.sort_by(f64::total_cmp);
    compare(case, &common, &between)?;

    let ((whole, pulses), n) = (case.run()?, case.p.balls());
    compare(case, &[case.time], &within(&pulses, shares, case.time))?;

    let (mut pieces, mut of_pieces) = (case.start()?, Vec::new());
    while pieces.time() < case.time {
        let before = pieces.time();
        pieces.advance_within(case.time, effort, &mut of_pieces).map_err(ended_early)?;
        prop_assert!(pieces.time() >= before);
    }
    prop_assert_eq!(bits(&whole, n), bits(&pieces, n));
    prop_assert_eq!(pulse_bits(&pulses), pulse_bits(&of_pieces));
    Ok(())
}

/// Values of a step in which inputs change, against those of two steps: they cover all of it, and what is set at its
/// end is no part of it.
fn cut_steps_add_up(case: &Case, share: f64) -> Result<(), TestCaseError> {
    let (n, times) = (case.p.balls(), [share * case.time, case.time]);
    let (mut whole, mut parts, mut none) = (case.start()?, case.start()?, Vec::new());
    let changed = |of: &Inputs, factor: f64| Inputs {
        force: of.force.iter().map(|force| factor * force).collect(),
        support_acceleration: factor * of.support_acceleration,
    };
    let of_step = |run: &Engine| {
        let means = (0..n - 1).map(|i| run.force_mean(i)).chain([run.support_force_mean()]);
        let impulses: Vec<f64> = means.map(|mean| mean * run.step_length()).collect();
        (impulses, (0..n - 1).map(|i| run.force_peak(i)).collect::<Vec<_>>())
    };
    let (mut sums, mut peaks) = (vec![0.0; n], vec![0.0_f64; n - 1]);
    whole.begin_step();
    for (time, factor) in times.into_iter().zip([-1.5, 0.5]) {
        whole.continue_step(time, &mut none).map_err(ended_early)?;
        parts.advance(time, &mut none).map_err(ended_early)?;
        let (impulses, highest) = of_step(&parts);
        sums.iter_mut().zip(impulses).for_each(|(sum, impulse)| *sum += impulse);
        peaks.iter_mut().zip(highest).for_each(|(peak, highest)| *peak = peak.max(highest));
        for run in [&mut whole, &mut parts] {
            run.hold(&changed(&case.inputs, factor), &[]).map_err(ended_early)?;
        }
        prop_assert_eq!(bits(&whole, n), bits(&parts, n));
        let (impulses, highest) = of_step(&whole);
        let rounding = 1e-11 * case.mass() * case.time.max(1.0);
        for (own, sum) in impulses.iter().zip(&sums) {
            prop_assert!((own - sum).abs() <= rounding.max(1e-12 * sum.abs()), "{own:e} {sum:e}");
        }
        for (own, peak) in highest.iter().zip(&peaks) {
            prop_assert!((own - peak).abs() <= 1e-12 * peak, "{own:e} {peak:e}");
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(150))]

    #[test]
    fn steps_cut_by_inputs_add_up(case in cradles(ANY), share in 0.01..0.99) {
        cut_steps_add_up(&case, share)?;
    }

    #[test]
    fn steps_cut_by_inputs_add_up_on_arcs(case in cradles(ARCS), share in 0.01..0.99) {
        cut_steps_add_up(&case, share)?;
    }

    #[test]
    fn steps_cut_by_inputs_add_up_for_rigid_balls(case in rigid(), share in 0.01..0.99) {
        cut_steps_add_up(&case, share)?;
    }

    #[test]
    fn observing_a_run_changes_nothing(
        case in cradles(ANY), points in points(), shares in vec(0.0..1.0, 5), effort in 1u64..3000,
    ) {
        looks_change_nothing(&case, points, &shares, effort)?;
    }

    #[test]
    fn observing_balls_on_arcs_changes_nothing(
        case in cradles(ARCS), points in points(), shares in vec(0.0..1.0, 5), effort in 1u64..3000,
    ) {
        looks_change_nothing(&case, points, &shares, effort)?;
    }

    #[test]
    fn observing_rigid_balls_changes_nothing(case in rigid(), points in points(), effort in 1u64..300) {
        looks_change_nothing(&case, points, &[], effort)?;
    }

    /// Means and peaks of the steps add up to the impulses and the peaks of the pulses, wherever those are cut.
    #[test]
    fn steps_add_up(case in cradles(ANY), mut points in vec(0.0..1.0, 1..50), shares in vec(0.0..1.0, 5)) {
        let n = case.p.balls();
        let (mut engine, mut pulses) = (case.start()?, Vec::new());
        points.extend(within(&case.run()?.1, &shares, case.time));
        points.push(1.0);
        points.sort_by(f64::total_cmp);
        let (mut sums, mut peaks) = (vec![0.0; n - 1], vec![0.0f64; n - 1]);
        for share in points {
            let before = engine.time();
            engine.advance(share * case.time, &mut pulses).map_err(ended_early)?;
            for i in 0..n - 1 {
                sums[i] += engine.force_mean(i) * (engine.time() - before);
                peaks[i] = peaks[i].max(engine.force_peak(i));
            }
        }
        for i in 0..n - 1 {
            let total = engine.impulse(i);
            prop_assert!((sums[i] - total).abs() <= 1e-12 * total.abs().max(peaks[i] * 1e-9), "{} {total}", sums[i]);
            let of_pulses = pulses.iter().filter(|pulse| pulse.contact == i);
            let highest = of_pulses.clone().map(|pulse| pulse.peak.force).fold(0.0, f64::max);
            let finished: f64 = of_pulses.map(|pulse| pulse.impulse).sum();
            if !engine.in_contact(i) {
                prop_assert!((peaks[i] - highest).abs() <= 1e-12 * highest, "{} {highest}", peaks[i]);
                prop_assert!((finished - total).abs() <= 1e-12 * total.abs(), "{finished} {total}");
            }
        }
    }
}
