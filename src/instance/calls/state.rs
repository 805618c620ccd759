//! Saving and restoring an instance: in memory, and as bytes that another process can go on from.

use serde::{Deserialize, Serialize};
use uuid::Uuid;

use crate::engine::{Exchange, Simulation, SimulationSnapshot, Unsound};
use crate::instance::legality::{Kind, Phase};
use crate::instance::lifecycle::Instance;
use crate::instance::refusal::{Refusal, StateError};
use crate::instance::run::Run;
use crate::variables::{MAX_BALLS, MIN_BALLS};

/// A saved state. The log is no part of it.
pub struct SavedState {
    guid: String,
    run: Run,
}

/// What the bytes begin with, and the format that follows.
const MAGIC: [u8; 8] = *b"cradleFS";
const FORMAT: u32 = 11;
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
type Content = (Run, Option<SimulationSnapshot>, Option<Exchange>);

impl std::fmt::Display for Owner {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the FMU of {} ball(s) with the GUID {}", self.balls, self.guid)
    }
}

impl SavedState {
    fn owner(&self) -> Owner {
        Owner { guid: self.guid.clone(), balls: self.run.settings.balls() }
    }

    /// The state as bytes: a header, then in postcard's format whose it is, the run and its simulation, and a digest.
    pub fn to_bytes(&self) -> Result<Vec<u8>, Refusal> {
        // In Initialization Mode the simulation follows from the settings.
        let calculated = self.run.phase > Phase::InitializationMode;
        let simulation = self.run.simulation.as_ref().filter(|_| calculated).map(Simulation::snapshot);
        let exchange = self.run.exchange.as_ref().filter(|_| calculated);
        let content = postcard::to_allocvec(&(self.owner(), &self.run, simulation, exchange));
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
        return Err(StateError::Format { format, known: FORMAT });
    }
    let (content, _) = rest.split_last_chunk::<DIGEST>().ok_or(StateError::NoState)?;
    let (before, end) = bytes.split_at(HEADER + content.len());
    if end == digest(before) { Ok(content) } else { Err(StateError::Damaged) }
}

impl Instance {
    /// Saves the state.
    pub fn state(&self) -> SavedState {
        SavedState { guid: self.guid.clone(), run: self.run.clone() }
    }

    /// Goes back to a state that was saved by this instance, or by another one of the same FMU.
    pub fn set_state(&mut self, state: &SavedState) -> Result<(), Refusal> {
        self.check_owner(state.owner())?;
        self.check_kind(state.run.kind)?;
        let events = |run: &Run| run.hybrid.as_ref().is_some_and(|hybrid| hybrid.event_mode);
        if events(&state.run) != events(&self.run) {
            return Err(StateError::OtherEvents.into());
        }
        // Whether steps may end early is the host's say, not the state's.
        let early_return = self.run.hybrid.as_ref().is_some_and(|hybrid| hybrid.early_return);
        self.run.clone_from(&state.run);
        if let Some(hybrid) = &mut self.run.hybrid {
            hybrid.early_return = early_return;
        }
        Ok(())
    }

    fn check_kind(&self, kind: Kind) -> Result<(), StateError> {
        let own = self.run.kind;
        if kind == own { Ok(()) } else { Err(StateError::OtherKind { theirs: kind, ours: own }) }
    }

    fn check_owner(&self, owner: Owner) -> Result<(), StateError> {
        if owner.guid == self.guid {
            return Ok(());
        }
        let own = Owner { guid: self.guid.clone(), balls: self.balls() };
        Err(StateError::Foreign { theirs: owner.to_string(), ours: own.to_string() })
    }

    /// Reads what [`SavedState::to_bytes`] wrote, in this or another process.
    pub fn read_state(&self, bytes: &[u8]) -> Result<SavedState, Refusal> {
        let unreadable = |_| StateError::Unsound(Unsound("it cannot be read"));
        let (owner, rest) = postcard::take_from_bytes::<Owner>(content(bytes)?).map_err(unreadable)?;
        let owner_balls = owner.balls.clamp(MIN_BALLS, MAX_BALLS);
        self.check_owner(owner)?;
        let ((mut run, snapshot, exchange), rest) = postcard::take_from_bytes::<Content>(rest).map_err(unreadable)?;
        if !rest.is_empty() {
            return Err(StateError::Unsound(Unsound("there are more bytes than those of the state")).into());
        }
        // Only with arrays the number of balls is one of what the host can set.
        let balls = if self.run.hybrid.is_some() { owner_balls } else { self.balls() };
        run.check(balls).map_err(StateError::Unsound)?;
        self.check_kind(run.kind)?;
        let calculated = run.phase > Phase::InitializationMode;
        let exchanges = run.kind == Kind::ModelExchange;
        if (calculated && !exchanges) != snapshot.is_some() || (calculated && exchanges) != exchange.is_some() {
            return Err(StateError::Unsound(Unsound("its phase does not match its contents")).into());
        }
        let start = run.experiment.unwrap_or_default().start;
        let failed = run.phase == Phase::Error;
        if let Some(exchange) = exchange {
            let restored = exchange.restored(&run.effective_parameters(), start, failed);
            run.exchange = Some(restored.map_err(StateError::Unsound)?);
        }
        if let Some(snapshot) = snapshot {
            let restored = Simulation::restore(&run.effective_parameters(), start, snapshot, failed);
            run.simulation = Some(restored.map_err(StateError::Unsound)?);
        }
        Ok(SavedState { guid: self.guid.clone(), run })
    }
}
