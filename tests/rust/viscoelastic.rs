//! Impacts of two viscoelastic balls against what is known of them in closed form.

use nalgebra::{SMatrix, SVector};
use newtons_cradle::engine::{Chain, Results, Simulation};
use newtons_cradle::model::{ContactModel, Cradle, DampingLaw, Inputs, Parameters, SolverMethod};

use crate::runs::{assert_energy, run};

/// Reduced mass of two balls of 1 kg, kg.
const MU: f64 = 0.5;

/// Two free balls of 1 kg that meet with the relative velocity `v` (m/s).
fn pair(model: ContactModel, relaxation_time: f64, v: f64) -> Parameters {
    let mut p = Parameters { contact_model: model, relaxation_time, ..Parameters::default_for(2) };
    (p.gravity, p.damping_law) = (0.0, DampingLaw::Viscoelastic);
    (p.x_start, p.v_start) = (vec![0.0; 2], vec![v, 0.0]);
    p
}

/// The coefficient of restitution, and the energy error over `mu v^2`.
fn outcome(p: &Parameters) -> [f64; 2] {
    let v = p.v_start[0];
    let engine = run(p, 100.0 / v);
    assert_eq!((engine.pulses(0), engine.in_contact(0)), (1, false), "{p:?}");
    [(engine.v(1) - engine.v(0)) / v, engine.energy_residual() / (MU * v * v)]
}

/// The coefficient of restitution of an impact that loses no energy by rounding.
fn restitution(p: &Parameters) -> f64 {
    let [e, energy] = outcome(p);
    assert!(energy.abs() < 4e-15, "{p:?}: {energy:e}");
    e
}

/// `X / A` (1/s) of a Hertz contact that closes at `v` (m/s), with `X = 3/2 A (K / mu)^(2/5) v^(1/5)`.
fn strength(v: f64) -> f64 {
    let stiffness = Cradle::new(&pair(ContactModel::Hertz, 1e-6, v)).contacts[0].stiffness;
    1.5 * libm::pow(stiffness / MU, 0.4) * libm::pow(v, 0.2)
}

/// Fits `1 - e = C1 X - C2 X^2 + ...` (R. Ramirez, T. Poeschel, N. V. Brilliantov and T. Schwager, Phys. Rev. E 60
/// (1999) 4465; they round to 1.15344 and 0.79826). The higher powers are those of a contact that opens where it would
/// pull (T. Schwager and T. Poeschel, Phys. Rev. E 78 (2008) 051304).
#[test]
fn viscoelastic_slow_hertz_impacts_have_the_known_series() {
    const POWERS: [f64; 6] = [1.0, 2.0, 2.5, 3.0, 3.5, 4.0];
    let v = 0.3;
    let x = SVector::<f64, 6>::from_fn(|i, _| 2e-4 * (i + 1) as f64 * (i + 1) as f64);
    let lost = x.map(|x| 1.0 - restitution(&pair(ContactModel::Hertz, x / strength(v), v)));
    // In units of the largest X, so that the matrix is not singular.
    let powers = SMatrix::<f64, 6, 6>::from_fn(|i, k| libm::pow(x[i] / x[5], POWERS[k]));
    let fit = powers.lu().solve(&lost).unwrap();
    let (c1, c2) = (fit[0] / x[5], -fit[1] / (x[5] * x[5]));
    // The loss along the motion without damping: a beta function.
    let exact = 0.8 * libm::pow(1.25, 0.6) * libm::tgamma(0.6) * libm::tgamma(1.5) / libm::tgamma(2.1);
    assert!((c1 - exact).abs() < 1e-9 && (c1 - 1.15344).abs() < 1e-5, "{c1} {exact}");
    assert!((c2 - 0.6 * exact * exact).abs() < 1e-6 && (c2 - 0.79826).abs() < 1e-5, "{c2} {}", 0.6 * exact * exact);
}

/// The coefficient of restitution depends on `A (K^2 v / mu^2)^(1/5)` alone, from weak to strong damping.
#[test]
fn viscoelastic_restitution_depends_on_one_number() {
    for x in [1e-3, 0.1, 1.0, 10.0, 1e3] {
        let [slow, fast] = [1e-3, 1.0].map(|v| restitution(&pair(ContactModel::Hertz, x / strength(v), v)));
        assert!((slow - fast).abs() < 1e-14, "X = {x}: {slow} {fast}");
        assert!(slow > 0.0 && slow < 1.0);
    }
}

/// With the exponent 1 it is Kelvin and Voigt's law that never pulls, whose `e` is known (T. Schwager and T. Poeschel,
/// Granular Matter 9 (2007) 465).
#[test]
fn viscoelastic_linear_contacts_have_the_restitution_of_a_clipped_dashpot() {
    let stiffness = Parameters::default_for(2).stiffness;
    let omega0 = (stiffness / MU).sqrt();
    for ratio in [1e-4, 0.01, 0.1, 0.5, 0.7, 0.72, 0.99, 1.01, 3.0, 50.0] {
        let beta = ratio * omega0;
        let relaxation_time = 2.0 * MU * beta / stiffness;
        let exponent = if ratio < 1.0 {
            let omega = omega0 * (1.0 - ratio * ratio).sqrt();
            // The phase at which the force is 0 again.
            beta / omega * libm::atan2(2.0 * beta * omega, beta * beta - omega * omega)
        } else {
            let omega = omega0 * (ratio * ratio - 1.0).sqrt();
            beta / omega * libm::log((beta + omega) * (beta + omega) / (omega0 * omega0))
        };
        let e = restitution(&pair(ContactModel::PowerLaw, relaxation_time, 0.7));
        assert!((e - libm::exp(-exponent)).abs() < 1e-14, "{ratio}: {e} {}", libm::exp(-exponent));
    }
}

/// Damping so strong that it stops the balls before the spring matters: at the overlap `d` with `A F_el(d) = mu v`. The
/// spring then takes them apart as fast as the damping lets it, `d + p A d' = 0`, until they fly. Also where the
/// exponent is nearly 1, and the force of an onset matters from the smallest overlaps on.
#[test]
fn viscoelastic_strong_damping_leaves_a_creeping_rebound() {
    for exponent in [1.01, 1.15, 1.5, 2.0, 3.7] {
        for relaxation_time in [1.0, 10.0] {
            let (v, stiffness) = (0.6, 1e5);
            let mut p = pair(ContactModel::PowerLaw, relaxation_time, v);
            (p.exponent, p.stiffness, p.overlap_ref) = (exponent, stiffness, 1.0);
            let d = libm::pow(MU * v / (relaxation_time * stiffness), 1.0 / exponent);
            let ([e, energy], expected) = (outcome(&p), d / (exponent * relaxation_time * v));
            // Where the force is nearly constant, steps of collocation follow it, to the tolerance.
            assert!(energy.abs() < 1e-12, "p = {exponent}, A = {relaxation_time} s: {energy:e}");
            let off = e / expected - 1.0;
            assert!(off.abs() < 40.0 * expected, "p = {exponent}, A = {relaxation_time} s: {e} {expected}");
        }
    }
}

/// Contacts in which damping exceeds the spring by far, and whose force has hardly a sign while they open: none stops
/// the run.
#[test]
fn viscoelastic_overdamped_cradles_go_on() {
    let laws = [0.1, 1.0, 10.0, 100.0].map(|time| (DampingLaw::Viscoelastic, 1.5, time, 1e10)).into_iter();
    let others = [1e3, 1e10].map(|stiffness| (DampingLaw::HuntCrossley, 2.5, 1e7, stiffness));
    for (law, exponent, coefficient, stiffness) in laws.chain(others) {
        let mut p = Parameters { damping_law: law, exponent, stiffness, dead_band: 1e-6, ..Parameters::default_for(5) };
        (p.relaxation_time, p.hunt_crossley) = (coefficient, coefficient);
        p.x_start = vec![-0.01, 0.0, 0.0, 0.0, 0.0];
        assert_energy(&run(&p, 2.0), 1e-12, &format!("{p:?}"));
    }
}

/// A dashpot is strongest at the onset, before anything is compressed.
#[test]
fn dashpot_peaks_at_its_onset() {
    let mut p = Parameters { damping: 1e5, exponent: 1.5, dead_band: 1e-4, ..Parameters::default_for(5) };
    p.x_start = vec![-0.05, 0.0, 0.0, 0.0, 0.0];
    let peaks = [SolverMethod::EventDriven, SolverMethod::Adams].map(|method| {
        let mut run =
            Simulation::new(&Parameters { method, tolerance: 1e-12, ..p.clone() }, &Inputs::zero(5), 0.0).unwrap();
        run.advance(1.0, &mut Vec::new()).unwrap();
        run.force_peak(0)
    });
    assert!((peaks[0] / peaks[1] - 1.0).abs() < 1e-6, "{peaks:?}");
}
