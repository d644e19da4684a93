//! A participant for the command line: sends one message to a run, or reads one of its topics.

use std::time::{Duration, Instant};

use super::dds::{Participant, Reader};
use super::discovery::{topic, type_name};
use super::service::ServiceClient;
use super::{Ros2Error, Settings};
use crate::wire::channels::{Channel, Qos};
use crate::wire::inbound::Inlet;

/// How often it is looked whether somebody is there.
const LOOK: Duration = Duration::from_millis(10);

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

    /// Sends an encoded message to an inlet as soon as a bridge is there. A service's answer comes back; a topic
    /// has none, and the message has been acknowledged by the bridge.
    pub fn send(
        &mut self,
        inlet: &Inlet,
        message: &[u8],
        timeout: Duration,
    ) -> Result<Option<Vec<u8>>, Ros2Error> {
        let until = Instant::now() + timeout;
        let sent = match inlet.response {
            None => self.publish(inlet, message, until)?.map(|()| None),
            Some(_) => self.call(inlet, message, until)?.map(Some),
        };
        sent.ok_or_else(|| Ros2Error::Nobody {
            domain: self.settings.domain,
            name: self.settings.resolve(inlet.name),
            seconds: timeout.as_secs_f64(),
        })
    }

    fn publish(
        &mut self,
        inlet: &Inlet,
        message: &[u8],
        until: Instant,
    ) -> Result<Option<()>, Ros2Error> {
        let name = topic(&self.settings.resolve(inlet.name));
        let kind = type_name(inlet.request.name);
        let mut writer = self.participant.writer(&name, &kind, Qos::Reliable)?;
        self.participant.announce()?;
        let there = wait(until, || writer.subscriptions() > 0);
        let sent = there && writer.write(message) && writer.acknowledged(left(until));
        Ok(sent.then_some(()))
    }

    fn call(
        &mut self,
        inlet: &Inlet,
        request: &[u8],
        until: Instant,
    ) -> Result<Option<Vec<u8>>, Ros2Error> {
        let name = self.settings.resolve(inlet.name);
        let response = inlet.response.unwrap_or(inlet.request);
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
        let name = topic(&self.settings.resolve(name));
        let kind = type_name(channel.message.name);
        let reader = self.participant.reader(&name, &kind, channel.qos)?;
        self.participant.announce()?;
        Ok(reader)
    }
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
