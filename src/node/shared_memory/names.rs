//! Names: of runs, and of the services of a run.

use std::fmt;
use std::str::FromStr;

use iceoryx2::prelude::ServiceName;

use super::SharedMemoryError;

/// Longest name of a run.
pub const MOST_LETTERS: usize = 64;

/// The name under which a run is found in shared memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunName(String);

impl Default for RunName {
    fn default() -> Self {
        Self("toile".to_string())
    }
}

impl FromStr for RunName {
    type Err = SharedMemoryError;

    fn from_str(name: &str) -> Result<Self, SharedMemoryError> {
        let fine = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        match (1..=MOST_LETTERS).contains(&name.len()) && name.chars().all(fine) {
            true => Ok(Self(name.to_string())),
            false => Err(SharedMemoryError::Name {
                name: name.to_string(),
            }),
        }
    }
}

impl fmt::Display for RunName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl RunName {
    /// Publish-subscribe service of a topic: `/toile/state` is `toile/<run>/state`, `/tf` is `toile/<run>/tf`.
    pub fn channel(&self, topic: &str) -> String {
        let topic = topic.trim_start_matches('/');
        format!(
            "toile/{self}/{}",
            topic.strip_prefix("toile/").unwrap_or(topic)
        )
    }

    /// Event service: something was published.
    pub fn published(&self) -> String {
        format!("toile/{self}/published")
    }

    /// Event service: somebody called.
    pub fn called(&self) -> String {
        format!("toile/{self}/called")
    }

    /// Request-response service of all inlets.
    pub fn inlets(&self) -> String {
        format!("toile/{self}/inlets")
    }
}

/// A service name as iceoryx2 wants it.
pub(super) fn service_name(name: &str) -> Result<ServiceName, SharedMemoryError> {
    ServiceName::new(name).map_err(SharedMemoryError::transport("name", name))
}
