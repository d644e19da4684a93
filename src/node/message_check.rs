//! Whether a recorded message is one of its channel: decodes, encodes to the same bytes, fits what came before.

use super::inventory::channel_of;
use super::scan::Message;
use crate::wire::cdr::{decode, encode};
use crate::wire::channels::{APPLIED, KEYFRAME, REPORT, STATE, TOPOLOGY};
use crate::wire::messages::rcl_interfaces::Log;
use crate::wire::messages::sensor_msgs::PointCloud2;
use crate::wire::messages::std_msgs::{Header, String as Text};
use crate::wire::messages::toile_msgs::{
    AppliedCommand, ContactEvents, Keyframe, MeshTopology, StepReport,
};
use crate::wire::messages::{
    diagnostic_msgs::DiagnosticArray, geometry_msgs::WrenchStamped, rosgraph_msgs::Clock,
    tf2_msgs::TFMessage, visualization_msgs::MarkerArray,
};
use crate::wire::{self, Message as Type, inbound};

type Check = fn(&[u8]) -> Result<(), String>;

/// Every type that a recording may hold.
const CHECKS: [(&str, Check); 13] = [
    check::<AppliedCommand>(),
    check::<Clock>(),
    check::<ContactEvents>(),
    check::<DiagnosticArray>(),
    check::<Keyframe>(),
    check::<Log>(),
    check::<MarkerArray>(),
    check::<MeshTopology>(),
    check::<PointCloud2>(),
    check::<StepReport>(),
    check::<TFMessage>(),
    check::<Text>(),
    check::<WrenchStamped>(),
];

const fn check<M: Type>() -> (&'static str, Check) {
    (M::TYPE.name, there_and_back::<M>)
}

/// There is one encoding only, so what decodes must encode to the same bytes.
fn there_and_back<M: Type>(bytes: &[u8]) -> Result<(), String> {
    let message: M = decode(bytes).map_err(|error| error.to_string())?;
    match encode(&message) {
        Ok(again) if again == bytes => Ok(()),
        Ok(_) => Err(format!("its bytes are not those of {}", M::TYPE.name)),
        Err(error) => Err(error.to_string()),
    }
}

/// Checks messages in the order of their recording.
#[derive(Default)]
pub(super) struct Checker {
    vertices: usize,
}

impl Checker {
    /// Why a message does not belong where it is.
    pub(super) fn check(&mut self, message: &Message) -> Result<(), String> {
        let channel = channel_of(&message.topic).ok_or("no topic of this version of toile")?;
        let name = channel.message.name;
        let (_, check) = CHECKS
            .iter()
            .find(|(known, _)| *known == name)
            .ok_or_else(|| format!("{name} is not known"))?;
        check(&message.bytes)?;
        let bytes = &message.bytes;
        if message.is(TOPOLOGY.topic) {
            let topology: MeshTopology = decoded(bytes)?;
            self.vertices = topology.outline.len() / 2;
        } else if message.is(STATE.topic) {
            let state: PointCloud2 = decoded(bytes)?;
            stamped(message, &state.header)?;
            let positions = wire::cloud::positions(&state).ok_or("a state of another layout")?;
            if positions.len() != self.vertices {
                let (found, wanted) = (positions.len(), self.vertices);
                return Err(format!("{found} vertices instead of {wanted}"));
            }
            if let Some(lost) = positions
                .iter()
                .position(|p| !p.iter().all(|c| c.is_finite()))
            {
                return Err(format!("vertex {lost} is nowhere"));
            }
        } else if message.is(REPORT.topic) {
            let report: StepReport = decoded(bytes)?;
            stamped(message, &report.header)?;
            if report.digest == 0 {
                return Err("there is no digest".to_string());
            }
        } else if message.is(KEYFRAME.topic) {
            let keyframe: Keyframe = decoded(bytes)?;
            stamped(message, &keyframe.header)?;
            let state = wire::keyframe::state(&keyframe).map_err(|error| error.to_string())?;
            if state.digest() != keyframe.digest {
                return Err("its digest is another".to_string());
            }
        } else if message.is(APPLIED.topic) {
            let applied: AppliedCommand = decoded(bytes)?;
            stamped(message, &applied.header)?;
            let inlet = inbound::find(&applied.channel)
                .ok_or_else(|| format!("a command on {}, which is not known", applied.channel))?;
            if applied.accepted {
                inbound::decode(inlet, &applied.payload).map_err(|error| error.to_string())?;
            }
        }
        Ok(())
    }
}

fn decoded<M: Type>(bytes: &[u8]) -> Result<M, String> {
    decode(bytes).map_err(|error| error.to_string())
}

/// Whether the stamp in the header is the time of the log.
fn stamped(message: &Message, header: &Header) -> Result<(), String> {
    let stamp = &header.stamp;
    let nanoseconds = i128::from(stamp.sec) * 1_000_000_000 + i128::from(stamp.nanosec);
    match nanoseconds == i128::from(message.stamp) {
        true => Ok(()),
        false => Err("the stamp in its header is another".to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::CHECKS;
    use crate::wire::channels;

    #[test]
    fn every_channel_has_a_check() {
        for channel in channels::ALL {
            let name = channel.message.name;
            assert!(CHECKS.iter().any(|(known, _)| *known == name), "{name}");
        }
    }
}
