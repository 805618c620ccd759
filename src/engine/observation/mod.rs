//! What an event-driven run shows: the outputs at its current time, with how the step began (`outputs`), and the next
//! onset, which a copy of the run may go ahead to find (`look_ahead`), also the next onset or release (`next_event`).
//! It is evaluated when somebody asks, and moves nothing. Hands out nothing but functions of the run.

mod look_ahead;
mod next_event;
mod outputs;
