//! fmi2GetDirectionalDerivative: exact derivatives, checked against differences of repeated steps with other inputs.

use cradle_host::{Host, fmi2OK};
use newtons_cradle::fmi2::*;

use crate::differences::{LAWS, by_differences, knowns, outputs};

const BALLS: usize = 5;

/// A step from a state: its start and length, and the inputs held over it.
struct Step {
    host: Host,
    state: Vec<u8>,
    from: f64,
    length: f64,
}

impl Step {
    /// The step with one input changed by `change`, while inputs change within it; the outputs after it.
    fn outputs(&self, input: &str, change: f64) -> Vec<f64> {
        assert_eq!(self.host.set_bytes(&self.state), fmi2OK);
        assert_eq!(self.host.set_derivative("F_ext[2]", 1, 0.02), fmi2OK);
        assert_eq!(self.host.set_derivative("a_support", 2, 0.3), fmi2OK);
        assert_eq!(self.host.set(input, self.host.get(input) + change), fmi2OK);
        assert_eq!(self.host.step(self.from, self.length), fmi2OK);
        self.host.values(&outputs(BALLS))
    }

    /// Checks the derivatives along `input` against central differences of sixth order with steps of `h`.
    fn check(&self, what: &str, input: &str, h: f64, tolerance: f64) {
        self.outputs(input, 0.0);
        let exact = self.host.along(&outputs(BALLS), &[self.host.variable(input)], &[1.0]);
        // The progress of a look ahead does not depend on the cradle.
        let foreseen = self.host.get("t_next_isOnset") == 1.0;
        let size: Vec<f64> = self.outputs(input, h);
        let (differences, _) = by_differences(h, false, |change| self.outputs(input, change));
        for (j, output) in outputs(BALLS).iter().enumerate() {
            let name = output.row.name;
            if name == "t_next" && !foreseen {
                assert_eq!(exact[j], 0.0);
                continue;
            }
            let difference = differences[j];
            // The scale of the kind of output: what the same kind changes by elsewhere.
            let scale = exact.iter().zip(outputs(BALLS)).filter(|(_, other)| other.row.name == name);
            let scale = scale.fold(0.0_f64, |scale, (value, _)| scale.max(value.abs()));
            // Means are differences of integrals, energies and forces of the support sums over all balls.
            let over = if name.contains("mean") { self.length.min(1.0) } else { 1.0 };
            // A slow impact makes a hundred thousand roundings of the force of one.
            let rounding = 2e-11 * size[j].abs().max(1e-1) / over / h;
            assert!(
                (exact[j] - difference).abs() <= tolerance * scale + rounding,
                "{what}: {output} by {input}: {} {difference}, scale {scale}",
                exact[j]
            );
        }
    }
}

/// A step from `from` seconds after the onset of the first impact of balls whose impacts are apart.
fn step(law: &str, from: f64, length: f64) -> Step {
    let host = Host::default();
    // Gaps that keep the order of the pulses under the changes of the inputs, and inputs that are not 0.
    host.give("x_start=-0.1,-0.0983,0,0.0011,0.0023 F_ext[1]=0.03 a_support=-0.01");
    host.give(law);
    host.start();
    let start = host.get("t_next") + from;
    assert_eq!(host.step(0.0, start), fmi2OK);
    Step { state: host.to_bytes(), host, from: start, length }
}

#[test]
fn derivatives_of_a_step_agree_with_differences() {
    for (law, values) in LAWS {
        // From the onset of the first impact, in s; length; smallest and largest number of onsets within.
        let steps = [
            ("in flight", -0.3, 0.2, 0..=0),
            ("from flight into a pulse", -0.05, 0.05 + 3e-6, 0..=1),
            ("one pulse", -0.01, 0.0103, 1..=1),
            ("within a pulse", 2e-6, 3e-6, 0..=0),
            ("several pulses", -0.05, 0.45, 3..=12),
        ];
        for (what, from, length, onsets) in steps {
            let step = step(values, from, length);
            let count = |host: &Host| host.pulses().iter().sum::<i32>();
            let before = count(&step.host);
            step.outputs("F_ext[1]", 0.0);
            assert!(onsets.contains(&(count(&step.host) - before)), "{law}, {what}: {}", count(&step.host) - before);
            for input in ["F_ext[1]", "F_ext[2]", "F_ext[4]", "a_support"] {
                // A change of 1 N over 50 ms shifts an onset by the length of a pulse or more.
                // Rigid balls have one pulse after the other, so that soon another one comes next.
                let long = what == "in flight" || what == "within a pulse" && !law.starts_with("rigid");
                let h = if long { 1e-4 } else { 5e-8 };
                step.check(&format!("{law}, {what}"), input, h, 1e-6);
            }
        }
    }
}

/// The waves through touching balls, in which all pulses overlap; and balls pressed together by dashpots.
#[test]
fn derivatives_of_a_step_with_overlapping_pulses_and_lasting_contacts() {
    // Where balls just touch, or two onsets coincide, there is no derivative: so a nanometre apart, and unequal.
    let wave = "ball.massRatio=1.01,1.02,1.03,1.04,1.05 contact.deadBand=1e-9";
    let pressed = "x_start=0 contact.gap=-1.1e-5,-1.2e-5,-1.3e-5,-1.4e-5 contact.damping=2e4 contact.deadBand=0";
    for (what, settings) in [("wave", wave), ("pressed", pressed)] {
        let host = Host::started_with(settings);
        let from = if what == "wave" { host.get("t_next") - 1e-3 } else { 0.01 };
        assert_eq!(host.step(0.0, from), fmi2OK);
        let step = Step { state: host.to_bytes(), host, from, length: 1.00005e-3 };
        for input in ["F_ext[1]", "F_ext[3]", "a_support"] {
            step.check(what, input, 1e-6, 1e-5);
        }
    }
}

/// Checks that the derivative of `unknown` along this `change` of `known` is refused, in a message that begins so.
#[track_caller]
fn refused(host: &Host, (unknown, known, change): (&str, &str, f64), words: &str) {
    let (unknown, known, mut value) = (host.vr(unknown), host.vr(known), 7.0);
    let status = unsafe { fmi2GetDirectionalDerivative(host.c, &unknown, 1, &known, 1, &change, &mut value) };
    host.refused(status, &format!("fmi2GetDirectionalDerivative: {words}"));
    assert_eq!(value, 7.0);
}

/// Derivatives are refused for a step in which rigid balls stay in contact; one that ends with an impact has those
/// after it.
#[test]
fn derivatives_of_a_step_with_rigid_balls_in_contact_are_refused() {
    let refused = |host: &Host, input: &str| {
        refused(host, ("v[3]", input, 1.0), "v[3] has no derivative here: rigid balls stay in contact in it")
    };
    let host = Host::started_with("contact.model=rigid contact.deadBand=0 F_ext[3]=0.1");
    assert!(host.get("F[3]") > 0.0);
    assert_eq!(host.step(0.0, 0.1), fmi2OK);
    refused(&host, "F_ext[1]");
    let host = Host::started_with("contact.model=rigid");
    let onset = host.get("t_next");
    assert_eq!(host.step(0.0, onset), fmi2OK);
    let after_impact = host.sensitivity("v[3]", "F_ext[2]");
    assert_eq!(host.step(onset, 0.1), fmi2OK);
    let later = host.sensitivity("v[3]", "F_ext[2]");
    assert!(after_impact != 0.0 && later.is_finite(), "{after_impact} {later}");
}

#[test]
fn derivatives_of_a_step_to_an_onset_are_those_from_the_right() {
    let host = Host::started();
    let onset = host.get("t_next");
    assert_eq!(host.step(0.0, onset), fmi2OK);
    assert_eq!(host.get("pulses[2]"), 1.0);
    // The contact is closed: its force follows the overlap.
    let overlap = host.sensitivity("x[2]", "F_ext[2]") - host.sensitivity("x[3]", "F_ext[2]");
    assert!((host.sensitivity("F[2]", "F_ext[2]") / (1e10 * overlap) - 1.0).abs() < 1e-12);
    // The next onset is another one.
    let next = host.sensitivity("t_next", "F_ext[2]");
    assert!(host.get("t_next") > onset && next.is_finite() && next != 0.0);
}

#[test]
fn derivatives_of_a_step_by_inputs_not_held_are_zero() {
    let host = Host::started();
    let along = host.along(&outputs(BALLS), &[host.variable("F_ext[3]")], &[1.0]);
    assert!(along.iter().all(|derivative| *derivative == 0.0), "{along:?}");
}

#[test]
fn derivatives_of_a_step_add_up_and_survive_saved_states() {
    let step = step(LAWS[0].1, -0.05, 0.1);
    let host = &step.host;
    let (now, from) = (host.time().unwrap(), host.get("t_next") - 1e-3);
    assert_eq!((host.step(now, from - now), host.step(from, 2e-3)), (fmi2OK, fmi2OK));
    let inputs = [host.variable("F_ext[1]"), host.variable("a_support")];
    let along = |host: &Host, direction: [f64; 2]| host.along(&outputs(BALLS), &inputs, &direction);
    let (both, one, other) = (along(host, [2.0, -3.0]), along(host, [1.0, 0.0]), along(host, [0.0, 1.0]));
    for (j, output) in outputs(BALLS).iter().enumerate() {
        let (a, b) = (2.0 * one[j], -3.0 * other[j]);
        assert!((both[j] - (a + b)).abs() <= 1e-9 * (a.abs() + b.abs()), "{output}: {} {}", both[j], a + b);
    }
    let restored = Host::default();
    assert_eq!(restored.set_bytes(&host.to_bytes()), fmi2OK);
    let bits = |values: Vec<f64>| values.into_iter().map(f64::to_bits).collect::<Vec<_>>();
    assert_eq!(bits(along(&restored, [2.0, -3.0])), bits(both));
}

/// In Initialization Mode the unknowns depend on the parameters and the inputs.
#[test]
fn derivatives_of_initial_unknowns_agree_with_differences() {
    let relaxing = "contact.dampingLaw=viscoelastic contact.relaxationTime=1e-5";
    let real_relaxing = &format!("{relaxing} contact.exponent=1.7");
    for (what, law, closing) in [
        ("apart", "", false),
        ("Hertz", "contact.model=hertz contact.dampingLaw=huntCrossley contact.huntCrossley=0.4", true),
        ("viscoelastic real power", real_relaxing, true),
        ("viscoelastic and linear", relaxing, true),
        ("real power with drag", "contact.exponent=1.7 contact.damping=1e3 pendulum.drag=0.2", true),
    ] {
        let host = Host::default();
        // There is room on both sides.
        host.give("contact.restitution=0.9");
        host.give(if closing { "v_start[4]=0.1 x_start[4]=2e-4 x_start[5]=0.01" } else { "" });
        host.give(law);
        assert_eq!((host.set_up(0.0), host.enter()), (fmi2OK, fmi2OK));
        let unknowns = [outputs(BALLS), vec![host.variable("pendulum.period")]].concat();
        for known in knowns(BALLS) {
            let (name, value) = (known.to_string(), host.values(&[known])[0]);
            let h = if value == 0.0 { 1e-7 } else { 3e-6 * value.abs() };
            let exact = host.along(&unknowns, &[known], &[1.0]);
            let one_sided = host.set(&name, value - h) != fmi2OK;
            host.log();
            let (differences, rounding) = by_differences(h, one_sided, |change| {
                host.give(&format!("{known}={}", value + change));
                host.values(&unknowns)
            });
            host.give(&format!("{known}={value}"));
            for (j, (unknown, size)) in unknowns.iter().zip(host.values(&unknowns)).enumerate() {
                let (difference, rounding) = (differences[j], 1e-13 * size.abs().max(1e-3) * rounding);
                assert!(
                    (exact[j] - difference).abs() <= 1e-4 * exact[j].abs() + rounding,
                    "{what}: {unknown} by {known}: {} {difference}",
                    exact[j]
                );
            }
        }
    }
}

#[test]
fn derivatives_of_a_step_that_do_not_exist_are_refused() {
    let host = Host::default();
    assert_eq!((host.set_up(0.0), host.enter()), (fmi2OK, fmi2OK));
    refused(&host, ("x[1]", "contact.model", 1.0), "contact.model");
    refused(&host, ("x[1]", "v[1]", 1.0), "a direction along v[1] has no such derivative");
    refused(&host, ("pulses[1]", "F_ext[1]", 1.0), "pulses[1] is of type Integer, not Real");
    assert_eq!(host.exit(), fmi2OK);
    refused(&host, ("x[1]", "x_start[1]", 1.0), "a direction along x_start[1] has no such derivative");
    let along_drag = "a direction along pendulum.drag has no such derivative; allowed: inputs";
    refused(&host, ("x[1]", "pendulum.drag", 1.0), along_drag);
    refused(&host, ("overlap[1]", "F_ext[1]", 1.0), "overlap[1] has no such derivative; allowed: real outputs");
    refused(&host, ("pendulum.period", "F_ext[1]", 1.0), "pendulum.period");
    refused(&host, ("x[1]", "F_ext[1]", f64::NAN), "dvKnown = NaN");
    host.refused(
        unsafe { fmi2GetDirectionalDerivative(host.c, &u32::MAX, 1, &0, 0, &0.0, &mut 0.0) },
        "value reference 4294967295",
    );
    host.assert_usable();
}
