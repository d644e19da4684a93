//! Why a verb did not do its job.

use std::io;
use std::path::PathBuf;
use std::process::ExitCode;

#[cfg(feature = "ros2")]
use crate::node::ros2::Ros2Error;
#[cfg(feature = "iceoryx2")]
use crate::node::shared_memory::SharedMemoryError;
use crate::node::{Difference, NodeError};
use crate::scene::SceneError;
use crate::sim::Diverged;

/// A failure of a verb; its kind decides the exit code.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// Input that cannot be used, in words.
    #[error("{0}")]
    Input(String),
    /// A refused option or override.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A run that stopped at a step it could not take.
    #[error("{diverged}; recorded up to there in {}", recording.display())]
    Diverged {
        /// Step, time, place and advice.
        diverged: Diverged,
        /// Where the last good state is.
        recording: PathBuf,
    },
    /// An instrument that found no reading, in words.
    #[error("{0}")]
    Measure(String),
    /// A run or a file that failed.
    #[error(transparent)]
    Node(#[from] NodeError),
    /// A recording that is not whole.
    #[error("{} is not whole: {count} fault{}", file.display(), if *count == 1 { "" } else { "s" })]
    Faulty {
        /// The recording.
        file: PathBuf,
        /// Faults that were told.
        count: usize,
    },
    /// A replay that is not what was recorded.
    #[error("{} differs at {difference}", file.display())]
    Differs {
        /// The recording.
        file: PathBuf,
        /// Where, and in what.
        difference: Difference,
    },
    /// A running simulation said no.
    #[error("{0}")]
    Refused(String),
    /// Standard output does not take the result.
    #[error("cannot write to standard output: {0}")]
    Output(io::Error),
}

impl CliError {
    /// 2 for bad usage or input, 1 for a run that failed.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            CliError::Input(_) | CliError::Scene(_) => ExitCode::from(2),
            // A recording that cannot be read is bad input; one that cannot be written, a failed run.
            CliError::Node(
                NodeError::Refused(_)
                | NodeError::File { action: "open", .. }
                | NodeError::Unreadable { .. }
                | NodeError::NoSuchFrame { .. },
            ) => ExitCode::from(2),
            #[cfg(feature = "iceoryx2")]
            CliError::Node(NodeError::SharedMemory(
                SharedMemoryError::Name { .. } | SharedMemoryError::NameTaken { .. },
            )) => ExitCode::from(2),
            #[cfg(feature = "ros2")]
            CliError::Node(NodeError::Ros2(
                Ros2Error::Variable { .. }
                | Ros2Error::LanForbidden { .. }
                | Ros2Error::Name { .. },
            )) => ExitCode::from(2),
            CliError::Diverged { .. }
            | CliError::Measure(_)
            | CliError::Node(_)
            | CliError::Faulty { .. }
            | CliError::Differs { .. }
            | CliError::Refused(_)
            | CliError::Output(_) => ExitCode::from(1),
        }
    }
}
