//! A DDS participant that writes and reads encoded messages on ROS 2 topics.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::net::Ipv4Addr;
use std::time::Duration;

use ros2_client::dds::rustdds::mio1::event::Source;
use ros2_client::dds::rustdds::no_key::{DataWriter, SimpleDataReader};
use ros2_client::dds::rustdds::policy::{Durability, History, ResourceLimits};
use ros2_client::dds::rustdds::rpc::SampleIdentity;
use ros2_client::dds::rustdds::{
    self, DataReaderStatus, DataWriterStatus, DomainParticipant, DomainParticipantBuilder, GUID,
    QosPolicies, QosPolicyBuilder, RTPSEntity, StatusEvented, Timestamp, TopicKind,
    WriteOptionsBuilder,
};

use super::discovery::Announcement;
use super::raw::{Body, PassThrough, Raw};
use super::{Ros2Error, Settings};
use crate::wire::channels::Qos;

/// Samples that a reliable writer keeps for subscribers that have not acknowledged them; beyond it, it drops.
/// Small enough that a subscriber that was killed cannot fill the memory with surfaces.
const UNACKNOWLEDGED: i32 = 256;
/// States that a best-effort writer keeps until they are on their way. With one, two that come in quick succession
/// because a thread was held up are one.
const BURST: i32 = 8;
/// Commands that wait in a reader until they are taken.
const WAITING: i32 = 256;
/// Writers whose place in the sequence a reader remembers.
const KNOWN_WRITERS: usize = 256;

/// Quality of service of a writer. Reliable ones never wait for a subscriber: a full window drops.
fn offered(qos: Qos) -> QosPolicies {
    let limits = ResourceLimits {
        max_samples: UNACKNOWLEDGED,
        max_instances: 1,
        max_samples_per_instance: UNACKNOWLEDGED,
    };
    let at_once = rustdds::Duration::ZERO;
    let builder = QosPolicyBuilder::new().resource_limits(limits);
    let last = |depth| History::KeepLast { depth };
    match qos {
        Qos::Newest => builder
            .best_effort()
            .durability(Durability::Volatile)
            .history(last(BURST)),
        Qos::Reliable => builder
            .reliable(at_once)
            .durability(Durability::Volatile)
            .history(last(10)),
        Qos::Latched => builder
            .reliable(at_once)
            .durability(Durability::TransientLocal)
            .history(last(1)),
    }
    .build()
}

/// What a reader asks of writers: as much as the channel offers, and room for bursts.
fn requested(qos: Qos) -> QosPolicies {
    let builder = QosPolicyBuilder::new().history(History::KeepLast { depth: WAITING });
    let at_once = rustdds::Duration::ZERO;
    match qos {
        Qos::Newest => builder.best_effort().durability(Durability::Volatile),
        Qos::Reliable => builder.reliable(at_once).durability(Durability::Volatile),
        Qos::Latched => builder
            .reliable(at_once)
            .durability(Durability::TransientLocal),
    }
    .build()
}

/// One participant of a DDS domain, one node of the ROS 2 graph.
pub struct Participant {
    inner: DomainParticipant,
    publisher: rustdds::Publisher,
    subscriber: rustdds::Subscriber,
    announcement: Announcement,
    domain: u16,
}

impl Participant {
    /// Joins the domain, on the loopback alone unless the settings say otherwise.
    pub fn join(settings: &Settings) -> Result<Self, Ros2Error> {
        let domain = settings.domain;
        let builder = DomainParticipantBuilder::new(domain);
        let builder = match settings.lan {
            true => builder,
            false => builder.with_only_networks([Ipv4Addr::LOCALHOST]),
        };
        let inner = builder
            .build()
            .map_err(failure(domain, "the participant"))?;
        let publisher = inner
            .create_publisher(&QosPolicies::default())
            .map_err(failure(domain, "the publisher"))?;
        let subscriber = inner
            .create_subscriber(&QosPolicies::default())
            .map_err(failure(domain, "the subscriber"))?;
        let announcement = Announcement::new(&inner, &publisher, settings)?;
        Ok(Self {
            inner,
            publisher,
            subscriber,
            announcement,
            domain,
        })
    }

    /// A writer on a DDS topic.
    pub fn writer(&mut self, topic: &str, kind: &str, qos: Qos) -> Result<Writer, Ros2Error> {
        let qos = offered(qos);
        let made = self.topic(topic, kind, &qos)?;
        let inner = self
            .publisher
            .create_datawriter_no_key(&made, Some(qos))
            .map_err(failure(self.domain, topic))?;
        let writer = Writer { inner, matched: 0 };
        self.announcement.add_writer(writer.inner.guid());
        Ok(writer)
    }

    /// A reader on a DDS topic.
    pub fn reader(&mut self, topic: &str, kind: &str, qos: Qos) -> Result<Reader, Ros2Error> {
        let qos = requested(qos);
        let made = self.topic(topic, kind, &qos)?;
        let inner = self
            .subscriber
            .create_simple_datareader_no_key::<Raw, PassThrough>(&made, Some(qos))
            .map_err(failure(self.domain, topic))?;
        self.announcement.add_reader(inner.guid());
        Ok(Reader {
            inner,
            latest: BTreeMap::new(),
            lost: 0,
            matched: 0,
        })
    }

    fn topic(
        &self,
        name: &str,
        kind: &str,
        qos: &QosPolicies,
    ) -> Result<rustdds::Topic, Ros2Error> {
        self.inner
            .create_topic(name.to_string(), kind.to_string(), qos, TopicKind::NoKey)
            .map_err(failure(self.domain, name))
    }

    /// Tells the ROS 2 graph which topics belong to the node; after the last writer or reader.
    pub fn announce(&self) -> Result<(), Ros2Error> {
        self.announcement.publish()
    }
}

/// Binds what the library says to what was to be made.
pub(super) fn failure<E: Debug>(domain: u16, what: &str) -> impl FnOnce(E) -> Ros2Error + use<E> {
    let what = what.to_string();
    move |reason| Ros2Error::Create {
        domain,
        what,
        reason: format!("{reason:?}"),
    }
}

/// Writes messages on one topic.
pub struct Writer {
    inner: DataWriter<Body, PassThrough>,
    matched: i32,
}

impl Writer {
    /// Writes one encoded message; false if it was dropped, because subscribers do not keep up or because it is
    /// not little-endian CDR. Never waits.
    pub fn write(&self, message: &[u8]) -> bool {
        Body::of(message).is_some_and(|body| self.send(body, None))
    }

    /// Writes a message that answers a request.
    pub(super) fn send(&self, body: Body, related: Option<SampleIdentity>) -> bool {
        self.identified(body, related).is_some()
    }

    /// The same, and where in the writer's sequence the message stands.
    pub(super) fn identified(
        &self,
        body: Body,
        related: Option<SampleIdentity>,
    ) -> Option<SampleIdentity> {
        let options = WriteOptionsBuilder::new()
            .source_timestamp(Timestamp::now())
            .related_sample_identity_opt(related);
        self.inner.write_with_options(body, options.build()).ok()
    }

    /// Subscriptions that the writer is connected with.
    pub fn subscriptions(&mut self) -> usize {
        while let Some(status) = self.inner.try_recv_status() {
            if let DataWriterStatus::PublicationMatched { current, .. } = status {
                self.matched = current.count();
            }
        }
        usize::try_from(self.matched).unwrap_or(0)
    }

    /// Waits until all reliable subscribers have acknowledged everything; false if the time was too short.
    pub fn acknowledged(&self, within: Duration) -> bool {
        self.inner.wait_for_acknowledgments(within).unwrap_or(false)
    }

    /// The writer's identity in the domain.
    pub(super) fn guid(&self) -> GUID {
        self.inner.guid()
    }
}

/// A message that came in.
pub struct Sample {
    /// CDR with its encapsulation header, either byte order.
    pub bytes: Vec<u8>,
    /// Which writer wrote it, and where it stands in that writer's sequence.
    pub(super) identity: SampleIdentity,
    /// The request that it belongs to, where the writer says so beside the message.
    pub(super) related: Option<SampleIdentity>,
}

/// Reads messages of one topic.
pub struct Reader {
    inner: SimpleDataReader<Raw, PassThrough>,
    /// Sequence number of the latest message of each writer.
    latest: BTreeMap<GUID, i64>,
    lost: u64,
    matched: i32,
}

impl Reader {
    /// The next message, if there is one. What the library could not read as a message counts as lost.
    pub fn take(&mut self) -> Option<Sample> {
        self.inner.drain_read_notifications();
        loop {
            match self.inner.try_take_one() {
                Ok(Some(change)) => {
                    let identity = SampleIdentity {
                        writer_guid: change.writer_guid,
                        sequence_number: change.sequence_number,
                    };
                    self.count_gap(identity);
                    return Some(Sample {
                        identity,
                        related: change.related_sample_identity(),
                        bytes: change.into_value().0,
                    });
                }
                Ok(None) => return None,
                Err(_) => {}
            }
        }
    }

    /// Messages that were written and never arrived here: lost on the way, or overwritten before they were taken.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Publishers that the reader is connected with.
    pub fn publishers(&mut self) -> usize {
        while let Some(status) = self.inner.try_recv_status() {
            if let DataReaderStatus::SubscriptionMatched { current, .. } = status {
                self.matched = current.count();
            }
        }
        usize::try_from(self.matched).unwrap_or(0)
    }

    /// A gap in a writer's sequence is what was lost.
    fn count_gap(&mut self, identity: SampleIdentity) {
        let number = i64::from(identity.sequence_number);
        if self.latest.len() >= KNOWN_WRITERS && !self.latest.contains_key(&identity.writer_guid) {
            self.latest.clear();
        }
        if let Some(before) = self.latest.insert(identity.writer_guid, number) {
            let missing = number.saturating_sub(before).saturating_sub(1);
            self.lost = self
                .lost
                .saturating_add(u64::try_from(missing).unwrap_or(0));
        }
    }

    /// For polling: ready when there is something to take.
    pub(super) fn source(&mut self) -> &mut dyn Source {
        &mut self.inner
    }
}
