//! The state of the whole chain at one time.

use crate::engine::cluster::{OverlapSeries, Series, Window, WindowContact};
use crate::engine::flight::{Flight, Forcing};
use crate::model::{Cradle, MAX_OUTPUT_DERIVATIVE, Mode};

/// The balls and contacts of a chain at one time, which determine its motion.
#[derive(Clone, Debug)]
pub(crate) struct ChainState {
    pub flights: Vec<Flight>,
    pub contacts: Vec<WindowContact>,
}

impl ChainState {
    /// A state of these positions (m) and velocities (m/s), overlaps (m) and modes, without inputs.
    pub fn new(balls: impl Iterator<Item = (f64, f64)>, contacts: impl Iterator<Item = (f64, Mode)>) -> Self {
        let flight = |(x, v)| Flight { x, v, forcing: Forcing::default() };
        let contact = |(overlap, mode)| WindowContact { overlap, mode };
        Self { flights: balls.map(flight).collect(), contacts: contacts.map(contact).collect() }
    }

    /// The state under these accelerations by the inputs.
    pub fn under(mut self, forcings: impl IntoIterator<Item = Forcing>) -> Self {
        self.flights.iter_mut().zip(forcings).for_each(|(flight, forcing)| flight.forcing = forcing);
        self
    }

    /// The whole chain as a window, with these coefficients of its equations.
    pub fn window<'a>(&'a self, cradle: &'a Cradle) -> Window<'a> {
        let (Cradle { balls, contacts: laws, .. }, Self { flights, contacts }) = (cradle, self);
        Window { flights, models: balls, balls: &[], contacts, laws }
    }
}

impl ChainState {
    /// The series of all motions and forces, in seconds, up to the highest derivative by time. The run's description
    /// can give the overlaps of pressing contacts (`given`): computed from forces they would be mere rounding, which
    /// each derivative multiplies by the angular frequency of the contact, some 1e5 1/s.
    pub fn series(&self, cradle: &Cradle, given: &[Option<OverlapSeries>]) -> Series {
        let (window, mut series) = (self.window(cradle), Series::default());
        series.begin(&window, MAX_OUTPUT_DERIVATIVE + 1, 1.0);
        for (j, given) in given.iter().enumerate() {
            if let Some(given) = given {
                let at = j * series.stride;
                series.overlaps[at..at + given.len()].copy_from_slice(given);
            }
        }
        let is_given = |j: usize| given.get(j).is_some_and(Option::is_some);
        series.fill(&window, &|_| false, &is_given);
        series
    }
}
