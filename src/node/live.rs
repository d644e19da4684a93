//! A carrier that may be slow, behind a queue and on a thread of its own: the run never waits for it.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use serde::Serialize;

use super::{Carrier, NodeError};
use crate::wire::Packet;
use crate::wire::channels::Qos;

/// Messages that may wait: a few instants with all their channels.
const CAPACITY: usize = 64;
/// How long the end of a run waits for what is still queued.
const PATIENCE: Duration = Duration::from_secs(2);

/// What a live carrier has done so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LiveTally {
    /// Name of the carrier.
    pub name: String,
    /// Messages that it took.
    pub carried: u64,
    /// Messages that were dropped: the queue was full, or the carrier had failed.
    pub dropped: u64,
    /// Why it takes no more, if it failed.
    pub failure: Option<String>,
}

/// Wraps any carrier so that publishing never blocks. When the queue is full the oldest state goes first; events
/// and what is said once go only when nothing else is left.
pub struct Live {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// Reads the tally of a [`Live`] that was given away.
#[derive(Clone)]
pub struct Gauge(Arc<Shared>);

impl Gauge {
    /// What it has done so far.
    pub fn tally(&self) -> LiveTally {
        self.0.lock().tally.clone()
    }

    /// Messages in the queue.
    pub fn waiting(&self) -> usize {
        self.0.lock().packets.len()
    }
}

struct Shared {
    queue: Mutex<Queue>,
    changed: Condvar,
    capacity: usize,
}

#[derive(Default)]
struct Queue {
    packets: VecDeque<Packet>,
    /// No more will come.
    closing: bool,
    /// The carrier is closed, or has failed.
    ended: bool,
    tally: LiveTally,
}

impl Queue {
    fn give_up(&mut self, failure: Option<String>) {
        self.ended = true;
        self.tally.dropped += self.packets.len() as u64;
        self.packets.clear();
        if self.tally.failure.is_none() {
            self.tally.failure = failure;
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next packet, and whether it ends what is known of its instant; nothing when all is over.
    fn next(&self) -> Option<(Packet, bool)> {
        let waiting = |q: &mut Queue| q.packets.is_empty() && !q.closing;
        let queue = self.changed.wait_while(self.lock(), waiting);
        let mut queue = queue.unwrap_or_else(PoisonError::into_inner);
        let packet = queue.packets.pop_front()?;
        let same = |next: &Packet| next.stamp == packet.stamp;
        let last = !queue.packets.front().is_some_and(same);
        Some((packet, last))
    }

    /// The carrier takes no more, for a reason if it failed.
    fn end(&self, failure: Option<String>) {
        let mut queue = self.lock();
        queue.give_up(failure);
        self.changed.notify_all();
    }
}

impl Live {
    /// Starts the thread, with a queue of the usual size.
    pub fn start(name: &str, carrier: Box<dyn Carrier>) -> Result<Self, NodeError> {
        Self::with_capacity(name, carrier, CAPACITY)
    }

    /// Starts the thread, with a queue of so many messages.
    pub fn with_capacity(
        name: &str,
        mut carrier: Box<dyn Carrier>,
        capacity: usize,
    ) -> Result<Self, NodeError> {
        let tally = LiveTally {
            name: name.to_string(),
            ..LiveTally::default()
        };
        let shared = Arc::new(Shared {
            queue: Mutex::new(Queue {
                tally,
                ..Queue::default()
            }),
            changed: Condvar::new(),
            capacity: capacity.max(1),
        });
        let theirs = Arc::clone(&shared);
        let thread = std::thread::Builder::new()
            .name(name.to_string())
            .spawn(move || {
                let served = catch_unwind(AssertUnwindSafe(|| serve(&theirs, carrier.as_mut())));
                theirs.end(match served {
                    Ok(served) => served.err().map(|error| error.to_string()),
                    Err(_) => Some("its thread panicked".to_string()),
                });
            })
            .map_err(NodeError::file("start", "a carrier's thread".as_ref()))?;
        Ok(Self {
            shared,
            thread: Some(thread),
        })
    }

    /// A handle on the counters.
    pub fn gauge(&self) -> Gauge {
        Gauge(Arc::clone(&self.shared))
    }
}

fn serve(shared: &Shared, carrier: &mut dyn Carrier) -> Result<(), NodeError> {
    while let Some((packet, last)) = shared.next() {
        carrier.publish(&packet)?;
        shared.lock().tally.carried += 1;
        if last {
            carrier.commit()?;
        }
    }
    carrier.close()
}

impl Carrier for Live {
    fn publish(&mut self, packet: &Packet) -> Result<(), NodeError> {
        let mut queue = self.shared.lock();
        if queue.ended {
            queue.tally.dropped += 1;
            return Ok(());
        }
        if queue.packets.len() >= self.shared.capacity {
            let victim = victim(&queue.packets);
            queue.packets.remove(victim);
            queue.tally.dropped += 1;
        }
        queue.packets.push_back(packet.clone());
        self.shared.changed.notify_one();
        Ok(())
    }

    fn commit(&mut self) -> Result<(), NodeError> {
        Ok(())
    }

    /// Waits a bounded time for what is queued; what a hanging carrier keeps then counts as dropped.
    fn close(&mut self) -> Result<(), NodeError> {
        let mut queue = self.shared.lock();
        queue.closing = true;
        self.shared.changed.notify_all();
        let open = |queue: &mut Queue| !queue.ended;
        let waited = self
            .shared
            .changed
            .wait_timeout_while(queue, PATIENCE, open);
        let (mut queue, timeout) = waited.unwrap_or_else(PoisonError::into_inner);
        if timeout.timed_out() {
            let hangs = format!("it did not end within {} s", PATIENCE.as_secs());
            queue.give_up(Some(hangs));
            return Ok(());
        }
        drop(queue);
        if let Some(thread) = self.thread.take() {
            // Whatever happened to it is in the tally.
            let _ = thread.join();
        }
        Ok(())
    }
}

impl Drop for Live {
    /// Not closed, since something else failed: the thread ends by itself.
    fn drop(&mut self) {
        self.shared.lock().closing = true;
        self.shared.changed.notify_all();
    }
}

/// Which one to drop: the oldest state, else the oldest event, else the oldest of all.
fn victim(packets: &VecDeque<Packet>) -> usize {
    let oldest = |of: &dyn Fn(Qos) -> bool| packets.iter().position(|p| of(p.channel.qos));
    oldest(&|qos| qos == Qos::Newest)
        .or_else(|| oldest(&|qos| qos != Qos::Latched))
        .unwrap_or(0)
}
