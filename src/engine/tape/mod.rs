//! A run as a sequence of linear maps. A recorder ([`Recorder`]) notes each part of a run as it ends: flights of single
//! balls (`flight`), motions of neighbours that press on each other (`step`), impacts of two (`impact`) and of rigid
//! balls (`rigid`), and what happens at one time (`events`). Each is a map (`part`) from changes of the state before it
//! and of the coefficients to changes of the state after it, and transposed. See "Derivatives" in docs/theory.md.

mod arc_impact;
mod coefficients;
mod end;
mod events;
mod flight;
mod gradient;
mod impact;
mod linearise;
mod nodes;
mod part;
mod record;
mod rigid;
mod scene;
mod step;
mod unfollowed;

pub(crate) use end::{Direction, End, along_direction, change_of_start, cradle_along};
pub use gradient::{Gradient, Tape};
pub(crate) use record::{Recorder, Sink};
pub use unfollowed::Unfollowed;
