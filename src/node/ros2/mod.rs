//! ROS 2 over DDS, in a process of its own: `toile bridge`.
//!
//! DDS is kept away from the simulation because one forged packet can make the stack eat memory, its sockets bind
//! every interface, and a subscriber that was killed can hold a writer up. So the bridge is a process that reads
//! and writes shared memory like any other client, under a memory limit, and may die: [`Supervisor`] starts it
//! again. Message bytes pass through it as they are; nothing is decoded or encoded but the names of obstacles.

mod bridge;
mod dds;
mod discovery;
mod error;
mod inward;
mod memory;
mod outward;
mod peer;
mod raw;
mod service;
mod settings;
mod supervisor;
mod traffic;

pub use bridge::bridge;
pub use dds::{Participant, Reader, Sample, Writer};
pub use error::Ros2Error;
pub use memory::{MEMORY_LIMIT_MIB, limit_memory};
pub use peer::Peer;
pub use settings::{ServiceMapping, Settings};
pub use supervisor::{BridgeCommand, BridgeReport, Notice, Supervisor};
pub use traffic::Traffic;
