//! What can go wrong at the border.

use std::io;
use std::path::{Path, PathBuf};

use crate::sim::{Diverged, Refused};
use crate::wire::cdr::CdrError;

/// A run or a recording that failed, with the values that say why.
#[derive(Debug, thiserror::Error)]
pub enum NodeError {
    /// The physics stopped; everything up to the last good state is recorded.
    #[error(transparent)]
    Diverged(#[from] Diverged),
    /// The scene asks for what the method cannot do.
    #[error(transparent)]
    Refused(#[from] Refused),
    /// A message could not be encoded or decoded.
    #[error(transparent)]
    Cdr(#[from] CdrError),
    /// A file could not be used.
    #[error("cannot {action} {}: {source}", path.display())]
    File {
        /// What was tried: `create`, `write`, `read`, ...
        action: &'static str,
        /// On which file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The disk is full or a quota is reached; what was recorded before it can be opened.
    #[error("no space left for {} after {bytes} bytes: {source}; the recording is closed at the last state that fitted", path.display())]
    DiskFull {
        /// The recording.
        path: PathBuf,
        /// Its size when space ran out \[bytes\].
        bytes: u64,
        /// What the system says.
        source: io::Error,
    },
    /// A file that is not a recording of toile, or damaged.
    #[error("{} is not a readable recording of toile: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        reason: String,
    },
    /// A frame that the recording does not have.
    #[error("{}: state {index} was asked for, there are {count}", path.display())]
    NoSuchFrame {
        /// The recording.
        path: PathBuf,
        /// Index asked for.
        index: usize,
        /// States in the recording.
        count: usize,
    },
    /// Somebody stopped a replay.
    #[error("stopped after step {step} of {last}; the replay agrees up to there")]
    ReplayStopped {
        /// Steps taken.
        step: u64,
        /// Steps of the recording.
        last: u64,
    },
    /// Shared memory does not do what was asked.
    #[cfg(feature = "iceoryx2")]
    #[error(transparent)]
    SharedMemory(#[from] super::shared_memory::SharedMemoryError),
    /// ROS 2 does not do what was asked.
    #[cfg(feature = "ros2")]
    #[error(transparent)]
    Ros2(#[from] super::ros2::Ros2Error),
    /// The recorder thread ended without a word.
    #[error("the recorder thread panicked; the recording ends at its last complete chunk")]
    RecorderLost,
}

impl NodeError {
    /// Binds an IO error to what was tried on which file.
    pub(crate) fn file(
        action: &'static str,
        path: &Path,
    ) -> impl FnOnce(io::Error) -> NodeError + use<> {
        let path = path.to_path_buf();
        move |source| NodeError::File {
            action,
            path,
            source,
        }
    }

    /// A file whose content is wrong.
    pub(super) fn unreadable(path: &Path, reason: impl std::fmt::Display) -> NodeError {
        NodeError::Unreadable {
            path: path.to_path_buf(),
            reason: reason.to_string(),
        }
    }
}
