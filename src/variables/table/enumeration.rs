//! Parameters with named items: their integers never change.

use crate::model::{ContactModel, DampingLaw, ExchangedContacts, Parameters, SolverMethod};

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

/// An enumeration and where its value is.
pub struct Enumeration {
    /// Name of the type definition.
    pub type_name: &'static str,
    /// Its items.
    pub items: &'static [Item],
    /// The integer of the current item.
    pub get: fn(&Parameters) -> i32,
    /// Selects the item with this integer; one that is not in `items` changes nothing.
    pub set: fn(&mut Parameters, i32),
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

/// What may be chosen, for messages: `powerLaw (1) or hertz (2) or rigid (3)`.
impl std::fmt::Display for Enumeration {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let items: Vec<String> = self.items.iter().map(|item| format!("{} ({})", item.name, item.value)).collect();
        f.write_str(&items.join(" or "))
    }
}

const fn item(value: i32, name: &'static str, description: &'static str) -> Item {
    Item { name, value, description }
}

/// Puts the item with this integer, counted from 1, in its place.
fn select<T: Copy, const N: usize>(place: &mut T, value: i32, items: [T; N]) {
    if let Some(item) = (1..).zip(items).find_map(|(number, item)| (number == value).then_some(item)) {
        *place = item;
    }
}

/// `contact.model`.
pub static CONTACT_MODEL: Enumeration = Enumeration {
    type_name: "ContactModel",
    items: &[
        item(1, "powerLaw", "F = k r (d/d_ref)^(p-1) d for an overlap d and a stiffness ratio r"),
        item(2, "hertz", "F = K r d^(3/2), with K from the elastic constants of two equal spheres (Hertz 1882)"),
        item(3, "rigid", "no force law: instantaneous impacts of two balls with a coefficient of restitution"),
    ],
    get: |parameters| parameters.contact_model as i32,
    set: |parameters, value| {
        select(
            &mut parameters.contact_model,
            value,
            [ContactModel::PowerLaw, ContactModel::Hertz, ContactModel::Rigid],
        );
    },
};

/// `contact.dampingLaw`.
pub static DAMPING_LAW: Enumeration = Enumeration {
    type_name: "DampingLaw",
    items: &[
        item(1, "kelvinVoigt", "adds c times the overlap rate; may pull just before the balls part"),
        item(2, "kelvinVoigtNoPull", "as kelvinVoigt, with the total force clipped at 0"),
        item(3, "huntCrossley", "multiplies the elastic force by 1 + alpha times the overlap rate, clipped at 0"),
        item(4, "viscoelastic", "adds A times the rate of the elastic force, clipped at 0"),
    ],
    get: |parameters| parameters.damping_law as i32,
    set: |parameters, value| {
        use DampingLaw::{HuntCrossley, KelvinVoigt, KelvinVoigtNoPull, Viscoelastic};
        select(&mut parameters.damping_law, value, [KelvinVoigt, KelvinVoigtNoPull, HuntCrossley, Viscoelastic]);
    },
};

/// `solver.method`.
pub static SOLVER_METHOD: Enumeration = Enumeration {
    type_name: "SolverMethod",
    items: &[
        item(1, "eventDriven", "exact flight between contacts, adaptive integration of the balls in contact"),
        item(2, "bdf", "backward differentiation formulas of variable order and step for the whole chain"),
        item(3, "adams", "Adams-Moulton formulas of variable order and step for the whole chain"),
        item(4, "rk4", "classical Runge-Kutta method with fixed steps for the whole chain"),
    ],
    get: |parameters| parameters.method as i32,
    set: |parameters, value| {
        use SolverMethod::{Adams, Bdf, EventDriven, Rk4};
        select(&mut parameters.method, value, [EventDriven, Bdf, Adams, Rk4]);
    },
};

/// `exchange.contacts`.
pub static EXCHANGED_CONTACTS: Enumeration = Enumeration {
    type_name: "ExchangedContacts",
    items: &[
        item(1, "resolved", "the host integrates the forces of every contact"),
        item(2, "mapped", "an event follows the contacts to their end; the host integrates the flight between them"),
    ],
    get: |parameters| parameters.exchanged as i32,
    set: |parameters, value| {
        use ExchangedContacts::{Mapped, Resolved};
        select(&mut parameters.exchanged, value, [Resolved, Mapped]);
    },
};

/// Every enumeration.
pub static ENUMERATIONS: &[&Enumeration] = &[&CONTACT_MODEL, &DAMPING_LAW, &SOLVER_METHOD, &EXCHANGED_CONTACTS];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_item_can_be_selected_and_read_back() {
        for enumeration in ENUMERATIONS {
            let mut parameters = Parameters::default_for(5);
            for item in enumeration.items {
                (enumeration.set)(&mut parameters, item.value);
                assert_eq!((enumeration.get)(&parameters), item.value, "{}", item.name);
                assert_eq!(enumeration.named(item.name).unwrap().value, item.value);
            }
            assert!(enumeration.item(0).is_none() && enumeration.item(99).is_none());
        }
    }
}
