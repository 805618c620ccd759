//! What an event-driven run shows: the outputs at its current time (`outputs`), the next onset, which a copy of the run may go
//! ahead to find (`look_ahead`), and how the step began for what an event is about to move (`recording`). All but the last is
//! evaluated when somebody asks, and moves nothing. Hands out nothing but functions of the run.

mod look_ahead;
mod outputs;
mod recording;
