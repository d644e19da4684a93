//! The run's end: a carrier that publishes every channel, and serves the inlets.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::{self, PublisherCreateError};
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::{AllocationStrategy, BackpressureStrategy, PortFactory};

use super::header::Header;
use super::link::{BORROWED, Ipc, Link, SUBSCRIBERS};
use super::server::Server;
use super::{Desk, RunName, SharedMemoryError};
use crate::node::{Carrier, NodeError};
use crate::wire::Packet;
use crate::wire::channels::{Channel, Qos, Rate};

/// Memory of a channel's messages, as long as readers may lag by as many as they must \[bytes\].
const STATE_BYTES: usize = 32 << 20;
const OTHER_BYTES: usize = 8 << 20;
/// Messages by which a reader may lag at most.
const DEEPEST: usize = 256;
/// Messages that can be in use beyond those that wait: what readers hold, the latest one, the one being written.
const BEYOND: usize = SUBSCRIBERS * BORROWED + 4;
/// A channel that could not be made is tried again after so long.
const AGAIN: Duration = Duration::from_secs(1);

/// What a run has sent and been sent over shared memory.
#[derive(Debug, Default)]
pub struct Counts {
    /// Messages published.
    pub published: AtomicU64,
    /// Messages that could not be published; readers see the gap.
    pub dropped: AtomicU64,
    /// Requests received.
    pub received: AtomicU64,
    /// Requests among them that were refused before they reached the simulation.
    pub refused: AtomicU64,
    failure: Mutex<Option<String>>,
}

impl Counts {
    pub(super) fn add(counter: &AtomicU64) {
        counter.fetch_add(1, Ordering::Relaxed);
    }

    /// Published, dropped, received, refused, so far.
    pub fn all(&self) -> [u64; 4] {
        let counters = [
            &self.published,
            &self.dropped,
            &self.received,
            &self.refused,
        ];
        counters.map(|counter| counter.load(Ordering::Relaxed))
    }

    /// Why a channel could not be published, the last time that happened.
    pub fn failure(&self) -> Option<String> {
        let failure = self.failure.lock();
        failure.unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// Publishes each channel of a run as a service of its own and serves its inlets, until it is dropped.
///
/// Readers that are slow lose the oldest messages and see that they did; none can hold the run up.
#[derive(Debug)]
pub struct SharedMemory {
    // Declared before what it uses: its thread ends first.
    server: Server,
    ports: Arc<Ports>,
    published: Notifier<Ipc>,
}

impl SharedMemory {
    /// Claims the name; refused if another run has it. Requests go to the desk.
    pub fn open(run: RunName, desk: impl Desk + 'static) -> Result<Self, SharedMemoryError> {
        let ports = Arc::new(Ports {
            link: Link::new(run)?,
            open: Mutex::default(),
            counts: Arc::default(),
        });
        let server = Server::start(Arc::clone(&ports), Box::new(desk))?;
        let name = ports.link.run.published();
        let published = ports.link.make_event(&name)?.notifier_builder().create();
        let published = published.map_err(SharedMemoryError::transport("notify", &name))?;
        Ok(Self {
            server,
            ports,
            published,
        })
    }

    /// What has been sent and received; goes on counting.
    pub fn counts(&self) -> Arc<Counts> {
        Arc::clone(&self.ports.counts)
    }
}

impl Carrier for SharedMemory {
    /// What cannot be published is counted.
    fn publish(&mut self, packet: &Packet) -> Result<(), NodeError> {
        match self.ports.publish(packet) {
            true => Counts::add(&self.ports.counts.published),
            false => Counts::add(&self.ports.counts.dropped),
        }
        Ok(())
    }

    fn commit(&mut self) -> Result<(), NodeError> {
        // A listener whose buffer is full has been woken already.
        let _ = self.published.notify();
        Ok(())
    }

    fn close(&mut self) -> Result<(), NodeError> {
        self.server.stop();
        Ok(())
    }
}

/// The publishing ports, shared with the thread that looks after late joiners.
#[derive(Debug)]
pub(super) struct Ports {
    pub link: Link,
    pub counts: Arc<Counts>,
    open: Mutex<BTreeMap<String, Port>>,
}

type Publisher = publisher::Publisher<Ipc, [u8], Header>;

/// Of one topic.
#[derive(Debug)]
enum Port {
    Open(Publisher),
    /// It could not be made, at this time.
    Failed(Instant),
}

impl Ports {
    fn publish(&self, packet: &Packet) -> bool {
        let topic = packet.topic().into_owned();
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        let port = match open.entry(topic) {
            Entry::Occupied(port) => port.into_mut(),
            Entry::Vacant(place) => {
                let port = self.port(place.key(), packet);
                place.insert(port)
            }
        };
        if matches!(port, Port::Failed(at) if at.elapsed() > AGAIN) {
            *port = self.port(&packet.topic(), packet);
        }
        match port {
            Port::Open(publisher) => send(publisher, packet),
            Port::Failed(_) => false,
        }
    }

    /// Gives readers that have just joined the latest message of each channel.
    pub fn greet(&self) {
        let open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        for port in open.values() {
            if let Port::Open(publisher) = port {
                // What fails now is tried again a moment later, and with each message.
                let _ = publisher.update_connections();
            }
        }
    }

    /// A port for messages like this one.
    fn port(&self, topic: &str, packet: &Packet) -> Port {
        match self.publisher(topic, packet.channel, packet.bytes.len()) {
            Ok(publisher) => Port::Open(publisher),
            Err(error) => {
                let failure = self.counts.failure.lock();
                *failure.unwrap_or_else(PoisonError::into_inner) = Some(error.to_string());
                Port::Failed(Instant::now())
            }
        }
    }

    /// A publisher of messages of about this length \[bytes\], with fewer of them in a small shared memory.
    fn publisher(
        &self,
        topic: &str,
        channel: &Channel,
        bytes: usize,
    ) -> Result<Publisher, SharedMemoryError> {
        let mut depth = depth(channel, bytes);
        loop {
            let (service, made) = self.link.make_channel(topic, depth)?;
            // Its readers all lag behind the same messages: those that wait are the same for all.
            let messages = service.static_config().subscriber_max_buffer_size() + BEYOND;
            let publisher = service
                .publisher_builder()
                .initial_max_slice_len(bytes.max(1))
                .allocation_strategy(AllocationStrategy::PowerOfTwo)
                .override_sample_preallocation(move |_| messages)
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .max_loaned_samples(1)
                .create();
            match publisher {
                Ok(publisher) => return Ok(publisher),
                Err(PublisherCreateError::UnableToCreateDataSegment) if made && depth > 1 => {
                    depth /= 2;
                }
                Err(error) => {
                    let name = self.link.run.channel(topic);
                    return Err(SharedMemoryError::transport("publish", &name)(error));
                }
            }
        }
    }
}

/// Whether there was memory for it.
fn send(publisher: &Publisher, packet: &Packet) -> bool {
    let Ok(mut sample) = publisher.loan_slice_uninit(packet.bytes.len()) else {
        return false;
    };
    *sample.user_header_mut() = Header::new(packet);
    sample.write_from_slice(&packet.bytes).send().is_ok()
}

/// By how many messages a reader may lag.
fn depth(channel: &Channel, bytes: usize) -> usize {
    let (room, least) = match (channel.qos, channel.rate) {
        (Qos::Latched, _) => return 2,
        (Qos::Newest, Rate::Output) => (STATE_BYTES, 16),
        _ => (OTHER_BYTES, 4),
    };
    let fit = (room / bytes.max(1)).saturating_sub(BEYOND);
    fit.clamp(least, DEEPEST)
}
