//! The runs that the page holds, by number.

use newtons_cradle::engine::{Engine, EngineError, Pulse, Results};
use newtons_cradle::model::SolverMethod;
use newtons_cradle::next::Next;
use newtons_cradle::variables::Settings;

/// A run and its pulses that the page has not fetched yet.
pub struct Run {
    engine: Engine,
    balls: usize,
    pub pulses: Vec<Pulse>,
}

impl Run {
    /// Starts a run at the time 0, or says why not.
    pub fn new(settings: Settings) -> Result<Self, String> {
        if settings.parameters.method != SolverMethod::EventDriven {
            return Err("solver.method is refused; allowed: eventDriven".into());
        }
        let engine = Engine::new(&settings.parameters, &settings.inputs, 0.0).map_err(|error| error.to_string())?;
        Ok(Self { engine, balls: settings.balls(), pulses: Vec::new() })
    }

    /// A second one that goes on from here, with pulses of its own.
    pub fn copy(&self) -> Self {
        Self { engine: self.engine.clone(), balls: self.balls, pulses: Vec::new() }
    }

    /// See [`Engine::advance_within`].
    pub fn advance(&mut self, time: f64, effort: u64) -> Result<f64, EngineError> {
        self.engine.advance_within(time, effort, &mut self.pulses)?;
        Ok(self.engine.time())
    }

    /// See [`Results::next_onset`].
    pub fn next_onset(&self) -> Next {
        self.engine.next_onset()
    }

    /// Appends what it shows at its time: eight numbers of the whole, then each quantity of the balls, each of the
    /// contacts.
    pub fn look(&self, numbers: &mut Vec<f64>) {
        let run = &self.engine;
        numbers.extend([
            run.time(),
            run.total_energy(),
            run.dissipated_energy(),
            run.external_work(),
            run.energy_residual(),
            run.momentum(),
            run.support_force(),
            run.work().events as f64,
        ]);
        let balls: [fn(&Engine, usize) -> f64; 4] =
            [Results::x, Results::v, Results::kinetic_energy, Results::gravity_energy];
        for quantity in balls {
            numbers.extend((0..self.balls).map(|i| quantity(run, i)));
        }
        let contacts: [fn(&Engine, usize) -> f64; 6] = [
            Results::force,
            Results::overlap,
            Results::contact_energy,
            Results::impulse,
            |run, i| run.pulses(i) as f64,
            |run, i| f64::from(u8::from(run.in_contact(i))),
        ];
        for quantity in contacts {
            numbers.extend((0..self.balls - 1).map(|i| quantity(run, i)));
        }
    }
}

/// All runs, by number; those of forgotten ones are given again.
#[derive(Default)]
pub struct Runs {
    slots: Vec<Option<Run>>,
}

impl Runs {
    /// Keeps a run: its number.
    pub fn add(&mut self, run: Run) -> i32 {
        let free = self.slots.iter().position(Option::is_none).unwrap_or_else(|| {
            self.slots.push(None);
            self.slots.len() - 1
        });
        self.slots[free] = Some(run);
        free as i32
    }

    /// The run with this number.
    pub fn get(&mut self, number: i32) -> &mut Run {
        self.slots.get_mut(number as usize).and_then(Option::as_mut).expect("the page asks for runs that it was given")
    }

    /// Frees it.
    pub fn forget(&mut self, number: i32) {
        if let Some(slot) = self.slots.get_mut(number as usize) {
            *slot = None;
        }
    }
}
