//! Where a replay differs from its recording, and in what.

use serde::Serialize;

/// Where a replay differs from its recording, and in what.
#[derive(Clone, Debug, PartialEq, Serialize, thiserror::Error)]
#[error("step {step} ({time:.6} s): {what}")]
pub struct Difference {
    /// The step.
    pub step: u64,
    /// Its simulated time \[s\].
    pub time: f64,
    /// In what.
    #[serde(flatten)]
    pub what: What,
}

/// In what a replay differs.
#[derive(Clone, Debug, PartialEq, Serialize, thiserror::Error)]
#[serde(tag = "what", rename_all = "kebab-case")]
pub enum What {
    /// Positions or velocities as recorded, in single precision.
    #[error(
        "vertex {vertex} is the first that differs, by {distance:.3e} m; vertex {furthest} differs most, by {largest:.3e} m"
    )]
    State {
        /// First vertex with another position or velocity.
        vertex: usize,
        /// How far it is from where it was \[m\].
        distance: f64,
        /// Vertex that is furthest from where it was.
        furthest: usize,
        /// How far \[m\].
        largest: f64,
    },
    /// The whole state in double precision, although positions and velocities agree in single.
    #[error(
        "digest {found:016x} instead of {recorded:016x}; positions and velocities agree in single precision"
    )]
    Digest {
        /// As recorded.
        #[serde(serialize_with = "hexadecimal")]
        recorded: u64,
        /// As found.
        #[serde(serialize_with = "hexadecimal")]
        found: u64,
    },
    /// A reading of the scene.
    #[error("{name} reads {found:.9e} m instead of {recorded:.9e} m")]
    Reading {
        /// Its name.
        name: String,
        /// As recorded \[m\].
        recorded: f64,
        /// As found \[m\].
        found: f64,
    },
    /// What became of a command.
    #[error("a command on {channel} is {found}, recorded as {recorded}")]
    Command {
        /// Where it came in.
        channel: String,
        /// As recorded.
        recorded: String,
        /// As found.
        found: String,
    },
    /// A message of another topic has other bytes.
    #[error("a message on {topic} has other bytes")]
    Message {
        /// The topic.
        topic: String,
    },
    /// Messages come in another order.
    #[error("{found} is published where {recorded} of {recorded_time:.6} s was recorded")]
    Order {
        /// Topic as recorded.
        recorded: String,
        /// When it was recorded \[s\].
        recorded_time: f64,
        /// Topic as found.
        found: String,
    },
    /// The recording goes on.
    #[error("the replay ends, the recording goes on with {topic}")]
    Missing {
        /// The first topic that is missing.
        topic: String,
    },
    /// What cannot be compared.
    #[error("{0}")]
    Misfit(String),
    /// The physics stopped.
    #[error("{0}")]
    Diverged(String),
}

/// Programs read JSON numbers as doubles, which do not hold 64 bits.
fn hexadecimal<S: serde::Serializer>(value: &u64, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&format!("{value:016x}"))
}
