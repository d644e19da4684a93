//! What a request gets back.

use super::{Inlet, Malformed};
use crate::sim::Rejected;
use crate::wire::cdr::CdrError;

/// What became of a request.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// It was done.
    Done,
    /// It was not understood, or cannot be done.
    Malformed(Malformed),
    /// The simulation did not take it; its state is as it was.
    Rejected(Rejected),
}

/// The response of a service as CDR; nothing for a topic, which has none.
pub fn answer(inlet: &Inlet, outcome: &Outcome) -> Result<Vec<u8>, CdrError> {
    (inlet.write)(outcome)
}

/// The response of a topic.
pub(super) fn nothing(_: &Outcome) -> Result<Vec<u8>, CdrError> {
    Ok(vec![])
}
