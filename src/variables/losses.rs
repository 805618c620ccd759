//! Sets the parameter by which contacts lose energy from a coefficient of restitution.

use super::settings::Settings;
use super::table::row::Row;
use super::table::{LOSS_PARAMETERS, TABLE};
use super::text::{Refusal, ensure};
use super::variable::Variable;
use crate::model::{ContactModel, Cradle, DampingLaw};
use crate::number::Number;

impl Settings {
    /// The parameter by which contacts lose energy with these settings.
    fn loss_parameter(&self) -> Option<Variable> {
        let is_used = |row: &&'static Row| row.needs.iter().all(|need| (need.is_met)(&self.parameters, None));
        let named = |name: &&str| TABLE.iter().find(|row| row.name == *name).filter(is_used);
        let row = LOSS_PARAMETERS.iter().find_map(named)?;
        Variable::named(row.name, self.balls())
    }

    /// Whether the coefficient of restitution of two balls depends on their speed.
    pub fn loss_depends_on_speed(&self) -> bool {
        let p = &self.parameters;
        p.contact_model != ContactModel::Rigid && p.damping_law != DampingLaw::ConstantRestitution
    }

    /// Sets the parameter of the losses so that the balls of `contact` (from 0), free and alone, part with
    /// `restitution` times the `speed` (m/s) of their approach. Returns the parameter. A speed is needed only if the
    /// coefficient depends on it.
    pub fn lose(&mut self, restitution: f64, speed: Option<f64>, contact: usize) -> Result<Variable, Refusal> {
        let rigid = self.parameters.contact_model == ContactModel::Rigid;
        let (allowed, range) =
            if rigid { (0.0..=1.0, "0 to 1") } else { (f64::MIN_POSITIVE..=1.0, "above 0, at most 1") };
        ensure(allowed.contains(&restitution), || {
            Refusal::argument("the coefficient of restitution", Number(restitution), range)
        })?;
        let needs_speed = self.loss_depends_on_speed();
        let speed = match speed {
            Some(speed) if !(speed > 0.0 && speed.is_finite()) => {
                return Err(Refusal::number("the speed", speed, "m/s", "above 0"));
            }
            None if needs_speed => {
                return Err(Refusal::new(
                    "by this damping law the coefficient of restitution depends on the speed of approach (m/s): give that, \
                     too, or take contact.dampingLaw = constantRestitution",
                ));
            }
            speed => speed.unwrap_or(1.0),
        };
        let ratio = self.parameters.loss_ratio.get(contact).copied().ok_or_else(|| {
            Refusal::argument("the number of balls", self.balls(), "at least 2, of which two collide")
        })?;
        ensure(ratio > 0.0 || restitution == 1.0, || {
            let name = format!("contact.lossRatio[{}]", contact + 1);
            Refusal::argument(name, Number(ratio), "above 0 where its balls are to lose energy")
        })?;
        let parameter = self.loss_parameter().ok_or_else(|| Refusal::new("no parameter of the losses is used"))?;
        let value = if restitution == 1.0 {
            if needs_speed { 0.0 } else { 1.0 }
        } else if needs_speed {
            // The damping is proportional to its parameter.
            let mut unit = self.clone();
            parameter.set(&mut unit, 1.0);
            let cradle = Cradle::new(&unit.parameters);
            let law = &cradle.contacts[contact];
            law.damping_for(restitution, cradle.reduced_mass(contact), speed) / law.damping.coefficient
        } else {
            libm::pow(restitution, 1.0 / ratio)
        };
        parameter.check(value)?;
        parameter.set(self, value);
        Ok(parameter)
    }

    /// Whether all pairs of neighbours, each pair alone, part with the same coefficient of restitution.
    pub fn contacts_lose_alike(&self) -> bool {
        let cradle = Cradle::new(&self.parameters);
        let of = |j: usize| {
            let law = &cradle.contacts[j];
            let damping = law.damping.coefficient / law.unit_of_damping(cradle.reduced_mass(j), 1.0);
            [law.restitution, if law.is_elastic() { 0.0 } else { damping }]
        };
        let near = |[a, b]: [f64; 2]| a == b || (a / b - 1.0).abs() < 1e-12;
        (1..cradle.contacts.len()).all(|j| (0..2).all(|k| near([of(j)[k], of(0)[k]])))
    }
}
