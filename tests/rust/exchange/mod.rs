//! Model exchange, through a host with fixed steps.

mod derivatives;
mod events;
mod masters;
mod rigid;
mod states;
mod touching;
