//! The results of an event-driven run, evaluated on request: the outputs at its current time and over the step
//! (`outputs`), and the next onset or release, possibly by a copy of the run that looks ahead (`look_ahead`).

mod look_ahead;
mod outputs;
