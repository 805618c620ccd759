//! Tests each method against the methods that replace it.

use super::engine::Engine;
use crate::engine::{Unrecorded, cluster::Method};
use crate::model::{Chain, ContactModel, DampingLaw, Inputs, Parameters, PendulumModel, Results};

/// Scenes for each method: parameters, force that presses the outer balls together (N), and time to follow (s).
fn scenes() -> Vec<(Method, Parameters, f64, f64)> {
    let row = |n: usize| Parameters { dead_band: 0.0, ..Parameters::default_for(n) };
    let at_rest = |n: usize| Parameters { x_start: vec![0.0; n], ..row(n) };
    let hertz = Parameters { contact_model: ContactModel::Hertz, ..row(5) };
    let circular = |p| Parameters { pendulum: PendulumModel::Circular, ..p };
    let unequal = Parameters {
        mass_ratio: vec![1.0, 2.0, 1.0, 0.5, 1.0],
        length_ratio: vec![1.0, 1.1, 1.0, 0.9, 1.0],
        ..hertz.clone()
    };
    let lossy = |law| Parameters { damping_law: law, hunt_crossley: 0.1, relaxation_time: 1e-7, ..hertz.clone() };
    vec![
        (Method::PairImpact, Parameters::default_for(5), 0.0, 3.0),
        (Method::PairImpact, Parameters { exponent: 3.0, ..Parameters::default_for(5) }, 0.0, 3.0),
        (Method::PairImpact, circular(Parameters::default_for(5)), 0.0, 3.0),
        (Method::PairImpact, circular(Parameters { dead_band: 1e-4, ..hertz.clone() }), 0.0, 3.0),
        (Method::Series, row(5), 0.0, 1.2),
        (Method::Series, Parameters { damping: 300.0, ..row(5) }, 0.0, 1.2),
        (Method::Gauss, hertz.clone(), 0.0, 1.2),
        (Method::Gauss, unequal, 0.0, 1.2),
        (Method::Gauss, lossy(DampingLaw::HuntCrossley), 0.0, 1.2),
        (Method::Gauss, lossy(DampingLaw::Viscoelastic), 0.0, 1.2),
        (Method::Gauss, Parameters { exponent: 3.0, ..row(5) }, 0.0, 1.2),
        (Method::Gauss, Parameters { exponent: 2.3, ..at_rest(13) }, 20.0, 1e-3),
        (Method::Modes, Parameters { damping: 3e6, ..row(3) }, 0.0, 1.2),
        (Method::Radau, Parameters { damping: 3e3, exponent: 1.5, ..at_rest(3) }, 1.0, 0.05),
    ]
}

/// Without any one method the others give the same result. The methods share no equation of contact, so agreement shows
/// that each is right.
#[test]
fn methods_can_do_without_each_other() {
    for (own, p, force, end) in scenes() {
        let n = p.balls();
        let mut inputs = Inputs::zero(n);
        (inputs.force[0], inputs.force[n - 1]) = (force, -force);
        let run = |forbidden: Option<Method>| {
            let mut engine = Engine::new(&p, &inputs, 0.0).unwrap();
            engine.suspend();
            engine.control.forbidden = forbidden;
            engine.resume();
            engine.advance(end, &mut Unrecorded).unwrap();
            engine
        };
        let all = run(None);
        let energy = all.total_energy() + all.dissipated_energy() + all.external_work().abs();
        for method in [Method::PairImpact, Method::Series, Method::Gauss, Method::Modes, Method::Radau] {
            let without = run(Some(method));
            assert!(method != own || without.work().steps != all.work().steps, "{own:?} is not used");
            assert!(without.energy_residual().abs() <= 1e-12 * energy, "{own:?} without {method:?}");
            let speed = (2.0 * energy / p.mass).sqrt();
            for i in 0..n {
                let off = [(without.x(i) - all.x(i)) / 0.1, (without.v(i) - all.v(i)) / speed];
                let off = off[0].abs().max(off[1].abs());
                assert!(off <= 1e-10, "{own:?} without {method:?}: ball {} is off by {off:e}", i + 1);
            }
        }
    }
}
