//! The cradle as the equations see it: masses, oscillators and contact laws, derived from the parameters.

use super::contact::{ContactLaw, Damping};
use super::parameters::{ContactModel, DampingLaw, Parameters};

/// One ball on its pendulum: `x'' + 2 gamma x' + omega2 x = (forces) / mass`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallModel {
    /// Mass, kg.
    pub mass: f64,
    /// Square of the natural frequency g/L, 1/s2.
    pub omega2: f64,
    /// Decay rate b/(2 m) of the amplitude, 1/s.
    pub gamma: f64,
}

/// All balls and contacts.
#[derive(Clone, Debug, PartialEq)]
pub struct Cradle {
    /// From left to right.
    pub balls: Vec<BallModel>,
    /// Contact `i` lies between ball `i` and ball `i + 1`.
    pub contacts: Vec<ContactLaw>,
}

impl Cradle {
    /// Derives the coefficients of the equations from `p`, whose values are in their ranges.
    pub fn new(p: &Parameters) -> Self {
        let ball = |(mass_ratio, length_ratio): (&f64, &f64)| {
            let mass = p.mass * mass_ratio;
            BallModel { mass, omega2: p.gravity / (p.length * length_ratio), gamma: 0.5 * p.drag / mass }
        };
        let contact = |(ratio, gap): (&f64, &f64)| {
            let (stiffness, overlap_ref, exponent) = match p.contact_model {
                ContactModel::PowerLaw => (p.stiffness, p.overlap_ref, p.exponent),
                ContactModel::Hertz => (hertz_stiffness(p), 1.0, 1.5),
            };
            let clearance = gap + p.dead_band;
            ContactLaw { stiffness: stiffness * ratio, overlap_ref, exponent, clearance, damping: damping(p) }
        };
        Self {
            balls: p.mass_ratio.iter().zip(&p.length_ratio).map(ball).collect(),
            contacts: p.stiffness_ratio.iter().zip(&p.gap).map(contact).collect(),
        }
    }
}

/// `K = 4/3 E* sqrt(R*)` of two equal spheres, N/m^(3/2), with `E* = E / (2 (1 - nu^2))` and `R* = R / 2`
/// (Johnson, Contact Mechanics, 1985, section 4.2).
pub fn hertz_stiffness(p: &Parameters) -> f64 {
    let modulus = p.young_modulus / (2.0 * (1.0 - p.poisson_ratio * p.poisson_ratio));
    4.0 / 3.0 * modulus * (0.5 * p.radius).sqrt()
}

fn damping(p: &Parameters) -> Damping {
    match p.damping_law {
        DampingLaw::KelvinVoigt if p.damping > 0.0 => Damping::KelvinVoigt { c: p.damping, pull: true },
        DampingLaw::KelvinVoigtNoPull if p.damping > 0.0 => Damping::KelvinVoigt { c: p.damping, pull: false },
        DampingLaw::HuntCrossley if p.hunt_crossley > 0.0 => Damping::HuntCrossley { alpha: p.hunt_crossley },
        _ => Damping::None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hertz_stiffness_of_one_inch_steel_balls() {
        let mut p = Parameters::default_for(2);
        (p.young_modulus, p.poisson_ratio, p.radius) = (2.1e11, 0.3, 0.0127);
        assert!((hertz_stiffness(&p) - 12_259_521_115.776_325).abs() < 1e-4);
    }
}
