//! Reading a topic: in order, with what was missed counted, across restarts of the run.

use std::sync::Arc;
use std::time::{Duration, Instant};

use iceoryx2::identifiers::UniquePublisherId;
use iceoryx2::port::ReceiveError;
use iceoryx2::port::subscriber::{Subscriber, SubscriberCreateError};
use iceoryx2::sample::Sample;

use super::SharedMemoryError;
use super::header::Header;
use super::link::{Ipc, Link};

/// How often a run is looked for that is not there.
const SEARCH: Duration = Duration::from_millis(20);

/// What one reader has of one topic. It may move between threads.
#[derive(Debug)]
pub struct Subscription {
    port: Option<Subscriber<Ipc, [u8], Header>>,
    link: Arc<Link>,
    topic: String,
    searched: Option<Instant>,
    last: Option<(UniquePublisherId, u64)>,
    missed: u64,
}

/// A message as it lies in shared memory. At most two of a topic may be held at a time.
#[derive(Debug)]
pub struct Received {
    sample: Sample<Ipc, [u8], Header>,
    /// Messages lost between the one before and this one, since the reader was slow.
    pub missed: u64,
    /// Whether it is the first of its run: of the first run seen, or of one started anew.
    pub first: bool,
}

impl Received {
    /// What is said of the message.
    pub fn header(&self) -> &Header {
        self.sample.user_header()
    }

    /// The message in CDR, encapsulation header included.
    pub fn bytes(&self) -> &[u8] {
        self.sample.payload()
    }
}

impl Subscription {
    pub(super) fn new(link: &Arc<Link>, topic: &str) -> Self {
        Self {
            port: None,
            link: Arc::clone(link),
            topic: topic.to_string(),
            searched: None,
            last: None,
            missed: 0,
        }
    }

    /// Its topic.
    pub fn topic(&self) -> &str {
        &self.topic
    }

    /// Messages lost so far, since the reader was slow.
    pub fn missed(&self) -> u64 {
        self.missed
    }

    /// Whether the topic has been found in shared memory.
    pub fn connected(&self) -> bool {
        self.port.is_some()
    }

    /// The next message, if there is one. Never waits; looks for the run if that is not there, and again if
    /// it went and came back.
    pub fn receive(&mut self) -> Result<Option<Received>, SharedMemoryError> {
        if self.port.is_none() && !self.connect()? {
            return Ok(None);
        }
        let Some(port) = &self.port else {
            return Ok(None);
        };
        match port.receive() {
            Ok(sample) => Ok(sample.map(|sample| self.count(sample))),
            Err(ReceiveError::ExceedsMaxBorrows) => {
                Err(self.failure()("two messages are held already"))
            }
            // The publisher went while we joined it: look again.
            Err(ReceiveError::ConnectionFailure(_)) => {
                self.port = None;
                Ok(None)
            }
        }
    }

    fn count(&mut self, sample: Sample<Ipc, [u8], Header>) -> Received {
        let (origin, sequence) = (sample.origin(), sample.user_header().sequence);
        let before = self.last.replace((origin, sequence));
        let before = before.filter(|(last, _)| *last == origin);
        let missed = before.map_or(0, |(_, last)| sequence.saturating_sub(last + 1));
        self.missed += missed;
        Received {
            sample,
            missed,
            first: before.is_none(),
        }
    }

    fn connect(&mut self) -> Result<bool, SharedMemoryError> {
        if self.searched.is_some_and(|at| at.elapsed() < SEARCH) {
            return Ok(false);
        }
        self.searched = Some(Instant::now());
        let Some(service) = self.link.open_channel(&self.topic)? else {
            return Ok(false);
        };
        let mut port = service.subscriber_builder().create();
        if let Err(SubscriberCreateError::ExceedsMaxSupportedSubscribers) = port {
            // Some of the others may be dead.
            self.link.clean();
            port = service.subscriber_builder().create();
        }
        self.port = Some(port.map_err(self.failure())?);
        Ok(true)
    }

    fn failure<E: std::fmt::Debug>(&self) -> impl FnOnce(E) -> SharedMemoryError + use<E> {
        let name = self.link.run.channel(&self.topic);
        move |error| SharedMemoryError::transport("read", &name)(error)
    }
}
