//! What the world asks of a run: orders wait in a bounded queue until the loop takes them at a step boundary.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use crate::wire::inbound::Inlet;

/// Orders that may wait, unless told otherwise.
const CAPACITY: usize = 1024;

/// A message that came in, not looked at yet.
#[derive(Clone, Debug)]
pub struct Order {
    /// Where it came in.
    pub inlet: &'static Inlet,
    /// CDR with its encapsulation header, as it came.
    pub bytes: Vec<u8>,
    /// Who waits for an answer.
    pub reply: Option<Sender<Vec<u8>>>,
}

/// Why an order is not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unposted {
    /// The queue is full: the order is lost, and counted.
    #[error("the run has {capacity} orders waiting already; this one is dropped")]
    Full {
        /// Orders that may wait.
        capacity: usize,
    },
    /// The run is over.
    #[error("the run is over")]
    Over,
}

/// The sending end; clones feed the same queue.
#[derive(Clone, Debug)]
pub struct Mailbox {
    sender: SyncSender<Order>,
    dropped: Arc<AtomicU64>,
    /// Whether the run is over. Held while posting, so that every order is in the queue before that or not at all.
    over: Arc<Mutex<bool>>,
    capacity: usize,
}

impl Mailbox {
    /// Leaves an order and never waits for the run.
    pub fn post(&self, order: Order) -> Result<(), Unposted> {
        use std::sync::mpsc::TrySendError;
        let over = self.over.lock().unwrap_or_else(PoisonError::into_inner);
        if *over {
            return Err(Unposted::Over);
        }
        match self.sender.try_send(order) {
            Ok(()) => Ok(()),
            Err(TrySendError::Disconnected(_)) => Err(Unposted::Over),
            Err(TrySendError::Full(_)) => {
                self.dropped.fetch_add(1, Ordering::Relaxed);
                let capacity = self.capacity;
                Err(Unposted::Full { capacity })
            }
        }
    }
}

/// The receiving end, for the loop. Scripted orders come before those that were posted.
#[derive(Debug)]
pub struct Inbox {
    /// Orders with the step boundary at which they are due, in the order of the steps.
    script: VecDeque<(u64, Order)>,
    receiver: Receiver<Order>,
    dropped: Arc<AtomicU64>,
    over: Arc<Mutex<bool>>,
}

impl Inbox {
    /// A queue of so many orders, at least one.
    pub fn new(capacity: usize) -> (Mailbox, Inbox) {
        let capacity = capacity.max(1);
        let (sender, receiver) = sync_channel(capacity);
        let dropped = Arc::new(AtomicU64::new(0));
        let over = Arc::new(Mutex::new(false));
        let inbox = Inbox {
            script: VecDeque::new(),
            receiver,
            dropped: Arc::clone(&dropped),
            over: Arc::clone(&over),
        };
        let mailbox = Mailbox {
            sender,
            dropped,
            over,
            capacity,
        };
        (mailbox, inbox)
    }

    /// A queue of the usual size.
    pub fn with_mailbox() -> (Mailbox, Inbox) {
        Self::new(CAPACITY)
    }

    /// Adds orders that are due at set step boundaries: at step k when k steps have been taken.
    pub fn scripted(mut self, orders: impl IntoIterator<Item = (u64, Order)>) -> Self {
        self.script.extend(orders);
        self.script.make_contiguous().sort_by_key(|(step, _)| *step);
        self
    }

    /// The next order that is due at a boundary; does not wait.
    pub(super) fn take(&mut self, step: u64) -> Option<Order> {
        match self.script.front() {
            Some((due, _)) if *due <= step => self.script.pop_front().map(|(_, order)| order),
            _ => self.receiver.try_recv().ok(),
        }
    }

    /// Waits for an order, at most so long.
    pub(super) fn wait(&mut self, step: u64, longest: Duration) -> Waited {
        if let Some(order) = self.take(step) {
            return Waited::Order(order);
        }
        match self.receiver.recv_timeout(longest) {
            Ok(order) => Waited::Order(order),
            Err(RecvTimeoutError::Timeout) => Waited::Nothing,
            Err(RecvTimeoutError::Disconnected) => Waited::Nobody,
        }
    }

    /// Takes no more orders, and returns how many were waiting.
    pub(super) fn close(&mut self) -> u64 {
        *self.over.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.receiver.try_iter().count() as u64
    }

    /// Orders that were dropped because the queue was full.
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }
}

impl Default for Inbox {
    /// Nobody can post anything.
    fn default() -> Self {
        Self::new(1).1
    }
}

/// What waiting came to.
pub(super) enum Waited {
    /// An order.
    Order(Order),
    /// Nothing in that time.
    Nothing,
    /// All mailboxes are gone and nothing is scripted for this step: waiting is in vain.
    Nobody,
}
