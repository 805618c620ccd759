//! The results of an event-driven run: the outputs at its current time and over the step (`outputs`), and the next
//! onset or release, possibly by a copy of the run that looks ahead (`look_ahead`). They are evaluated on request, and
//! change nothing.

mod look_ahead;
mod outputs;
