//! What the bridge has carried and what it has lost: every message that came to it is in one of these numbers.

use std::ops::AddAssign;
use std::sync::atomic::{AtomicU64, Ordering};

use serde::{Deserialize, Serialize};

/// Counts of messages since the bridge started.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Traffic {
    /// From the run, written to DDS.
    pub published: u64,
    /// From the run, dropped because reliable subscribers do not keep up.
    pub unsent: u64,
    /// From the run, overwritten in shared memory before the bridge took them.
    pub missed: u64,
    /// From DDS, taken by the bridge.
    pub received: u64,
    /// From DDS, gaps in a writer's sequence: lost on the way or overwritten before the bridge took them.
    pub lost: u64,
    /// Received and dropped: more than the bridge lets wait, or longer than a command can be.
    pub dropped: u64,
    /// Received and handed to the run, which records what becomes of them.
    pub delivered: u64,
    /// Received and refused: the run is not there or has too many waiting.
    pub refused: u64,
    /// Responses sent to service clients.
    pub answered: u64,
}

impl AddAssign for Traffic {
    fn add_assign(&mut self, other: Self) {
        self.published += other.published;
        self.unsent += other.unsent;
        self.missed += other.missed;
        self.received += other.received;
        self.lost += other.lost;
        self.dropped += other.dropped;
        self.delivered += other.delivered;
        self.refused += other.refused;
        self.answered += other.answered;
    }
}

/// The same while threads count.
#[derive(Debug, Default)]
pub(super) struct Counters {
    pub published: AtomicU64,
    pub unsent: AtomicU64,
    pub missed: AtomicU64,
    pub received: AtomicU64,
    pub lost: AtomicU64,
    pub dropped: AtomicU64,
    pub delivered: AtomicU64,
    pub refused: AtomicU64,
    pub answered: AtomicU64,
}

impl Counters {
    /// One more.
    pub fn add(counter: &AtomicU64) {
        counter.fetch_add(1, Ordering::Relaxed);
    }

    /// As they stand.
    pub fn traffic(&self) -> Traffic {
        let read = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        Traffic {
            published: read(&self.published),
            unsent: read(&self.unsent),
            missed: read(&self.missed),
            received: read(&self.received),
            lost: read(&self.lost),
            dropped: read(&self.dropped),
            delivered: read(&self.delivered),
            refused: read(&self.refused),
            answered: read(&self.answered),
        }
    }
}
