//! The other end: any process that reads a run's channels and calls its inlets.

use std::sync::Arc;
use std::thread::sleep;
use std::time::{Duration, Instant};

use iceoryx2::identifiers::UniquePublisherId;
use iceoryx2::port::client::Client as Port;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::subscriber::{Subscriber, SubscriberCreateError};
use iceoryx2::prelude::{AllocationStrategy, BackpressureStrategy, PortFactory};
use iceoryx2::sample::Sample;

use super::header::{ABI, CallHeader, Header, Refusal, ReplyHeader};
use super::link::{Inlets, Ipc, Link};
use super::{MOST_BYTES, RunName, SharedMemoryError};

/// How often a run is looked for that is not there.
const SEARCH: Duration = Duration::from_millis(20);
/// How often an answer is looked for: in the first moments, and then.
const SOON: Duration = Duration::from_micros(100);
const LATER: Duration = Duration::from_millis(1);

/// A reader and caller of one run, whether or not that is there yet. It may move between threads.
#[derive(Debug)]
pub struct Client {
    // Ports before the link that they use.
    caller: Option<Caller>,
    published: Listener<Ipc>,
    bell: Notifier<Ipc>,
    link: Arc<Link>,
}

#[derive(Debug)]
struct Caller {
    port: Port<Ipc, [u8], CallHeader, [u8], ReplyHeader>,
    inlets: Inlets,
}

impl Client {
    /// Joins the run of this name.
    pub fn new(run: RunName) -> Result<Self, SharedMemoryError> {
        let link = Link::new(run)?;
        let name = link.run.published();
        let published = link.event(&name)?.listener_builder().create();
        let published = published.map_err(SharedMemoryError::transport("listen to", &name))?;
        let name = link.run.called();
        let bell = link.event(&name)?.notifier_builder().create();
        let bell = bell.map_err(SharedMemoryError::transport("notify", &name))?;
        Ok(Self {
            caller: None,
            published,
            bell,
            link: Arc::new(link),
        })
    }

    /// Reads a topic, such as `/toile/state`, from its latest message on.
    pub fn subscribe(&self, topic: &str) -> Subscription {
        Subscription {
            port: None,
            link: Arc::clone(&self.link),
            topic: topic.to_string(),
            searched: None,
            last: None,
            missed: 0,
        }
    }

    /// Waits until the run has published something since the last wait; false if it has not in this time.
    pub fn wait(&self, timeout: Duration) -> bool {
        let events = self.published.timed_wait(|_| {}, timeout);
        match events {
            Ok(count) => count > 0,
            // An interrupted wait is a short one.
            Err(_) => false,
        }
    }

    /// Sends a message to an inlet and waits for its answer, both in CDR.
    pub fn call(
        &mut self,
        inlet: &str,
        request: &[u8],
        timeout: Duration,
    ) -> Result<Vec<u8>, SharedMemoryError> {
        let refused = |refusal| SharedMemoryError::Refused {
            inlet: inlet.to_string(),
            refusal,
        };
        let header = CallHeader::new(inlet).ok_or_else(|| refused(Refusal::UnknownInlet))?;
        if request.len() > MOST_BYTES {
            return Err(refused(Refusal::TooLarge));
        }
        let until = Instant::now() + timeout;
        loop {
            match self.exchange(inlet, header, request, until)? {
                (0, bytes) => return Ok(bytes),
                (status, _) => {
                    let refusal = Refusal::ALL.into_iter().find(|r| r.status() == status);
                    let refusal = refusal.unwrap_or(Refusal::Version);
                    // Full queues empty themselves at the next step.
                    if refusal != Refusal::Busy || Instant::now() + LATER > until {
                        return Err(refused(refusal));
                    }
                    sleep(LATER);
                }
            }
        }
    }

    /// One request and its response: status and bytes.
    fn exchange(
        &mut self,
        inlet: &str,
        header: CallHeader,
        request: &[u8],
        until: Instant,
    ) -> Result<(u64, Vec<u8>), SharedMemoryError> {
        let name = self.link.run.inlets();
        let fail = |action| SharedMemoryError::transport::<String>(action, &name);
        let begun = Instant::now();
        let port = &self.caller()?.port;
        let mut loan = port
            .loan_slice_uninit(request.len())
            .map_err(|error| fail("call")(error.to_string()))?;
        *loan.user_header_mut() = header;
        let pending = loan
            .write_from_slice(request)
            .send()
            .map_err(|error| fail("call")(error.to_string()))?;
        if pending.number_of_server_connections() == 0 {
            return Ok((Refusal::Busy.status(), vec![]));
        }
        // A bell that nobody hears only makes the answer come a little later.
        let _ = self.bell.notify();
        loop {
            // Asked first: what was sent before the server left can still be received after.
            let connected = pending.is_connected();
            match pending.receive() {
                Ok(Some(response)) if response.user_header().abi == ABI => {
                    return Ok((response.user_header().status, response.payload().to_vec()));
                }
                Ok(Some(_)) => return Ok((Refusal::Version.status(), vec![])),
                Ok(None) if !connected => return Ok((Refusal::NoAnswer.status(), vec![])),
                Ok(None) => {}
                Err(error) => return Err(fail("call")(error.to_string())),
            }
            let now = Instant::now();
            if now > until {
                return Err(SharedMemoryError::TimedOut {
                    inlet: inlet.to_string(),
                    seconds: (now - begun).as_secs_f64(),
                });
            }
            sleep(if now - begun < 10 * LATER {
                SOON
            } else {
                LATER
            });
        }
    }

    /// The port through which requests go; made when the run is there, made again when it comes back.
    fn caller(&mut self) -> Result<&Caller, SharedMemoryError> {
        let no_run = || SharedMemoryError::NoRun {
            name: self.link.run.to_string(),
        };
        if self.caller.is_none() {
            let inlets = self.link.open_inlets()?.ok_or_else(no_run)?;
            let port = inlets
                .client_builder()
                .initial_max_slice_len(1024)
                .allocation_strategy(AllocationStrategy::PowerOfTwo)
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .create();
            let name = self.link.run.inlets();
            let port = port.map_err(SharedMemoryError::transport("call", &name))?;
            self.caller = Some(Caller { port, inlets });
        }
        let caller = self.caller.as_ref().ok_or_else(no_run)?;
        match caller.inlets.dynamic_config().number_of_servers() {
            0 => Err(no_run()),
            _ => Ok(caller),
        }
    }
}

/// What one reader has of one topic.
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
    /// Its topic.
    pub fn topic(&self) -> &str {
        &self.topic
    }

    /// Messages lost so far, since the reader was slow.
    pub fn missed(&self) -> u64 {
        self.missed
    }

    /// Whether the topic's service is there and joined.
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
            Err(iceoryx2::port::ReceiveError::ExceedsMaxBorrows) => {
                let name = self.link.run.channel(&self.topic);
                Err(SharedMemoryError::transport("read", &name)(
                    "too many messages are held",
                ))
            }
            // The publisher went while we joined it: look again.
            Err(_) => {
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
        match service.subscriber_builder().create() {
            Ok(port) => self.port = Some(port),
            Err(SubscriberCreateError::ExceedsMaxSupportedSubscribers) => {
                self.link.clean();
                let name = self.link.run.channel(&self.topic);
                return Err(SharedMemoryError::transport("read", &name)(
                    "it has as many readers as it can have",
                ));
            }
            Err(error) => {
                let name = self.link.run.channel(&self.topic);
                return Err(SharedMemoryError::transport("read", &name)(error));
            }
        }
        Ok(true)
    }
}
