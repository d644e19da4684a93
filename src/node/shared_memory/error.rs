//! What can go wrong between processes.

use std::io;
use std::path::PathBuf;

use super::Refusal;

/// Shared memory that does not do what was asked.
#[derive(Debug, thiserror::Error)]
pub enum SharedMemoryError {
    /// A name that no run can have.
    #[error(
        "run name {name:?} is out of range: 1 to {} letters, digits, '-', '_' or '.'",
        super::names::MOST_LETTERS
    )]
    Name {
        /// The name.
        name: String,
    },
    /// Another process publishes under this name.
    #[error(
        "a run named {name:?} is in shared memory already; give this one another name with --name"
    )]
    NameTaken {
        /// The name.
        name: String,
    },
    /// Nobody publishes under this name.
    #[error(
        "no run named {name:?} is in shared memory; start one with `toile run SCENE --shm --name {name}`"
    )]
    NoRun {
        /// The name.
        name: String,
    },
    /// The folder in which iceoryx2 keeps its files cannot be used: it belongs to another user, or is none.
    #[error(
        "shared memory: {} is not to be used: {source}; set global.root-path and global.prefix in iceoryx2.toml",
        folder.display()
    )]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The system or iceoryx2 refuses.
    #[error("shared memory: cannot {action} {service}: {reason}")]
    Transport {
        /// What was tried.
        action: &'static str,
        /// On which service.
        service: String,
        /// What iceoryx2 says.
        reason: String,
    },
    /// The run refused a request.
    #[error("{inlet}: {refusal}")]
    Refused {
        /// Where the request was sent.
        inlet: String,
        /// Why.
        refusal: Refusal,
    },
    /// No answer came.
    #[error("{inlet}: no answer within {seconds} s")]
    TimedOut {
        /// Where the request was sent.
        inlet: String,
        /// How long it was waited for \[s\].
        seconds: f64,
    },
}

impl SharedMemoryError {
    /// Binds iceoryx2's word to what was tried.
    pub(super) fn transport<E: std::fmt::Debug>(
        action: &'static str,
        service: &str,
    ) -> impl FnOnce(E) -> Self {
        move |error| Self::Transport {
            action,
            service: service.to_string(),
            reason: format!("{error:?}"),
        }
    }
}
