//! What takes the place of [`algebraic`](super::algebraic) without the engine: the table of variables, which is all that
//! the producer needs, names what a run shows, but there are no runs.

pub trait Chain {
    fn state_of(&self, i: usize) -> (f64, f64);
    fn overlap_of(&self, i: usize) -> f64;
    fn force_of(&self, i: usize) -> f64;
}

pub(crate) fn of_one(_: &(impl Chain + ?Sized), _: usize) -> f64 {
    f64::NAN
}

pub(crate) fn of_all(_: &(impl Chain + ?Sized)) -> f64 {
    f64::NAN
}

pub(crate) use {of_all as dissipation, of_all as external_power, of_all as momentum, of_all as support_force};
pub(crate) use {of_all as total_energy, of_one as a, of_one as contact_energy, of_one as gravity_energy};
pub(crate) use {of_one as kinetic_energy, of_one as overlap_rate};
