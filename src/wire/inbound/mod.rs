//! What comes in, from bytes to requests: each channel that commands arrive on is an [`Inlet`] of one table, and
//! nothing that has passed [`decode`] can harm a simulation: every number is finite and in its range, every name
//! and frame is legal. Whether it fits the state (is there such an obstacle?) the simulation says.

mod air;
mod answer;
mod check;
mod compose;
mod malformed;
mod object;
mod obstacle;
mod request;
mod services;
mod table;

pub use answer::{Outcome, RunState, answer};
pub use malformed::Malformed;
pub use object::Object;
pub use request::Request;
pub use table::{ALL, Inlet, InletKind, decode, find};
