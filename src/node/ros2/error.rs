//! What can go wrong between toile and ROS 2.

use std::io;
use std::path::PathBuf;

/// A bridge that cannot start, or a peer that does not answer, with the values that say why.
#[derive(Debug, thiserror::Error)]
pub enum Ros2Error {
    /// An environment variable of ROS 2 with a value that it cannot have.
    #[error("{variable}={value} is not allowed; it takes {allowed}")]
    Variable {
        /// Its name.
        variable: &'static str,
        /// What it holds.
        value: String,
        /// What it may hold.
        allowed: &'static str,
    },
    /// `--allow-lan` where the environment says that nothing leaves the machine.
    #[error("--allow-lan contradicts {variable}={value}; unset one of them")]
    LanForbidden {
        /// The variable that forbids it.
        variable: &'static str,
        /// What it holds.
        value: String,
    },
    /// A node name or namespace that ROS 2 does not allow.
    #[error(
        "node {name} in namespace {namespace} is not a ROS 2 name: letters, digits and _, no digit first, no __; a namespace begins with /"
    )]
    Name {
        /// The node's name.
        name: String,
        /// Its namespace.
        namespace: String,
    },
    /// The DDS library did not make what was asked for.
    #[error("DDS domain {domain}: cannot create {what}: {reason}")]
    Create {
        /// ROS_DOMAIN_ID.
        domain: u16,
        /// What was to be made.
        what: String,
        /// What the library says.
        reason: String,
    },
    /// The process could not be started.
    #[error("cannot start {}: {reason}", program.display())]
    Start {
        /// What was to be started.
        program: PathBuf,
        /// What the system says.
        reason: io::Error,
    },
    /// The system does not set this limit.
    #[error("cannot limit the memory to {mebibytes} MiB: {reason}")]
    Memory {
        /// The limit.
        mebibytes: u64,
        /// What the system says.
        reason: io::Error,
    },
    /// Nobody on the domain takes the topic or serves the service.
    #[error(
        "nobody answers to {name} on DDS domain {domain} within {seconds} s; is a run with --ros2 there?"
    )]
    Nobody {
        /// ROS_DOMAIN_ID.
        domain: u16,
        /// Topic or service.
        name: String,
        /// How long it was waited for \[s\].
        seconds: f64,
    },
}
