//! Shared memory between processes of one user: states out and commands in, without sockets, over iceoryx2.
//!
//! A run has a name and publishes each channel as a service of its own, `toile/<run>/state` and so on: the
//! message's CDR bytes, and beside them a [`Header`]. Every published instant rings the event service
//! `toile/<run>/published`. All inlets are reached through one request-response service, `toile/<run>/inlets`,
//! the inlet's name in the [`CallHeader`].
//!
//! iceoryx2's files are readable by their owner only, and its usual configuration file applies: processes with
//! another prefix there do not see each other. What a killed process leaves behind is removed by the next one
//! that joins.

mod client;
mod error;
mod header;
mod link;
mod names;
mod publisher;
mod server;
mod subscription;
mod sweep;

pub use client::Client;
pub use error::SharedMemoryError;
pub use header::{ABI, CallHeader, Header, INLET_BYTES, Refusal, ReplyHeader, schema};
pub use names::RunName;
pub use publisher::{Counts, SharedMemory};
pub use server::{Call, Desk};
pub use subscription::{Received, Subscription};

/// Longest request \[bytes\].
pub const MOST_BYTES: usize = 1 << 20;
