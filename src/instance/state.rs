//! Saving and restoring an instance: in memory, and as bytes that another process can go on from.

use serde::{Deserialize, Serialize};
use uuid::Uuid;

use super::{Instance, Phase, Refusal, Run};
use crate::engine::{MAX_INPUT_DERIVATIVE, Simulation, SimulationSnapshot, Unsound};

/// A saved state. The log is no part of it.
pub struct State {
    guid: String,
    run: Run,
}

/// Why a state or its bytes are not accepted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StateError {
    /// The bytes are something else.
    NoState,
    /// Written by another version, in this format.
    Format(u32),
    /// Not the bytes that were written.
    Damaged,
    /// Of another FMU.
    Foreign { theirs: String, ours: String },
    /// No instance can have been in this state.
    Unsound(&'static str),
}

impl std::fmt::Display for StateError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoState => write!(f, "these are not the bytes of a state of this FMU, or their end is missing"),
            Self::Format(format) => write!(f, "format {format} is unknown; known: {FORMAT}"),
            Self::Damaged => write!(f, "the bytes are damaged"),
            Self::Foreign { theirs, ours } => write!(f, "it belongs to {theirs}; allowed: states of {ours}"),
            Self::Unsound(reason) => write!(f, "no run leads to it: {reason}"),
        }
    }
}

impl From<Unsound> for StateError {
    fn from(Unsound(reason): Unsound) -> Self {
        Self::Unsound(reason)
    }
}

/// What the bytes begin with, and the format that follows.
const MAGIC: [u8; 8] = *b"cradleFS";
const FORMAT: u32 = 2;
const HEADER: usize = MAGIC.len() + size_of::<u32>();

/// Length of the digest that the bytes end with.
const DIGEST: usize = size_of::<uuid::Bytes>();

/// A name-based UUID (version 5, hence by SHA-1) of all bytes before it: no damage goes unnoticed.
fn digest(bytes: &[u8]) -> uuid::Bytes {
    Uuid::new_v5(&Uuid::NAMESPACE_OID, bytes).into_bytes()
}

/// Whom a state belongs to.
#[derive(Serialize, Deserialize)]
struct Owner {
    guid: String,
    balls: usize,
}

/// What follows on the owner.
type Content = (Run, Option<SimulationSnapshot>);

impl std::fmt::Display for Owner {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the FMU of {} ball(s) with the GUID {}", self.balls, self.guid)
    }
}

impl State {
    fn owner(&self) -> Owner {
        Owner { guid: self.guid.clone(), balls: self.run.settings.balls() }
    }

    /// The state as bytes: a header, then in postcard's format whose it is, the run and its engine, and a digest.
    pub fn to_bytes(&self) -> Result<Vec<u8>, Refusal> {
        // In Initialization Mode the engine follows from the settings.
        let calculated = self.run.phase > Phase::InitializationMode;
        let engine = self.run.engine.as_ref().filter(|_| calculated).map(Simulation::snapshot);
        let content = postcard::to_allocvec(&(self.owner(), &self.run, engine));
        let content = content.map_err(|_| Refusal::Missing("the state cannot be written"))?;
        let mut bytes = [MAGIC.as_slice(), &FORMAT.to_le_bytes(), &content].concat();
        bytes.extend(digest(&bytes));
        Ok(bytes)
    }
}

/// The content of the bytes of a state, or why they are none.
fn content(bytes: &[u8]) -> Result<&[u8], StateError> {
    let rest = bytes.strip_prefix(&MAGIC).ok_or(StateError::NoState)?;
    let (format, rest) = rest.split_first_chunk().ok_or(StateError::NoState)?;
    let format = u32::from_le_bytes(*format);
    if format != FORMAT {
        return Err(StateError::Format(format));
    }
    let (content, _) = rest.split_last_chunk::<DIGEST>().ok_or(StateError::NoState)?;
    let (before, end) = bytes.split_at(HEADER + content.len());
    if end == digest(before) { Ok(content) } else { Err(StateError::Damaged) }
}

impl Instance {
    /// Saves the state.
    pub fn state(&self) -> State {
        State { guid: self.guid.clone(), run: self.run.clone() }
    }

    /// Goes back to a state that was saved by this instance, or by another one of the same FMU.
    pub fn set_state(&mut self, state: &State) -> Result<(), Refusal> {
        self.check_owner(state.owner())?;
        self.run.clone_from(&state.run);
        Ok(())
    }

    fn check_owner(&self, owner: Owner) -> Result<(), StateError> {
        if owner.guid == self.guid {
            return Ok(());
        }
        let own = Owner { guid: self.guid.clone(), balls: self.balls() };
        Err(StateError::Foreign { theirs: owner.to_string(), ours: own.to_string() })
    }

    /// Reads what [`State::to_bytes`] wrote, in this or another process.
    pub fn read_state(&self, bytes: &[u8]) -> Result<State, Refusal> {
        let unreadable = |_| StateError::Unsound("it cannot be read");
        let (owner, rest) = postcard::take_from_bytes::<Owner>(content(bytes)?).map_err(unreadable)?;
        self.check_owner(owner)?;
        let ((mut run, engine), rest) = postcard::take_from_bytes::<Content>(rest).map_err(unreadable)?;
        if !rest.is_empty() {
            return Err(StateError::Unsound("there is more than a state").into());
        }
        run.check(self.balls())?;
        if (run.phase > Phase::InitializationMode) != engine.is_some() {
            return Err(StateError::Unsound("the phase does not fit").into());
        }
        if let Some(engine) = engine {
            let start = run.experiment.unwrap_or_default().start;
            let failed = run.phase == Phase::Error;
            let restored = Simulation::restore(&run.acting_parameters(), start, engine, failed);
            run.engine = Some(restored.map_err(StateError::from)?);
        }
        Ok(State { guid: self.guid.clone(), run })
    }
}

impl Run {
    /// Refuses what cannot have been written, but for the engine.
    fn check(&self, balls: usize) -> Result<(), StateError> {
        let sound = |holds: bool, reason| if holds { Ok(()) } else { Err(StateError::Unsound(reason)) };
        sound(self.settings.are_sound(balls), "a setting is out of range")?;
        let experiment = self.experiment.is_none_or(|experiment| experiment.check().is_ok());
        sound(
            experiment && (self.experiment.is_some() || self.phase == Phase::Instantiated),
            "its times are no times",
        )?;
        let derivatives = &self.input_derivatives;
        let known = derivatives.len() <= MAX_INPUT_DERIVATIVE
            && derivatives.iter().all(|inputs| inputs.force.len() == balls && inputs.is_finite());
        sound(known, "an input derivative is out of range")?;
        let tunables = self.tuned_from.is_none_or(|tunables| {
            let mut before = self.settings.clone();
            before.parameters.tune(tunables);
            before.are_sound(balls)
        });
        sound(tunables, "a tunable parameter is out of range")
    }
}
