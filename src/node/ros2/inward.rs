//! From DDS into the run: readers of all inlets, and bounded queues between them and shared memory.
//!
//! Messages are not looked into. What exceeds a queue is dropped and counted, so that a flood costs this process
//! and the run a bounded amount of memory.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use ros2_client::dds::rustdds::mio1::{Events, Interest, Poll, Token};

use super::dds::{Participant, Reader, Sample, Writer};
use super::discovery::{topic, type_name};
use super::service::{self, RequestId};
use super::traffic::Counters;
use super::{Ros2Error, ServiceMapping, Settings};
use crate::node::NodeError;
use crate::node::shared_memory::{Client, MOST_BYTES, RunName};
use crate::wire::channels::Qos;
use crate::wire::inbound::{self, Inlet, InletKind, Outcome};

/// Messages that may wait for one worker.
const WAITING: usize = 256;
/// How often the readers are looked at when nothing wakes them, and the stop flag.
const LOOK: Duration = Duration::from_millis(50);
/// How long a command waits for room in the run's queue.
const PATIENCE: Duration = Duration::from_millis(100);
/// How long a service client's request waits for the run's answer.
const ANSWER: Duration = Duration::from_secs(60);
/// This service answers when all its steps are taken; others must not wait behind it.
const LONG: &str = "/toile/step_simulation";

/// A message on its way to the run.
struct Job {
    inlet: &'static Inlet,
    bytes: Vec<u8>,
    /// Which request it is, if somebody waits for an answer.
    request: Option<RequestId>,
}

/// An inlet's reader and the queue behind it.
struct Door {
    inlet: &'static Inlet,
    reader: Reader,
    queue: SyncSender<Job>,
}

/// The threads behind the readers.
pub struct Inward(Vec<JoinHandle<()>>);

impl Inward {
    /// Waits until what was taken before the stop has been carried and answered, and no longer than this.
    pub fn finish(self, patience: Duration) {
        let asked = Instant::now();
        while !self.0.iter().all(JoinHandle::is_finished) && asked.elapsed() < patience {
            thread::sleep(Duration::from_millis(5));
        }
    }
}

/// Makes the readers of all inlets and starts the threads that carry their messages to the run, until `stop`.
pub fn start(
    run: &RunName,
    participant: &mut Participant,
    settings: &Settings,
    counters: &Arc<Counters>,
    stop: &Arc<AtomicBool>,
) -> Result<Inward, NodeError> {
    let mut threads = vec![];
    let (commands, steps, requests) = (queue(), queue(), queue());
    let (mut step_writers, mut request_writers) = (BTreeMap::new(), BTreeMap::new());
    let mut doors = vec![];
    for &inlet in inbound::ALL {
        let name = settings.resolve(inlet.name);
        let (reader, queue) = match (inlet.kind, inlet.response) {
            (InletKind::Service, Some(response)) => {
                let (reader, writer) =
                    service::server(participant, &name, inlet.request, response)?;
                let (queue, writers) = match inlet.name == LONG {
                    true => (&steps.0, &mut step_writers),
                    false => (&requests.0, &mut request_writers),
                };
                writers.insert(inlet.name, writer);
                (reader, queue)
            }
            _ => {
                let kind = type_name(inlet.request.name);
                let reader = participant.reader(&topic(&name), &kind, Qos::Reliable)?;
                (reader, &commands.0)
            }
        };
        doors.push(Door {
            inlet,
            reader,
            queue: queue.clone(),
        });
    }
    for (name, jobs, writers) in [
        ("commands", commands.1, BTreeMap::new()),
        ("steps", steps.1, step_writers),
        ("requests", requests.1, request_writers),
    ] {
        let worker = Worker {
            client: Client::new(run.clone())?,
            writers,
            counters: Arc::clone(counters),
        };
        threads.push(spawn(name, settings.domain, move || worker.work(&jobs))?);
    }
    let poll = registered(&mut doors).map_err(super::dds::failure(settings.domain, "a poll"))?;
    let watch = Watch {
        doors,
        mapping: settings.services,
        counters: Arc::clone(counters),
    };
    let stop = Arc::clone(stop);
    threads.push(spawn("readers", settings.domain, move || {
        watch.watch(poll, &stop)
    })?);
    Ok(Inward(threads))
}

fn queue() -> (SyncSender<Job>, Receiver<Job>) {
    sync_channel(WAITING)
}

fn spawn(
    name: &str,
    domain: u16,
    work: impl FnOnce() + Send + 'static,
) -> Result<JoinHandle<()>, Ros2Error> {
    let thread = thread::Builder::new().name(name.to_string()).spawn(work);
    thread.map_err(super::dds::failure(domain, "a thread"))
}

/// A poll that wakes when any of the readers has something.
fn registered(doors: &mut [Door]) -> std::io::Result<Poll> {
    let poll = Poll::new()?;
    for (k, door) in doors.iter_mut().enumerate() {
        let source = door.reader.source();
        source.register(poll.registry(), Token(k), Interest::READABLE)?;
    }
    Ok(poll)
}

/// The thread that takes messages from the readers.
struct Watch {
    doors: Vec<Door>,
    mapping: ServiceMapping,
    counters: Arc<Counters>,
}

impl Watch {
    fn watch(mut self, mut poll: Poll, stop: &AtomicBool) {
        let mut events = Events::with_capacity(64);
        while !stop.load(Ordering::Relaxed) {
            if poll.poll(&mut events, Some(LOOK)).is_err() {
                // Interrupted by a signal, or worse; either way not to be tried in a hurry.
                thread::sleep(Duration::from_millis(1));
            }
            self.take_all();
        }
    }

    /// Empties all readers, in turns so that a flood on one does not starve the others.
    fn take_all(&mut self) {
        let mut more = true;
        while more {
            more = false;
            for door in &mut self.doors {
                if let Some(sample) = door.reader.take() {
                    more = true;
                    Counters::add(&self.counters.received);
                    if !door.pass(self.mapping, sample) {
                        Counters::add(&self.counters.dropped);
                    }
                }
            }
        }
        let lost = self.doors.iter().map(|door| door.reader.lost()).sum();
        self.counters.lost.store(lost, Ordering::Relaxed);
    }
}

impl Door {
    /// Puts a message into the queue; false if it has no place there.
    fn pass(&self, mapping: ServiceMapping, sample: Sample) -> bool {
        let (request, bytes) = match self.inlet.kind {
            InletKind::Topic => (None, sample.bytes),
            InletKind::Service => match service::open(mapping, sample) {
                Some((request, bytes)) => (Some(request), bytes),
                None => return false,
            },
        };
        let job = Job {
            inlet: self.inlet,
            bytes,
            request,
        };
        job.bytes.len() <= MOST_BYTES && self.queue.try_send(job).is_ok()
    }
}

/// The thread behind a queue.
struct Worker {
    client: Client,
    writers: BTreeMap<&'static str, Writer>,
    counters: Arc<Counters>,
}

impl Worker {
    /// Until the readers' thread ends.
    fn work(mut self, jobs: &Receiver<Job>) {
        for job in jobs {
            match &job.request {
                None => self.command(&job),
                Some(request) => self.request(&job, request),
            }
        }
    }

    /// Hands a command on; what became of it, the run says on `/toile/applied`.
    fn command(&mut self, job: &Job) {
        let posted = self.client.post(job.inlet.name, &job.bytes, PATIENCE);
        Counters::add(match posted {
            Ok(()) => &self.counters.delivered,
            Err(_) => &self.counters.refused,
        });
    }

    /// Hands a request on, waits for the answer and passes it back.
    fn request(&mut self, job: &Job, request: &RequestId) {
        let answer = match self.client.call(job.inlet.name, &job.bytes, ANSWER) {
            Ok(answer) => {
                Counters::add(&self.counters.delivered);
                Ok(answer)
            }
            Err(error) => {
                Counters::add(&self.counters.refused);
                inbound::answer(job.inlet, &Outcome::Failed(error.to_string()))
            }
        };
        let writer = self.writers.get(job.inlet.name);
        if let (Ok(answer), Some(writer)) = (answer, writer)
            && service::respond(writer, request, &answer)
        {
            Counters::add(&self.counters.answered);
        }
    }
}
