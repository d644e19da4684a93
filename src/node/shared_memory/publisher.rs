//! The run's end: a carrier that publishes every channel, and serves the inlets.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::{Publisher, PublisherCreateError};
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::{AllocationStrategy, BackpressureStrategy};

use super::header::Header;
use super::link::{BORROWED, Ipc, Link, SUBSCRIBERS};
use super::server::Server;
use super::{Desk, RunName, SharedMemoryError};
use crate::node::{Carrier, NodeError};
use crate::wire::Packet;
use crate::wire::channels::{Channel, Qos, Rate};

/// Memory of a channel's messages, all readers together \[bytes\].
const STATE_BYTES: usize = 32 << 20;
const OTHER_BYTES: usize = 8 << 20;

/// What a run has sent and been sent over shared memory.
#[derive(Debug, Default)]
pub struct Counts {
    /// Messages published.
    pub published: AtomicU64,
    /// Messages that found no memory; their readers see the gap.
    pub dropped: AtomicU64,
    /// Requests received.
    pub received: AtomicU64,
    /// Requests among them that were refused before they reached the simulation.
    pub refused: AtomicU64,
}

impl Counts {
    pub(super) fn add(counter: &AtomicU64) {
        counter.fetch_add(1, Ordering::Relaxed);
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
        let published = ports.link.event(&name)?.notifier_builder().create();
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
    fn publish(&mut self, packet: &Packet) -> Result<(), NodeError> {
        Ok(self.ports.publish(packet)?)
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

#[derive(Debug)]
struct Port {
    publisher: Publisher<Ipc, [u8], Header>,
    /// Of the next message.
    sequence: u64,
}

impl Ports {
    fn publish(&self, packet: &Packet) -> Result<(), SharedMemoryError> {
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        let port = match open.entry(packet.topic().into_owned()) {
            Entry::Occupied(port) => port.into_mut(),
            Entry::Vacant(place) => {
                let port = self.port(place.key(), packet.channel, packet.bytes.len())?;
                place.insert(port)
            }
        };
        match port.send(packet) {
            true => Counts::add(&self.counts.published),
            false => Counts::add(&self.counts.dropped),
        }
        Ok(())
    }

    /// Gives readers that have just joined the latest message of each channel.
    pub fn greet(&self) {
        let open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        for port in open.values() {
            // What fails now is tried again a moment later, and with each message.
            let _ = port.publisher.update_connections();
        }
    }

    /// A port for messages of about this length \[bytes\]; with fewer of them in a small shared memory.
    fn port(
        &self,
        topic: &str,
        channel: &Channel,
        bytes: usize,
    ) -> Result<Port, SharedMemoryError> {
        let mut depth = depth(channel, bytes);
        loop {
            let (service, made) = self.link.make_channel(topic, depth)?;
            let publisher = service
                .publisher_builder()
                .initial_max_slice_len(bytes.max(1))
                .allocation_strategy(AllocationStrategy::PowerOfTwo)
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .max_loaned_samples(1)
                .create();
            match publisher {
                Ok(publisher) => {
                    return Ok(Port {
                        publisher,
                        sequence: 0,
                    });
                }
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

impl Port {
    /// Whether there was memory for it.
    fn send(&mut self, packet: &Packet) -> bool {
        let header = Header::new(packet, self.sequence);
        self.sequence += 1;
        let Ok(mut sample) = self.publisher.loan_slice_uninit(packet.bytes.len()) else {
            return false;
        };
        *sample.user_header_mut() = header;
        sample.write_from_slice(&packet.bytes).send().is_ok()
    }
}

/// By how many messages a reader may lag: iceoryx2 sets the memory for all possible readers aside at once.
fn depth(channel: &Channel, bytes: usize) -> usize {
    let (room, least) = match (channel.qos, channel.rate) {
        (Qos::Latched, _) => return 2,
        (Qos::Newest, Rate::Output) => (STATE_BYTES, 16),
        _ => (OTHER_BYTES, 4),
    };
    let each = room / (SUBSCRIBERS * bytes.max(1));
    each.saturating_sub(BORROWED).clamp(least, 64)
}
