//! What an event-driven run shows: the outputs at its current time, with how the step began (`outputs`), and the next
//! onset or release, which a copy of the run may go ahead to find (`look_ahead`).
//! It is evaluated when somebody asks, and moves nothing. Hands out nothing but functions of the run.

mod look_ahead;
mod outputs;
