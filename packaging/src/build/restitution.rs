//! The losses of contacts from a coefficient of restitution.

use std::str::FromStr;

use newtons_cradle::model::DampingLaw;
use newtons_cradle::variables::{Number, Recipe, Settings, StartValue, Variable};

use crate::error::Error;

const LAW: &str = "contact.dampingLaw";

/// A coefficient of restitution for two free balls and, where it depends on that, the speed (m/s) at which they meet.
#[derive(Clone, Copy, Debug)]
pub struct Restitution {
    coefficient: f64,
    speed: Option<f64>,
}

impl FromStr for Restitution {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number =
            |text: &str| text.trim().parse().map_err(|_| "allowed: as 0.9 or 0.9@1.0, a speed in m/s".to_owned());
        let (coefficient, speed) = text.split_once('@').map_or((text, None), |(one, other)| (one, Some(other)));
        Ok(Self { coefficient: number(coefficient)?, speed: speed.map(number).transpose()? })
    }
}

impl std::fmt::Display for Restitution {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", Number(self.coefficient))?;
        self.speed.map_or(Ok(()), |speed| write!(f, "@{}", Number(speed)))
    }
}

impl Restitution {
    /// Gives a cradle the losses with which its first two balls have this restitution: by its damping law or, if its
    /// contacts lose nothing and no law `is_chosen` by the user, by the law of constant restitution. Returns in words
    /// what it has set.
    pub fn apply(self, recipe: &mut Recipe, is_chosen: bool) -> Result<String, Error> {
        let refused = |reason: &dyn std::fmt::Display| Error::Usage(format!("--restitution {self}: {reason}"));
        let mut settings = recipe.settings()?;
        let elastic = !settings.parameters.contacts_lose() && !is_chosen;
        let law = if elastic && settings.loss_depends_on_speed() {
            settings.parameters.damping_law = DampingLaw::ConstantRestitution;
            let law = Variable::named(LAW, recipe.balls).and_then(|law| law.text(&settings)).unwrap_or_default();
            let told = format!("{LAW} = {law}, ");
            recipe.start.insert(LAW.to_owned(), StartValue::Item(law));
            told
        } else {
            String::new()
        };
        let parameter = settings.lose(self.coefficient, self.speed, 0).map_err(|reason| refused(&reason))?;
        let value = parameter.value(&settings).unwrap_or_default();
        recipe.start.insert(parameter.to_string(), StartValue::Number(value));
        let speed = match self.speed.filter(|_| settings.loss_depends_on_speed()) {
            Some(speed) => format!("{} m/s", Number(speed)),
            None => "any speed".to_owned(),
        };
        let (value, coefficient) = (parameter.row.quantified(Number(value)), Number(self.coefficient));
        let pairs = if settings.contacts_lose_alike() { "two balls" } else { "of unlike pairs, balls 1 and 2" };
        Ok(format!(
            "Set {law}{parameter} = {value}: {pairs}, free and alone, that meet at {speed} part at {coefficient} of it"
        ))
    }

    /// The parameter of the damping law, and its value, with which two balls of these settings have this restitution.
    pub fn of_pair(self, mut settings: Settings) -> Result<(String, f64), Error> {
        let parameter = settings.lose(self.coefficient, self.speed, 0)?;
        Ok((parameter.to_string(), parameter.value(&settings).unwrap_or_default()))
    }
}
