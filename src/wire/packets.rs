//! From model, state and report to encoded messages: each is encoded once, whoever carries it.

use std::borrow::Cow;

use super::cdr::{CdrError, encode};
use super::channels::{self, Channel};
use super::messages::{rosgraph_msgs::Clock, std_msgs::String as Text};
use super::{
    Counters, Message, cloud, keyframe, markers, nanoseconds, report, robot_description, stamp,
    topology, transforms,
};
use crate::contact::Obstacle;
use crate::sim::{Model, State, StepReport};

/// One encoded message on its way to every carrier.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Packet {
    /// Where it goes.
    pub channel: &'static Channel,
    /// Whose it is, on a channel with a topic per obstacle.
    pub obstacle: Option<String>,
    /// Simulated time since the start of the run \[ns\].
    pub stamp: u64,
    /// CDR with its encapsulation header.
    pub bytes: Vec<u8>,
}

impl Packet {
    /// The ROS 2 topic that it goes to.
    pub fn topic(&self) -> Cow<'static, str> {
        match &self.obstacle {
            None => Cow::Borrowed(self.channel.topic),
            Some(name) => Cow::Owned(self.channel.topic.replace(channels::OBSTACLE, name)),
        }
    }
}

pub(super) fn packet<M: Message>(
    channel: &'static Channel,
    time: f64,
    message: &M,
) -> Result<Packet, CdrError> {
    debug_assert_eq!(channel.message.name, M::TYPE.name);
    Ok(Packet {
        channel,
        obstacle: None,
        stamp: nanoseconds(time),
        bytes: encode(message)?,
    })
}

/// A packet on the topic that an obstacle has of a channel.
pub(super) fn packet_of<M: Message>(
    obstacle: &Obstacle,
    channel: &'static Channel,
    time: f64,
    message: &M,
) -> Result<Packet, CdrError> {
    Ok(Packet {
        obstacle: Some(obstacle.name.clone()),
        ..packet(channel, time, message)?
    })
}

/// The obstacles' shapes, to be said again when one is added or taken away.
pub fn description(obstacles: &[Obstacle], time: f64) -> Result<Packet, CdrError> {
    let urdf = Text {
        data: robot_description(obstacles),
    };
    packet(&channels::ROBOT_DESCRIPTION, time, &urdf)
}

/// The whole state, with its digest, at a simulated time \[s\].
pub fn kept(state: &State, digest: u64, time: f64) -> Result<Packet, CdrError> {
    packet(
        &channels::KEYFRAME,
        time,
        &keyframe::keyframe(state, digest, time),
    )
}

/// What is said once, before the first state: mesh and shapes.
pub fn preamble(model: &Model, obstacles: &[Obstacle]) -> Result<Vec<Packet>, CdrError> {
    Ok(vec![
        packet(&channels::TOPOLOGY, 0.0, &topology(&model.mesh))?,
        description(obstacles, 0.0)?,
    ])
}

/// What is said of a state beside the state itself.
#[derive(Clone, Debug, Default)]
pub struct Extras {
    /// Whether the surface is to be drawn.
    pub with_mesh: bool,
    /// What the node has counted.
    pub counters: Counters,
}

/// What is said of one state.
pub fn instant(
    model: &Model,
    state: &State,
    step: &StepReport,
    extras: &Extras,
) -> Result<Vec<Packet>, CdrError> {
    let time = step.time;
    let clock = Clock { clock: stamp(time) };
    let mut packets = vec![packet(&channels::CLOCK, time, &clock)?];
    if !state.obstacles.is_empty() {
        packets.push(packet(
            &channels::TF,
            time,
            &transforms(&state.obstacles, time),
        )?);
    }
    packets.push(packet(&channels::STATE, time, &cloud::encode(state, time))?);
    let said = report(model, step, &extras.counters);
    packets.push(packet(&channels::REPORT, time, &said)?);
    if extras.with_mesh {
        let surface = markers(&model.mesh, &state.positions, time);
        packets.push(packet(&channels::MESH, time, &surface)?);
    }
    Ok(packets)
}
