//! The other end: any process that reads a run's channels and calls its inlets.

use std::sync::{Arc, Mutex, PoisonError};
use std::thread::sleep;
use std::time::{Duration, Instant};

use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::{AllocationStrategy, BackpressureStrategy, PortFactory};

use super::header::{ABI, CallHeader, Refusal, ReplyHeader};
use super::link::{Inlets, Ipc, Link};
use super::{MOST_BYTES, RunName, SharedMemoryError, Subscription};

/// How often an answer, or room for a request, is looked for: in the first moments, and then.
const SOON: Duration = Duration::from_micros(100);
const LATER: Duration = Duration::from_millis(1);
/// How often a run is looked for that is not there.
const ABSENT: Duration = Duration::from_millis(20);

type Port = client::Client<Ipc, [u8], CallHeader, [u8], ReplyHeader>;
type Pending = PendingResponse<Ipc, [u8], CallHeader, [u8], ReplyHeader>;

/// A reader and caller of one run, whether or not that is there yet. It may move between threads.
#[derive(Debug)]
pub struct Client {
    // Ports before the link that they use.
    caller: Option<Caller>,
    published: Mutex<Option<Arc<Listener<Ipc>>>>,
    link: Arc<Link>,
}

/// What requests go through.
#[derive(Debug)]
struct Caller {
    port: Port,
    bell: Notifier<Ipc>,
    inlets: Inlets,
}

impl Client {
    /// Joins the run of this name.
    pub fn new(run: RunName) -> Result<Self, SharedMemoryError> {
        Ok(Self {
            caller: None,
            published: Mutex::default(),
            link: Arc::new(Link::new(run)?),
        })
    }

    /// Reads a topic, such as `/toile/state`, from its latest message on.
    pub fn subscribe(&self, topic: &str) -> Subscription {
        // From now on nothing is published without waking whoever waits.
        self.published();
        Subscription::new(&self.link, topic)
    }

    /// Waits until the run has published something since the last wait or, the first time, since the first
    /// [`subscribe`](Self::subscribe); false if it has not in this time. While the run is not there, it only
    /// waits a moment.
    pub fn wait(&self, timeout: Duration) -> bool {
        let Some(published) = self.published() else {
            sleep(timeout.min(ABSENT));
            return false;
        };
        // An interrupted wait is a short one.
        let events = published.timed_wait(|_| {}, timeout);
        events.is_ok_and(|count| count > 0)
    }

    fn published(&self) -> Option<Arc<Listener<Ipc>>> {
        let mut listener = self
            .published
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if listener.is_none() {
            let events = self.link.open_event(&self.link.run.published()).ok()??;
            *listener = Some(Arc::new(events.listener_builder().create().ok()?));
        }
        listener.clone()
    }

    /// Sends a message to an inlet and waits for its answer, both in CDR.
    pub fn call(
        &mut self,
        inlet: &str,
        request: &[u8],
        timeout: Duration,
    ) -> Result<Vec<u8>, SharedMemoryError> {
        let begun = Instant::now();
        loop {
            let left = timeout.saturating_sub(begun.elapsed());
            let pending = self.deliver(inlet, request, left)?;
            let (status, bytes) = self.await_answer(inlet, &pending, begun, timeout)?;
            let refusal = match status {
                0 => return Ok(bytes),
                status => Refusal::ALL.into_iter().find(|r| r.status() == status),
            };
            let refusal = refusal.unwrap_or(Refusal::Version);
            // Full queues empty themselves at the next step.
            if refusal != Refusal::Busy || begun.elapsed() > timeout {
                return Err(refused(inlet, refusal));
            }
            sleep(LATER);
        }
    }

    /// Sends a message to an inlet and leaves the answer; waits at most so long for room.
    pub fn post(
        &mut self,
        inlet: &str,
        message: &[u8],
        timeout: Duration,
    ) -> Result<(), SharedMemoryError> {
        self.deliver(inlet, message, timeout).map(drop)
    }

    /// Sends a request, waiting at most so long for room.
    fn deliver(
        &mut self,
        inlet: &str,
        request: &[u8],
        timeout: Duration,
    ) -> Result<Pending, SharedMemoryError> {
        let header = CallHeader::new(inlet).ok_or_else(|| refused(inlet, Refusal::UnknownInlet))?;
        if request.len() > MOST_BYTES {
            return Err(refused(inlet, Refusal::TooLarge));
        }
        let begun = Instant::now();
        loop {
            let pending = self.caller()?.send(header, request);
            let pending = pending.map_err(|reason| self.failure()(reason))?;
            if pending.number_of_server_connections() > 0 {
                return Ok(pending);
            }
            if begun.elapsed() >= timeout {
                return Err(refused(inlet, Refusal::Busy));
            }
            drop(pending);
            sleep(SOON);
        }
    }

    /// Status and bytes of a response.
    fn await_answer(
        &self,
        inlet: &str,
        pending: &Pending,
        begun: Instant,
        timeout: Duration,
    ) -> Result<(u64, Vec<u8>), SharedMemoryError> {
        let sent = Instant::now();
        loop {
            // Asked first: what was sent before the run ended can still be received after.
            let connected = pending.is_connected();
            match pending.receive() {
                Ok(Some(response)) if response.user_header().abi == ABI => {
                    return Ok((response.user_header().status, response.payload().to_vec()));
                }
                Ok(Some(_)) => return Err(refused(inlet, Refusal::Version)),
                Ok(None) if !connected => return Err(refused(inlet, Refusal::NoAnswer)),
                Ok(None) => {}
                Err(error) => return Err(self.failure()(error.to_string())),
            }
            if begun.elapsed() > timeout {
                return Err(SharedMemoryError::TimedOut {
                    inlet: inlet.to_string(),
                    seconds: timeout.as_secs_f64(),
                });
            }
            sleep(if sent.elapsed() < 10 * LATER {
                SOON
            } else {
                LATER
            });
        }
    }

    /// The port through which requests go; made when the run is there.
    fn caller(&mut self) -> Result<&Caller, SharedMemoryError> {
        let no_run = || SharedMemoryError::NoRun {
            name: self.link.run.to_string(),
        };
        let caller = match self.caller.take() {
            Some(caller) => caller,
            None => Caller::new(&self.link)?.ok_or_else(no_run)?,
        };
        if caller.inlets.dynamic_config().number_of_servers() == 0 {
            return Err(no_run());
        }
        Ok(self.caller.insert(caller))
    }

    fn failure(&self) -> impl FnOnce(String) -> SharedMemoryError + use<> {
        let name = self.link.run.inlets();
        move |reason| SharedMemoryError::Transport {
            action: "call",
            service: name,
            reason,
        }
    }
}

impl Caller {
    /// None if the run is not there.
    fn new(link: &Link) -> Result<Option<Self>, SharedMemoryError> {
        let Some(inlets) = link.open_inlets()? else {
            return Ok(None);
        };
        let port = inlets
            .client_builder()
            .initial_max_slice_len(1024)
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create();
        let port = port.map_err(SharedMemoryError::transport("call", &link.run.inlets()))?;
        let name = link.run.called();
        let Some(called) = link.open_event(&name)? else {
            return Ok(None);
        };
        let bell = called.notifier_builder().create();
        let bell = bell.map_err(SharedMemoryError::transport("notify", &name))?;
        Ok(Some(Self { port, bell, inlets }))
    }

    fn send(&self, header: CallHeader, request: &[u8]) -> Result<Pending, String> {
        let loan = self.port.loan_slice_uninit(request.len());
        let mut loan = loan.map_err(|error| error.to_string())?;
        *loan.user_header_mut() = header;
        let sent = loan.write_from_slice(request).send();
        // A bell that nobody hears only makes the answer come a little later.
        let _ = self.bell.notify();
        sent.map_err(|error| error.to_string())
    }
}

fn refused(inlet: &str, refusal: Refusal) -> SharedMemoryError {
    SharedMemoryError::Refused {
        inlet: inlet.to_string(),
        refusal,
    }
}
