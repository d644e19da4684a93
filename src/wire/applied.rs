//! Commands as they took effect, or why not: with the scene, all that a replay needs.

use super::cdr::CdrError;
use super::inbound::Inlet;
use super::messages::toile_msgs::AppliedCommand;
use super::packets::{Packet, packet};
use super::{channels, header};

/// What became of the bytes that came in on an inlet, at a step boundary: `step` is the index of the last step
/// taken, `time` its simulated time \[s\], `outcome` the reason if it was rejected.
pub fn applied(
    inlet: &Inlet,
    payload: &[u8],
    step: u64,
    time: f64,
    outcome: Result<(), String>,
) -> Result<Packet, CdrError> {
    let message = AppliedCommand {
        header: header(time),
        step,
        channel: inlet.name.to_string(),
        r#type: inlet.request.name.to_string(),
        payload: payload.to_vec(),
        accepted: outcome.is_ok(),
        reason: outcome.err().unwrap_or_default(),
    };
    packet(&channels::APPLIED, time, &message)
}
