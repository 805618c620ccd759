//! A run that its host integrates: see "Model exchange" in docs/theory.md. The host sets time and states, and reads
//! derivatives and event indicators (`run`). In `events` contacts open and close, and groups of them are
//! followed to their end (`events/group`). The next onset is computed with the inputs held (`flights`).

mod contact;
mod events;
mod flights;
mod run;
mod scales;

pub use events::Update;
pub use run::Exchange;
pub use scales::state_count;
