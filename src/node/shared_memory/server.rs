//! The thread behind the inlets: requests go to the desk, answers back to who asked.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::{JoinHandle, sleep};
use std::time::{Duration, Instant};

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::server;
use iceoryx2::prelude::{AllocationStrategy, BackpressureStrategy};
use iceoryx2::service::port_factory::server::ServerCreateError;

use super::header::{ABI, CallHeader, Refusal, ReplyHeader};
use super::link::Ipc;
use super::publisher::{Counts, Ports};
use super::{MOST_BYTES, SharedMemoryError};
use crate::node::{Mailbox, Order, Unposted};
use crate::wire::cdr;
use crate::wire::inbound::{self, InletKind};
use crate::wire::messages::toile_msgs::AppliedCommand;

/// Takes requests to the simulation.
pub trait Desk: Send {
    /// Hands one on; the answer goes into its `reply` when there is one. Never waits.
    fn take(&mut self, call: Call) -> Result<(), Refusal>;
}

impl<F: FnMut(Call) -> Result<(), Refusal> + Send> Desk for F {
    fn take(&mut self, call: Call) -> Result<(), Refusal> {
        self(call)
    }
}

impl Desk for Mailbox {
    fn take(&mut self, call: Call) -> Result<(), Refusal> {
        let inlet = inbound::find(&call.inlet).ok_or(Refusal::UnknownInlet)?;
        let order = Order {
            inlet,
            bytes: call.bytes,
            reply: Some(call.reply),
        };
        self.post(order).map_err(|unposted| match unposted {
            Unposted::Full { .. } => Refusal::Busy,
            Unposted::Over => Refusal::NoAnswer,
        })
    }
}

/// A request on its way to the simulation.
#[derive(Debug)]
pub struct Call {
    /// Name of the inlet, of whatever letters.
    pub inlet: String,
    /// The message, CDR if the caller is well-behaved.
    pub bytes: Vec<u8>,
    /// Where the answer goes, in CDR.
    pub reply: Sender<Vec<u8>>,
}

/// Requests taken in one go, before answers are looked after.
const BATCH: usize = 64;
/// How soon a request is seen whose caller does not ring the bell, and a late joiner greeted.
const IDLE: Duration = Duration::from_millis(10);
/// How soon an answer is passed on.
const WAITING: Duration = Duration::from_micros(500);
/// How long an answer is waited for: many steps of a large sheet take long, but not forever.
const PATIENCE: Duration = Duration::from_secs(3600);

/// Longest answer \[bytes\].
const MOST_ANSWER: usize = 8 << 10;

type Port = server::Server<Ipc, [u8], CallHeader, [u8], ReplyHeader>;
type Request = ActiveRequest<Ipc, [u8], CallHeader, [u8], ReplyHeader>;

/// The thread, and how to end it.
#[derive(Debug)]
pub(super) struct Server {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Claims the name of the run and starts the thread.
    pub fn start(ports: Arc<Ports>, desk: Box<dyn Desk>) -> Result<Self, SharedMemoryError> {
        let port = claim(&ports)?;
        let name = ports.link.run.called();
        let bell = ports.link.make_event(&name)?.listener_builder().create();
        let bell = bell.map_err(SharedMemoryError::transport("listen to", &name))?;
        let stop = Arc::new(AtomicBool::new(false));
        let mut office = Office {
            port,
            bell,
            desk,
            ports,
            open: vec![],
            busy: false,
        };
        let flag = Arc::clone(&stop);
        let thread = std::thread::Builder::new()
            .name("inlets".to_string())
            .spawn(move || {
                while !flag.load(Ordering::Relaxed) {
                    office.round();
                }
                office.finish();
            })
            .map_err(SharedMemoryError::transport("start a thread for", &name))?;
        Ok(Self {
            stop,
            thread: Some(thread),
        })
    }

    /// Ends the thread; requests without an answer are told so.
    pub fn stop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A panic there has been reported by its hook; the run is over either way.
            let _ = thread.join();
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop();
    }
}

/// The one server of the run's inlets: who has it has the name.
fn claim(ports: &Ports) -> Result<Port, SharedMemoryError> {
    let link = &ports.link;
    let name = link.run.inlets();
    let inlets = link.make_inlets()?;
    let build = || {
        inlets
            .server_builder()
            // Not to grow: memory for the answers to all callers would grow with the longest of them.
            .initial_max_slice_len(MOST_ANSWER)
            .allocation_strategy(AllocationStrategy::Static)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .max_loaned_responses_per_request(1)
            .create()
    };
    let mut port = build();
    // A process that died a moment ago may still be in the books.
    for _ in 0..5 {
        if !matches!(port, Err(ServerCreateError::ExceedsMaxSupportedServers)) {
            break;
        }
        link.clean();
        sleep(5 * IDLE);
        port = build();
    }
    port.map_err(|error| match error {
        ServerCreateError::ExceedsMaxSupportedServers => SharedMemoryError::NameTaken {
            name: link.run.to_string(),
        },
        error => SharedMemoryError::transport("serve", &name)(error),
    })
}

/// What the thread works with.
struct Office {
    port: Port,
    bell: Listener<Ipc>,
    desk: Box<dyn Desk>,
    ports: Arc<Ports>,
    open: Vec<Open>,
    /// Whether requests came in the last round.
    busy: bool,
}

/// A request that waits for its answer.
struct Open {
    request: Request,
    /// Whether the answer repeats the message, which its sender has.
    repeats: bool,
    answer: Receiver<Vec<u8>>,
    since: Instant,
}

impl Office {
    /// Waits a moment if nothing has come lately, takes what has come, passes answers on.
    fn round(&mut self) {
        if !self.busy {
            let pause = if self.open.is_empty() { IDLE } else { WAITING };
            if self.bell.timed_wait(|_| {}, pause).is_err() {
                sleep(pause);
            }
        }
        self.busy = false;
        for _ in 0..BATCH {
            // An error means that every caller with requests has as many open as it may have.
            let Ok(Some(request)) = self.port.receive() else {
                break;
            };
            self.busy = true;
            self.accept(request);
        }
        self.open.retain(|open| !open.settled());
        self.ports.greet();
    }

    fn accept(&mut self, request: Request) {
        let counts = &self.ports.counts;
        Counts::add(&counts.received);
        let (reply, answer) = channel();
        let call = read(&request, reply);
        let repeats = call.as_ref().is_ok_and(|call| is_topic(&call.inlet));
        match call.and_then(|call| self.desk.take(call)) {
            Ok(()) => self.open.push(Open {
                request,
                repeats,
                answer,
                since: Instant::now(),
            }),
            Err(refusal) => {
                Counts::add(&counts.refused);
                respond(&request, Err(refusal));
            }
        }
    }

    /// Whatever waits is told that no answer comes.
    fn finish(&mut self) {
        for open in self.open.drain(..).filter(|open| !open.settled()) {
            respond(&open.request, Err(Refusal::NoAnswer));
        }
    }
}

/// A request as it concerns the desk; its bytes are copied, since the caller could still write to them.
fn read(request: &Request, reply: Sender<Vec<u8>>) -> Result<Call, Refusal> {
    let header = *request.user_header();
    if header.abi != ABI {
        return Err(Refusal::Version);
    }
    let inlet = header.inlet().ok_or(Refusal::UnknownInlet)?.to_string();
    let bytes = request.payload();
    if bytes.len() > MOST_BYTES {
        return Err(Refusal::TooLarge);
    }
    Ok(Call {
        inlet,
        bytes: bytes.to_vec(),
        reply,
    })
}

impl Open {
    /// Whether it is done with: answered, overdue, or its caller gone.
    fn settled(&self) -> bool {
        match self.answer.try_recv() {
            Ok(bytes) if self.repeats => respond(&self.request, Ok(&without_payload(bytes))),
            Ok(bytes) => respond(&self.request, Ok(&bytes)),
            Err(TryRecvError::Disconnected) => respond(&self.request, Err(Refusal::NoAnswer)),
            Err(TryRecvError::Empty) if self.since.elapsed() > PATIENCE => {
                respond(&self.request, Err(Refusal::Late));
            }
            Err(TryRecvError::Empty) => return !self.request.is_connected(),
        }
        true
    }
}

fn is_topic(inlet: &str) -> bool {
    inbound::find(inlet).is_some_and(|inlet| inlet.kind == InletKind::Topic)
}

/// What became of a command, without the command, which may be long.
fn without_payload(bytes: Vec<u8>) -> Vec<u8> {
    let slim = cdr::decode::<AppliedCommand>(&bytes).and_then(|mut applied| {
        applied.payload.clear();
        cdr::encode(&applied)
    });
    slim.unwrap_or(bytes)
}

/// Answers; a caller that no longer waits does not mind that it fails.
fn respond(request: &Request, answer: Result<&[u8], Refusal>) {
    let reason;
    let (status, bytes) = match answer {
        Ok(bytes) if bytes.len() <= MOST_ANSWER => (0, bytes),
        Ok(_) => (Refusal::NoAnswer.status(), &[][..]),
        Err(refusal) => {
            reason = refusal.to_string();
            (refusal.status(), reason.as_bytes())
        }
    };
    if let Ok(mut response) = request.loan_slice_uninit(bytes.len()) {
        *response.user_header_mut() = ReplyHeader { abi: ABI, status };
        let _ = response.write_from_slice(bytes).send();
    }
}
