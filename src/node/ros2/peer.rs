//! A participant for the command line: sends one message to a run, or reads one of its topics.

use std::time::{Duration, Instant};

use super::dds::{Participant, Reader};
use super::discovery::{topic, type_name};
use super::service::ServiceClient;
use super::{Ros2Error, Settings};
use crate::wire::channels::{self, Channel, Qos};
use crate::wire::inbound::Inlet;
use crate::wire::messages::toile_msgs::AppliedCommand;
use crate::wire::{MessageType, cdr};

/// How often it is looked whether somebody is there.
const LOOK: Duration = Duration::from_millis(10);
/// The bridge learns of a new reader a moment later than the reader of it.
const SETTLE: Duration = Duration::from_millis(300);

/// A node of its own beside the bridge's, on the same domain.
pub struct Peer {
    participant: Participant,
    settings: Settings,
}

impl Peer {
    /// Joins the domain of the settings; topics are those of a bridge in the settings' namespace.
    pub fn join(settings: Settings) -> Result<Self, Ros2Error> {
        let participant = Participant::join(&settings)?;
        Ok(Self {
            participant,
            settings,
        })
    }

    /// Sends an encoded message to an inlet as soon as a bridge is there and waits for what becomes of it: the
    /// answer of a service, an AppliedCommand for a topic, both in CDR. None if a command has arrived and it was
    /// not heard what became of it.
    pub fn send(
        &mut self,
        inlet: &Inlet,
        message: &[u8],
        timeout: Duration,
    ) -> Result<Option<Vec<u8>>, Ros2Error> {
        let until = Instant::now() + timeout;
        let sent = match inlet.response {
            None => self.publish(inlet, message, until)?,
            Some(response) => self.call(inlet, response, message, until)?.map(Some),
        };
        sent.ok_or_else(|| Ros2Error::Nobody {
            domain: self.settings.domain,
            name: self.settings.resolve(inlet.name),
            seconds: timeout.as_secs_f64(),
        })
    }

    /// Publishes a command once; the run says to all what became of it, which is found by its bytes. None if the
    /// command has not arrived.
    fn publish(
        &mut self,
        inlet: &Inlet,
        message: &[u8],
        until: Instant,
    ) -> Result<Option<Option<Vec<u8>>>, Ros2Error> {
        let name = topic(&self.settings.resolve(inlet.name));
        let kind = type_name(inlet.request.name);
        let mut applied = self.reader(&channels::APPLIED, channels::APPLIED.topic)?;
        let mut writer = self.participant.writer(&name, &kind, Qos::Reliable)?;
        self.participant.announce()?;
        let there = || writer.subscriptions() > 0 && applied.publishers() > 0;
        if !wait(until, there) {
            return Ok(None);
        }
        std::thread::sleep(SETTLE);
        if !writer.write(message) || !writer.acknowledged(left(until)) {
            return Ok(None);
        }
        let mut told = None;
        wait(until, || {
            while let Some(sample) = applied.take() {
                if speaks_of(&sample.bytes, inlet, message) {
                    told = Some(sample.bytes);
                }
            }
            told.is_some()
        });
        Ok(Some(told))
    }

    fn call(
        &mut self,
        inlet: &Inlet,
        response: &MessageType,
        request: &[u8],
        until: Instant,
    ) -> Result<Option<Vec<u8>>, Ros2Error> {
        let name = self.settings.resolve(inlet.name);
        let mapping = self.settings.services;
        let participant = &mut self.participant;
        let mut client = ServiceClient::new(participant, mapping, &name, inlet.request, response)?;
        participant.announce()?;
        if !wait(until, || client.connected()) {
            return Ok(None);
        }
        let sent = client.send(request);
        Ok(sent.and_then(|id| client.receive(&id, until)))
    }

    /// A reader of one of the run's topics, `name` being the channel's with an obstacle's name in place.
    pub fn subscribe(&mut self, channel: &Channel, name: &str) -> Result<Reader, Ros2Error> {
        let reader = self.reader(channel, name)?;
        self.participant.announce()?;
        Ok(reader)
    }

    fn reader(&mut self, channel: &Channel, name: &str) -> Result<Reader, Ros2Error> {
        let name = topic(&self.settings.resolve(name));
        let kind = type_name(channel.message.name);
        self.participant.reader(&name, &kind, channel.qos)
    }
}

/// Whether an AppliedCommand is about this message.
fn speaks_of(applied: &[u8], inlet: &Inlet, message: &[u8]) -> bool {
    let applied = cdr::decode::<AppliedCommand>(applied);
    applied.is_ok_and(|applied| applied.channel == inlet.name && applied.payload == message)
}

fn left(until: Instant) -> Duration {
    until.saturating_duration_since(Instant::now())
}

fn wait(until: Instant, mut there: impl FnMut() -> bool) -> bool {
    while !there() {
        if Instant::now() > until {
            return false;
        }
        std::thread::sleep(LOOK);
    }
    true
}
