//! Encoded messages: each is encoded once, whoever carries it.

use std::borrow::Cow;

use super::cdr::{CdrError, encode};
use super::channels::{self, Channel};
use super::{Message, keyframe, nanoseconds};
use crate::contact::Obstacle;
use crate::sim::State;

/// One encoded message on its way to every carrier.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Packet {
    /// Where it goes.
    pub channel: &'static Channel,
    /// Whose it is, on a channel with a topic per obstacle.
    pub obstacle: Option<String>,
    /// Its number among the messages of its topic, from 0; the recorder counts.
    pub sequence: u64,
    /// Simulated time since the start of the run \[ns\].
    pub stamp: u64,
    /// Step of the state that it speaks of; 0 for what is said once.
    pub step: u64,
    /// Digest of that state; 0 for what is said once.
    pub digest: u64,
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
        sequence: 0,
        stamp: nanoseconds(time),
        step: 0,
        digest: 0,
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

/// The whole state, with its digest, at a simulated time \[s\].
pub fn kept(state: &State, digest: u64, time: f64) -> Result<Packet, CdrError> {
    let message = keyframe::keyframe(state, digest, time);
    packet(&channels::KEYFRAME, time, &message)
}
