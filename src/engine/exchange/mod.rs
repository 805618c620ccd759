//! A run that its host integrates: model exchange.
//!
//! The host moves time and states, and asks for derivatives and event indicators (`run`, `equations`). Contacts open
//! and close in events only (`events`), and forces follow these flags, so that the equations are smooth in between.
//! With `exchange.contacts = mapped` an event follows a group of contacts to its end by the event-driven engine
//! (`events/group`), and the host integrates nothing but flight; with `resolved` it integrates the pulses. What lasts
//! is always resolved. Rigid contacts are impulses. The next onset is foretold with the inputs held (`flights`).

mod contact;
mod equations;
mod events;
mod flights;
mod run;
mod scales;

pub use equations::state_count;
pub use events::Update;
pub use run::Exchange;
