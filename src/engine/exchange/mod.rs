//! A run that its host integrates: model exchange.
//!
//! The host sets time and states, and reads derivatives and event indicators (`run`, `equations`). Contacts open and
//! close only in events (`events`), and forces follow these flags, so the equations are smooth in between. With
//! `exchange.contacts = mapped` an event follows a group of contacts to its end by the event-driven engine
//! (`events/group`), and the host integrates only flight; with `resolved` it integrates the pulses. Lasting contacts
//! are always resolved. Rigid contacts are impulses. The next onset is computed with the inputs held (`flights`).

mod contact;
mod equations;
mod events;
mod flights;
mod run;
mod scales;

pub use equations::state_count;
pub use events::Update;
pub use run::Exchange;
