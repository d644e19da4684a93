//! Every way in: topic or service, and the types of what comes and goes.

use super::MessageType;

/// How an inlet is reached over DDS.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InletKind {
    /// A message without an answer.
    Topic,
    /// A request with a response.
    Service,
}

/// A way in.
#[derive(Debug, PartialEq, Eq)]
pub struct Inlet {
    /// Topic or service.
    pub name: &'static str,
    /// Which of the two.
    pub kind: InletKind,
    /// Type of what comes in.
    pub request: &'static MessageType,
    /// Type of a service's answer.
    pub response: Option<&'static MessageType>,
}
