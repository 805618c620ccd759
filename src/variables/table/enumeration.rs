//! Parameters with named items: their integers never change.

use crate::model::{ContactModel, DampingLaw, ExchangedContacts, PendulumModel, SolverMethod};
use crate::variables::settings::{DerivativesOf, Settings};

/// One item of an enumeration.
#[derive(Debug)]
pub struct Item {
    /// Name as in the description.
    pub name: &'static str,
    /// The integer hosts use; fixed for ever.
    pub value: i32,
    /// Text.
    pub description: &'static str,
}

/// An enumeration and access to its value.
pub struct Enumeration {
    /// Name of the type definition.
    pub type_name: &'static str,
    /// Its items.
    pub items: &'static [Item],
    /// The integer of the current item.
    pub get: fn(&Settings) -> i32,
    /// Selects the item with this integer; one that is not in `items` changes nothing.
    pub set: fn(&mut Settings, i32),
}

impl Enumeration {
    /// The item with this integer.
    pub fn item(&self, value: i32) -> Option<&'static Item> {
        self.items.iter().find(|item| item.value == value)
    }

    /// The item of this name.
    pub fn named(&self, name: &str) -> Option<&'static Item> {
        self.items.iter().find(|item| item.name == name)
    }
}

/// The choices, for messages: `powerLaw (1) or hertz (2) or rigid (3)`.
impl std::fmt::Display for Enumeration {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let items: Vec<String> = self.items.iter().map(|item| format!("{} ({})", item.name, item.value)).collect();
        f.write_str(&items.join(" or "))
    }
}

/// An enumeration in this field of the settings, with items numbered from 1.
macro_rules! of {
    ($name:literal $type:ident $($field:ident).+: $($item:ident $text:literal $description:literal,)*) => {
        Enumeration {
            type_name: $name,
            items: &[$(Item { name: $text, value: $type::$item as i32, description: $description }),*],
            get: |settings| settings.$($field).+ as i32,
            set: |settings, value| {
                let items = [$($type::$item),*];
                if let Some(item) = items.into_iter().find(|item| *item as i32 == value) {
                    settings.$($field).+ = item;
                }
            },
        }
    };
}

/// `contact.model`.
pub static CONTACT_MODEL: Enumeration = of! {
    "ContactModel" ContactModel parameters.contact_model:
    PowerLaw "powerLaw" "F = k r (d/d_ref)^(p-1) d for an overlap d and a stiffness ratio r",
    Hertz "hertz" "F = K r d^(3/2), with K from the elastic constants of two equal spheres (Hertz 1882)",
    Rigid "rigid" "no force law: instantaneous impacts of two balls with a coefficient of restitution",
};

/// `contact.dampingLaw`.
pub static DAMPING_LAW: Enumeration = of! {
    "DampingLaw" DampingLaw parameters.damping_law:
    KelvinVoigt "kelvinVoigt" "adds c times the overlap rate; may pull just before the balls part",
    KelvinVoigtNoPull "kelvinVoigtNoPull" "as kelvinVoigt, with the total force clipped at 0",
    HuntCrossley "huntCrossley" "multiplies the elastic force by 1 + alpha times the overlap rate, clipped at 0",
    Viscoelastic "viscoelastic" "adds A times the rate of the elastic force, clipped at 0",
};

/// `pendulum.model`.
pub static PENDULUM_MODEL: Enumeration = of! {
    "PendulumModel" PendulumModel parameters.pendulum:
    Linear "linear" "on a line; the period does not depend on the amplitude",
    Circular "circular" "on arcs about the pivots, up to 90 degrees",
};

/// `solver.method`.
pub static SOLVER_METHOD: Enumeration = of! {
    "SolverMethod" SolverMethod parameters.method:
    EventDriven "eventDriven" "exact flight between contacts, adaptive integration of the balls in contact",
    Bdf "bdf" "backward differentiation formulas of variable order and step for the whole chain",
    Adams "adams" "Adams-Moulton formulas of variable order and step for the whole chain",
    Rk4 "rk4" "classical Runge-Kutta method with fixed steps for the whole chain",
};

/// `exchange.contacts`.
pub static EXCHANGED_CONTACTS: Enumeration = of! {
    "ExchangedContacts" ExchangedContacts parameters.exchanged:
    Resolved "resolved" "the host integrates the forces of every contact",
    Mapped "mapped" "an event follows the contacts to their end; the host integrates the flight between them",
};

/// `derivatives.of`, of FMI 3.0 only.
pub static DERIVATIVES_OF: Enumeration = of! {
    "DerivativesOf" DerivativesOf derivatives_of:
    Point "point" "outputs by inputs at the same time, as the standard defines it",
    LastStep "lastStep" "outputs at the end of the last step, by the inputs held over it",
    Run "run" "outputs at the end of the last step, by real parameters and by inputs over the whole run",
};

/// Every enumeration of FMI 2.0.
pub static ENUMERATIONS: &[&Enumeration] =
    &[&CONTACT_MODEL, &DAMPING_LAW, &SOLVER_METHOD, &EXCHANGED_CONTACTS, &PENDULUM_MODEL];
