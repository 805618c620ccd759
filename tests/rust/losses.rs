//! The parameters of damping laws from a coefficient of restitution, against impacts that the engine follows.

use newtons_cradle::engine::{Chain, Results};
use newtons_cradle::model::{ContactModel, DampingLaw, Parameters};
use newtons_cradle::variables::Settings;

use crate::runs::run;

const LAWS: [DampingLaw; 5] = [
    DampingLaw::KelvinVoigt,
    DampingLaw::KelvinVoigtNoPull,
    DampingLaw::HuntCrossley,
    DampingLaw::Viscoelastic,
    DampingLaw::ConstantRestitution,
];

/// Two free balls about to meet with the relative velocity `v` (m/s), of a stiffness for which contacts last a while.
fn pair(law: DampingLaw, exponent: f64, v: f64) -> Settings {
    let mut settings = Settings::default_for(2);
    let p = &mut settings.parameters;
    (p.gravity, p.dead_band, p.damping_law) = (0.0, 0.0, law);
    (p.exponent, p.stiffness, p.overlap_ref) = (exponent, 3e4, 1e-4);
    (p.mass, p.mass_ratio, p.loss_ratio) = (0.7, vec![1.0, 3.0], vec![1.7]);
    (p.x_start, p.v_start) = (vec![-1e-3 * v, 0.0], vec![v, 0.0]);
    settings
}

/// What they part with, over v.
fn outcome(p: &Parameters) -> f64 {
    let v = p.v_start[0];
    let engine = run(p, 1e3);
    assert_eq!((engine.pulses(0), engine.in_contact(0)), (1, false), "{p:?}");
    (engine.v(1) - engine.v(0)) / v
}

#[test]
fn losses_from_a_restitution_give_that_restitution() {
    for law in LAWS {
        for exponent in [1.0, 1.5, 2.0, 3.0, 7.3] {
            for (e, v) in
                [(1.0, 1.0), (0.999, 1e-3), (0.9, 1.0), (0.5, 0.1), (0.05, 5.0), (0.02, 1e-2), (1.0 - 1e-9, 1.0)]
            {
                let mut settings = pair(law, exponent, v);
                let parameter = settings.lose(e, Some(v), 0).unwrap();
                let found = outcome(&settings.parameters);
                assert!((found - e).abs() < 1e-10, "{law:?} {exponent} {v}: {parameter}: {found} instead of {e}");
            }
        }
    }
}

/// By the law of constant restitution at any speed, exponent and ratio of masses, as rigid balls beside them.
#[test]
fn losses_of_constant_restitution_are_exact() {
    for exponent in [1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 7.3] {
        for e in [0.02, libm::exp(-2.0), 0.5, 0.9, 0.999] {
            for (v, mass) in [(1e-6, 1e-3), (1e-3, 1.0), (1.0, 0.3), (1.0, 1e3), (10.0, 1.0)] {
                let mut p = pair(DampingLaw::ConstantRestitution, exponent, v).parameters;
                (p.restitution, p.mass_ratio[1], p.loss_ratio[0]) = (e.sqrt(), mass, 2.0);
                let rigid = Parameters { contact_model: ContactModel::Rigid, ..p.clone() };
                for p in [p, rigid] {
                    let found = outcome(&p);
                    assert!((found - e).abs() < 1e-14, "{:?} {exponent} {v} {mass}: {found}, {e}", p.contact_model);
                }
            }
        }
    }
}

/// Hertz contacts of unlike balls, and rigid ones.
#[test]
fn losses_by_contact_follow_their_ratios() {
    let mut settings = pair(DampingLaw::HuntCrossley, 1.0, 0.3);
    settings.parameters.contact_model = ContactModel::Hertz;
    settings.parameters.radius_ratio[1] = 1.4;
    assert_eq!(settings.lose(0.8, Some(0.3), 0).unwrap().to_string(), "contact.huntCrossley");
    assert!((outcome(&settings.parameters) - 0.8).abs() < 1e-10);
    settings.parameters.contact_model = ContactModel::Rigid;
    assert_eq!(settings.lose(0.8, None, 0).unwrap().to_string(), "contact.restitution");
    assert!((outcome(&settings.parameters) - 0.8).abs() < 1e-15);
}

#[test]
fn losses_that_cannot_be_are_refused() {
    let refused = |law, e, speed, ratio| {
        let mut settings = pair(law, 1.5, 1.0);
        settings.parameters.loss_ratio[0] = ratio;
        settings.lose(e, speed, 0).map(|parameter| parameter.to_string()).unwrap_err().to_string()
    };
    let viscoelastic = DampingLaw::Viscoelastic;
    for (e, speed, ratio, text) in [
        (0.0, Some(1.0), 1.0, "the coefficient of restitution = 0 is refused; allowed: above 0, at most 1"),
        (1.1, Some(1.0), 1.0, "the coefficient of restitution = 1.1 is refused"),
        (f64::NAN, Some(1.0), 1.0, "the coefficient of restitution = NaN is refused"),
        (0.5, Some(0.0), 1.0, "the speed = 0 m/s is refused; allowed: above 0"),
        (0.5, None, 1.0, "depends on the speed of approach (m/s)"),
        (0.5, Some(1.0), 0.0, "contact.lossRatio[1] = 0 is refused"),
    ] {
        let said = refused(viscoelastic, e, speed, ratio);
        assert!(said.contains(text), "{said}");
    }
    let mut alone = Settings::default_for(1);
    alone.parameters.contact_model = ContactModel::Rigid;
    assert!(alone.lose(0.5, None, 0).err().unwrap().to_string().contains("the number of balls = 1 is refused"));
}
