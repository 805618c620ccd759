//! Saving and restoring an instance, in memory and as bytes for another process.

use std::fmt::Display;

use uuid::Uuid;

use super::legality::{Kind, Phase, Purpose};
use super::lifecycle::{Instance, InstanceState};
use crate::engine::{Exchange, InvalidState, Simulation, SimulationSnapshot, require};
use crate::variables::{MAX_BALLS, MIN_BALLS, Refusal, ensure};

/// A saved state, without the log.
pub struct SavedState {
    guid: String,
    run: InstanceState,
}

/// First bytes of a serialized state, and its format.
const MAGIC: [u8; 8] = *b"cradleFS";
const FORMAT: u32 = 22;
const HEADER: usize = MAGIC.len() + size_of::<u32>();

const DIGEST: usize = size_of::<uuid::Bytes>();

/// A name-based UUID (version 5, hence by SHA-1) of all bytes before it, so that no damage goes unnoticed.
fn digest(bytes: &[u8]) -> uuid::Bytes {
    Uuid::new_v5(&Uuid::NAMESPACE_OID, bytes).into_bytes()
}

/// GUID and number of balls of the FMU that a state belongs to.
type Owner = (String, usize);
type Content = (InstanceState, Option<SimulationSnapshot>, Option<Exchange>);

impl SavedState {
    /// The state as bytes: a header; in postcard's format the owner, the run and its simulation; a digest.
    pub fn to_bytes(&self) -> Result<Vec<u8>, Refusal> {
        // In Initialization Mode the simulation follows from the settings.
        let calculated = self.run.phase > Phase::InitializationMode;
        let simulation = self.run.simulation.as_ref().filter(|_| calculated).map(Simulation::snapshot);
        let exchange = self.run.exchange.as_ref().filter(|_| calculated);
        let owner = (&self.guid, self.run.settings.balls());
        let content = postcard::to_allocvec(&(owner, &self.run, simulation, exchange));
        let content = content.map_err(|_| Refusal::new("the state cannot be written"))?;
        let mut bytes = [MAGIC.as_slice(), &FORMAT.to_le_bytes(), &content].concat();
        bytes.extend(digest(&bytes));
        Ok(bytes)
    }
}

fn refused(reason: impl Display) -> Refusal {
    Refusal::new(format_args!("the state is refused: {reason}"))
}

impl From<InvalidState> for Refusal {
    fn from(InvalidState(reason): InvalidState) -> Self {
        refused(format_args!("it is inconsistent: {reason}"))
    }
}

/// The content of the bytes of a state, or why they are not a state.
fn content(bytes: &[u8]) -> Result<&[u8], Refusal> {
    let foreign = || refused("these are not the bytes of a state of this FMU, or they are cut short");
    let rest = bytes.strip_prefix(&MAGIC).ok_or_else(foreign)?;
    let (format, rest) = rest.split_first_chunk().ok_or_else(foreign)?;
    let format = u32::from_le_bytes(*format);
    let version = if format < FORMAT { "an earlier" } else { "a later" };
    let of_another = || refused(format_args!("its format, {format}, is that of {version} version; allowed: {FORMAT}"));
    ensure(format == FORMAT, of_another)?;
    let (content, _) = rest.split_last_chunk::<DIGEST>().ok_or_else(foreign)?;
    let (before, end) = bytes.split_at(HEADER + content.len());
    ensure(end == digest(before), || refused("the bytes are damaged"))?;
    Ok(content)
}

impl Instance {
    pub fn state(&self) -> SavedState {
        SavedState { guid: self.start.guid.clone(), run: self.run.clone() }
    }

    /// Restores a state saved by this instance or by another one of the same FMU.
    pub fn set_state(&mut self, state: &SavedState) -> Result<(), Refusal> {
        self.check_owner(&state.guid, state.run.settings.balls())?;
        self.check_purpose(state.run.purpose)?;
        let own = self.run.purpose;
        self.run.clone_from(&state.run);
        // Early return belongs to the instance, not to the saved state.
        self.run.purpose = own;
        Ok(())
    }

    fn check_purpose(&self, Purpose { kind, events, .. }: Purpose) -> Result<(), Refusal> {
        let own = self.run.purpose.kind;
        ensure(kind == own, || {
            refused(format_args!("it is one of {kind}; allowed: states of {own}, which the instance was created for"))
        })?;
        let of_another = || refused("it is one of an instance that was created with another eventModeUsed");
        ensure(events == self.run.purpose.events, of_another)
    }

    fn check_owner(&self, guid: &str, balls: usize) -> Result<(), Refusal> {
        let own = &self.start.guid;
        let fmu = |guid, balls| format!("the FMU of {balls} ball(s) with the GUID {guid}");
        ensure(guid == own, || {
            refused(format_args!("it belongs to {}; allowed: states of {}", fmu(guid, balls), fmu(own, self.balls())))
        })
    }

    /// Reads what [`SavedState::to_bytes`] wrote, in this or another process.
    pub fn read_state(&self, bytes: &[u8]) -> Result<SavedState, Refusal> {
        let unreadable = |_| InvalidState("it cannot be read");
        let ((guid, owner_balls), rest) = postcard::take_from_bytes::<Owner>(content(bytes)?).map_err(unreadable)?;
        self.check_owner(&guid, owner_balls)?;
        let ((mut run, snapshot, exchange), rest) = postcard::take_from_bytes::<Content>(rest).map_err(unreadable)?;
        require(rest.is_empty(), "there are more bytes than those of the state")?;
        // Only hosts of FMI 3.0 with arrays can change the number of balls.
        let Purpose { kind, fmi3, .. } = self.run.purpose;
        let balls = if self.start.scalars { self.balls() } else { owner_balls.clamp(MIN_BALLS, MAX_BALLS) };
        require(run.purpose.fmi3 == fmi3, "it is one of another version of the standard")?;
        run.check(balls)?;
        self.check_purpose(run.purpose)?;
        let calculated = run.phase > Phase::InitializationMode;
        let [steps, exchanges] = [Kind::CoSimulation, Kind::ModelExchange].map(|of| calculated && kind == of);
        let matches = steps == snapshot.is_some() && exchanges == exchange.is_some();
        require(matches, "its phase does not match its contents")?;
        let (parameters, start, failed) = (run.effective_parameters(), run.start_time(), run.phase == Phase::Error);
        run.exchange = exchange.map(|exchange| exchange.restored(&parameters, start, failed)).transpose()?;
        if let Some(snapshot) = snapshot {
            run.simulation = Some(Simulation::restore(parameters, start, snapshot, failed, |p| run.allows(p))?);
        }
        Ok(SavedState { guid: self.start.guid.clone(), run })
    }
}
