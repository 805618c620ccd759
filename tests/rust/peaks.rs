//! When the force of a pulse is largest.

use std::f64::consts::PI;

use newtons_cradle::engine::{Chain, Engine, Pulse, Simulation};
use newtons_cradle::model::{ContactModel, DampingLaw, Inputs, Parameters, SolverMethod};

use crate::runs::{cradle, started, struck_chain, touching};

/// The pulses until `time` (s).
fn pulses_of(p: &Parameters, time: f64) -> Vec<Pulse> {
    let mut pulses = Vec::new();
    started(p).advance(time, &mut pulses).unwrap();
    assert!(!pulses.is_empty());
    pulses
}

/// Asserts that a pulse has its peak at this part of it.
#[track_caller]
fn assert_peak(pulse: &Pulse, part: f64, allowed: f64, what: &str) {
    let (length, clock) = (pulse.release - pulse.onset, pulse.release.next_up() - pulse.release);
    let off = (pulse.peak.time - pulse.onset) - part * length;
    assert!(off.abs() <= allowed * length + 2.0 * clock, "{what}: off by {:e} of {pulse:?}", off / length);
}

/// Whatever the exponent, and with what gravity and inputs do meanwhile.
#[test]
fn peak_of_an_elastic_impact_of_two_is_half_way() {
    for exponent in [1.0, 1.5, 2.0, 3.0, 7.3] {
        for gravity in [0.0, 9.81] {
            for (stiffness, force) in [(1e3, 0.0), (1e9, 0.0), (1e4, 2.0)] {
                let text = format!("contact.exponent={exponent} contact.stiffness={stiffness} gravity={gravity}");
                let p = touching(2, &format!("{text} ball.massRatio=1,3 v_start=1,-0.5"));
                let mut pulses = Vec::new();
                let inputs = Inputs { force: vec![force, 0.0], ..Inputs::zero(2) };
                Engine::new(&p, &inputs, 0.0).unwrap().advance(0.3, &mut pulses).unwrap();
                assert_peak(&pulses[0], 0.5, 1e-12, &text);
            }
        }
    }
}

/// Two balls that hit a third one between them at once, which stays where it is: they are followed in steps.
fn into_a_wall(text: &str) -> Parameters {
    let start = "gravity=0 contact.deadBand=0 x_start=-0.01,-1e-7,0,1e-7,0.01 v_start=0,1,0,-1,0";
    cradle(5, &format!("{start} {text}"))
}

#[test]
fn peak_of_an_elastic_impact_of_three_is_half_way() {
    for exponent in [1.0, 1.3, 1.5, 2.0, 2.5, 3.0, 7.3] {
        for stiffness in [1e5, 1e10] {
            let text = format!("contact.exponent={exponent} contact.stiffness={stiffness}");
            let pulses = pulses_of(&into_a_wall(&text), 0.02);
            let struck: Vec<_> = pulses.iter().filter(|pulse| [1, 2].contains(&pulse.contact)).take(2).collect();
            assert_peak(struck[0], 0.5, 1e-12, &text);
            let [off, higher] =
                [struck[1].peak.time - struck[0].peak.time, struck[1].peak.force / struck[0].peak.force];
            assert!(off.abs() < 1e-18 && (higher - 1.0).abs() < 1e-15, "{text}: {struck:?}");
        }
    }
}

/// A linear spring and a dashpot slow a ball of 1 kg down by `a = Re exp(i phase + (-gamma + i omega) t)`, up to a
/// factor; the force is largest where `a'`, of the same form, is 0.
#[test]
fn peak_of_a_damped_linear_contact_is_that_of_its_oscillation() {
    for (damping, no_pull) in [(1.0, false), (20.0, false), (20.0, true), (150.0, false)] {
        let (gamma, k) = (0.5 * damping, 1e4_f64);
        let omega = (k - gamma * gamma).sqrt();
        let law = if no_pull { DampingLaw::KelvinVoigtNoPull } else { DampingLaw::KelvinVoigt };
        let text = format!("ball.mass=1 contact.model=powerLaw contact.exponent=1 contact.stiffness={k}");
        let p = Parameters { damping, damping_law: law, ..into_a_wall(&text) };
        let pulses = pulses_of(&p, 0.05);
        let pulse = pulses.iter().find(|pulse| pulse.contact == 1).unwrap();
        // The overlap is a sine; each derivative turns it by this angle.
        let turn = omega.atan2(-gamma);
        // With strong damping the force falls from the start.
        let top = ((2.0 * PI - 3.0 * turn) / omega).max(0.0);
        let off = pulse.peak.time - pulse.onset - top;
        assert!(off.abs() < 1e-12 * PI / omega, "{damping}: {off:e} of {pulse:?}");
    }
}

/// The rate of the force is 0 at the peak, for all laws, in rows of unlike balls whose pulses have several humps; no
/// force at other times is larger.
#[test]
fn peak_is_where_the_force_has_no_rate() {
    let (mut humps, mut seen) = (0, 0);
    for exponent in [1.0, 1.5, 2.5] {
        for (law, by) in [
            (DampingLaw::KelvinVoigt, 0.0),
            (DampingLaw::HuntCrossley, 0.05),
            (DampingLaw::Viscoelastic, 0.02),
            (DampingLaw::KelvinVoigtNoPull, 0.02),
            (DampingLaw::ConstantRestitution, 0.0),
        ] {
            let mut p = Parameters { damping_law: law, damping: by, ..struck_chain(4, 1, exponent) };
            (p.hunt_crossley, p.relaxation_time, p.restitution) = (by, by, 0.9);
            p.mass_ratio = vec![1.0, 0.1, 1.0, 0.4];
            for pulse in pulses_of(&p, 30.0) {
                let mut run = started(&p);
                let (length, j) = (pulse.release - pulse.onset, pulse.contact);
                if pulse.peak.time > pulse.onset {
                    run.advance(pulse.peak.time, &mut Vec::new()).unwrap();
                    let rate = run.time_derivative(1).force[j] * length / pulse.peak.force;
                    assert!(rate.abs() < 1e-9, "{exponent} {law:?}: {rate:e} {pulse:?}");
                    seen += 1;
                }
                let (mut run, mut forces) = (started(&p), Vec::new());
                for k in 1..200 {
                    run.advance(pulse.onset + f64::from(k) / 200.0 * length, &mut Vec::new()).unwrap();
                    forces.push(run.force(j));
                }
                assert!(forces.iter().all(|force| *force <= pulse.peak.force * (1.0 + 1e-14)));
                let tops = forces.windows(3).filter(|three| three[1] > three[0] && three[1] >= three[2]).count();
                humps += usize::from(tops > 1);
            }
        }
    }
    assert!(humps > 10 && seen > 30, "{humps} {seen}");
}

/// What changes after the peak of a pulse does not move it: an impact whose outcome was known is then followed in
/// steps.
#[test]
fn peak_of_a_pulse_stays_if_inputs_change_later() {
    let arcs = "pendulum.model=circular contact.deadBand=0 x_start=-0.6,0.4 v_start=0.3,0.1 ball.massRatio=1,2";
    for (text, allowed) in [
        ("contact.deadBand=0 v_start=1,-0.2", 1e-12),
        ("contact.model=hertz contact.deadBand=0 v_start=1,-0.2", 1e-12),
        (&format!("{arcs} contact.model=hertz"), 1e-11),
        (&format!("{arcs} contact.model=hertz contact.gap=0.4"), 1e-11),
        (&format!("{arcs} contact.exponent=1 contact.stiffness=1e6"), 1e-10),
    ] {
        let p = cradle(2, text);
        let mut whole = Vec::new();
        let mut run = started(&p);
        while whole.is_empty() {
            run.advance(run.time() + 0.1, &mut whole).unwrap();
        }
        let (pulse, mut cut) = (whole[0], Vec::new());
        let (mut run, length) = (started(&p), pulse.release - pulse.onset);
        run.advance(pulse.onset + 0.8 * length, &mut cut).unwrap();
        run.hold(&Inputs { force: vec![0.1, 0.0], ..Inputs::zero(2) }, &[]).unwrap();
        run.advance(pulse.release + length, &mut cut).unwrap();
        let off = (cut[0].peak.time - pulse.peak.time) / length;
        assert!(off.abs() < allowed + 1e-16 * pulse.peak.time / length, "{text}: {off:e} {pulse:?} {:?}", cut[0]);
        assert!((cut[0].peak.force / pulse.peak.force - 1.0).abs() < 1e-12, "{text}");
        assert!(cut[0].impulse != pulse.impulse, "{text}");
    }
}

/// The general-purpose solvers find the same to what they are as exact.
#[test]
fn peak_is_the_same_by_all_methods() {
    let p = Parameters { contact_model: ContactModel::Hertz, tolerance: 1e-10, ..touching(4, "v_start[1]=1") };
    let own = pulses_of(&p, 1e-3);
    for (method, allowed) in [(SolverMethod::Adams, 1e-4), (SolverMethod::Bdf, 1e-3)] {
        let mut pulses = Vec::new();
        let p = Parameters { method, ..p.clone() };
        Simulation::new(&p, &Inputs::zero(4), 0.0).unwrap().advance(1e-3, &mut pulses).unwrap();
        for (pulse, other) in pulses.iter().zip(&own) {
            let off = (pulse.peak.time - other.peak.time) / (other.release - other.onset);
            assert!(off.abs() < allowed, "{method:?}: {off:e}");
        }
    }
}

/// A bead that strikes a row of Hertz contacts sends a solitary wave. Nesterenko's speed for long waves, `sqrt(4/5)
/// F^(1/6)` contacts per unit of time for unit masses and stiffness (J. Appl. Mech. Tech. Phys. 24, 733, 1983), is a
/// little too low for one that is five beads long; once it has formed, the wave keeps its own to the last digits.
#[test]
fn peak_times_give_the_speed_of_a_solitary_wave() {
    let pulses = pulses_of(&struck_chain(80, 1, 1.5), 70.0);
    let peak = |contact: usize| pulses.iter().find(|pulse| pulse.contact == contact).unwrap().peak;
    let speed = |from: usize, to: usize| {
        let [first, last] = [from, to].map(peak);
        (to - from) as f64 / (last.time - first.time) / last.force.powf(1.0 / 6.0)
    };
    assert!((speed(30, 50) / 0.8_f64.sqrt() - 1.0).abs() < 0.013, "{}", speed(30, 50));
    assert!((speed(40, 45) / speed(45, 50) - 1.0).abs() < 1e-10, "{:e}", speed(40, 45) / speed(45, 50) - 1.0);
}

/// A pressed contact whose force stays the same has its peak where that began.
#[test]
fn peak_of_a_constant_force_is_at_its_start() {
    let p = touching(2, "gravity=0 contact.model=rigid");
    let (mut engine, mut pulses) = (started(&p), Vec::new());
    let press = |force: f64| Inputs { force: vec![force, -force], ..Inputs::zero(2) };
    for (time, force) in [(1.0, 2.0), (2.0, 3.0), (4.0, 1.0), (5.0, 3.0), (6.0, -1.0), (7.0, 0.0)] {
        engine.hold(&press(force), &[]).unwrap();
        engine.advance(time, &mut pulses).unwrap();
    }
    let [Pulse { onset, release, peak, .. }] = pulses[..] else { panic!("{pulses:?}") };
    assert!(onset == 0.0 && release == 5.0 && peak.force == 3.0 && peak.time == 1.0, "{pulses:?}");
}
