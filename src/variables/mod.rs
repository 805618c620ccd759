//! The interface of the FMU: one table, and what follows from it.
//!
//! [`TABLE`] has a [`Row`] for each family of variables. A [`Variable`] is one of a family, or its array; values lie in
//! the [`Settings`] that a host has made, or in the [`Results`](crate::model::Results) of a run. The [`Description`],
//! its ModelStructure, the getters and the setters are all derived from the table. A [`Recipe`] is the copy of the
//! start values inside an FMU.

mod description;
mod losses;
mod recipe;
mod settings;
mod table;
mod text;
mod variable;
mod warnings;

pub use description::{Description, LogCategory, MODEL_IDENTIFIER, START_TIME, STEP_SIZE, STOP_TIME, padding};
pub use recipe::{FILE_NAME, Recipe, StartValue};
pub use settings::{DEFAULT_BALLS, DerivativesOf, Kind, MAX_BALLS, MIN_BALLS, Settings};
pub use table::TABLE;
pub use table::extra::MAX_LOG;
pub use table::row::{Access, Causality, Edge, Extra, Get, Groups, Need, Range, Row, Shape, Type, Variability};
pub use table::types::{Enumeration, QUANTITIES, Quantity};
#[cfg(feature = "engine")]
pub(crate) use text::RefusalCause;
pub use text::{Refusal, ensure, escaped};
pub use variable::{Variable, enumerations, states, variables};

pub use crate::number::Number;
