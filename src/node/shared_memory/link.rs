//! One process's connection to iceoryx2, and how the services of a run are made and opened.

use std::fmt::Debug;
use std::fs;
use std::path::PathBuf;
use std::sync::Once;
use std::thread::sleep;
use std::time::{Duration, Instant};

use iceoryx2::node::NodeCreationFailure;
use iceoryx2::prelude::MessagingPattern::{Event, PublishSubscribe, RequestResponse};
use iceoryx2::prelude::*;
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenError;
use iceoryx2::service::port_factory::{event, publish_subscribe, request_response};

use super::header::{CallHeader, Header, ReplyHeader};
use super::names::service_name;
use super::sweep::{discard, sweep};
use super::{RunName, SharedMemoryError};

/// The same files as iceoryx2's `ipc`, with ports that may move between threads.
pub(super) type Ipc = ipc_threadsafe::Service;
pub(super) type Channel = publish_subscribe::PortFactory<Ipc, [u8], Header>;
pub(super) type Events = event::PortFactory<Ipc>;
pub(super) type Inlets = request_response::PortFactory<Ipc, [u8], CallHeader, [u8], ReplyHeader>;

/// Readers of one channel at a time.
pub(super) const SUBSCRIBERS: usize = 8;
/// Messages that a reader may hold at a time.
pub(super) const BORROWED: usize = 2;
/// Callers at a time, and requests of each that may wait.
const CLIENTS: usize = 12;
const REQUESTS: usize = 8;
/// Processes that may look at one service.
const NODES: usize = 36;

/// A service that another process is just making or removing is tried again at this interval, for so long.
const INTERVAL: Duration = Duration::from_millis(20);
const PATIENCE: Duration = Duration::from_secs(5);
/// How long a single attempt waits for another process, instead of iceoryx2's second.
const ATTEMPT: Duration = Duration::from_millis(200);
/// Until a run has its name, another one could be making the service by which it is claimed.
const CLAIMING: Duration = Duration::from_secs(2);

/// A node of iceoryx2, through which all services of a run are reached.
#[derive(Debug)]
pub(super) struct Link {
    node: Node<Ipc>,
    pub run: RunName,
}

impl Link {
    /// Joins; what dead processes left behind is removed on the way.
    pub fn new(run: RunName) -> Result<Self, SharedMemoryError> {
        static QUIET: Once = Once::new();
        // iceoryx2 would write to standard error, which belongs to the command line; errors come back typed.
        QUIET.call_once(|| set_log_level_from_env_or(LogLevel::Fatal));
        let mut config = Config::global_config().clone();
        config.global.creation_timeout = ATTEMPT;
        sweep(&config);
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Ipc>()
            .map_err(|error| refusal(&config, error))?;
        Ok(Self { node, run })
    }

    /// Removes what dead processes left behind.
    pub fn clean(&self) {
        self.node.blocking_cleanup_dead_nodes(10 * INTERVAL);
    }

    /// Makes the service of a topic whose readers may lag by `depth` messages; opens it if there are readers
    /// left of an earlier run, and says whether it was made.
    pub fn make_channel(
        &self,
        topic: &str,
        depth: usize,
    ) -> Result<(Channel, bool), SharedMemoryError> {
        let builder = |service: &ServiceName| {
            self.node
                .service_builder(service)
                .publish_subscribe::<[u8]>()
                .user_header::<Header>()
                .enable_safe_overflow(true)
                .history_size(1)
        };
        let attempt = |service: &ServiceName| match builder(service).open() {
            Ok(channel) => Ok((channel, false)),
            Err(PublishSubscribeOpenError::DoesNotExist) => {
                let made = builder(service)
                    .subscriber_max_buffer_size(depth)
                    .subscriber_max_borrowed_samples(BORROWED)
                    .max_subscribers(SUBSCRIBERS)
                    // One, and one that died and is not yet cleaned up.
                    .max_publishers(2)
                    .max_nodes(NODES)
                    .create();
                Ok((made.map_err(|error| format!("{error:?}"))?, true))
            }
            Err(error) => Err(format!("{error:?}")),
        };
        let name = self.run.channel(topic);
        self.persist(&name, PublishSubscribe, Duration::ZERO, attempt)
    }

    /// Opens the service of a topic; none if nobody publishes it at present.
    pub fn open_channel(&self, topic: &str) -> Result<Option<Channel>, SharedMemoryError> {
        let name = self.run.channel(topic);
        let service = service_name(&name)?;
        let builder = self.node.service_builder(&service);
        let builder = builder.publish_subscribe::<[u8]>();
        found(&name, builder.user_header::<Header>().open())
    }

    /// Makes or opens an event service of the run.
    pub fn make_event(&self, name: &str) -> Result<Events, SharedMemoryError> {
        self.persist(name, Event, Duration::ZERO, |service| {
            self.node
                .service_builder(service)
                .event()
                .max_listeners(NODES)
                .max_notifiers(NODES)
                .max_nodes(NODES)
                .open_or_create()
        })
    }

    /// Opens an event service; none if the run is not there.
    pub fn open_event(&self, name: &str) -> Result<Option<Events>, SharedMemoryError> {
        let service = service_name(name)?;
        found(name, self.node.service_builder(&service).event().open())
    }

    /// Makes or opens the service of all inlets.
    pub fn make_inlets(&self) -> Result<Inlets, SharedMemoryError> {
        let name = self.run.inlets();
        self.persist(&name, RequestResponse, CLAIMING, |service| {
            self.node
                .service_builder(service)
                .request_response::<[u8], [u8]>()
                .request_user_header::<CallHeader>()
                .response_user_header::<ReplyHeader>()
                // A full buffer is the caller's to know: nothing that was sent is lost on the way.
                .enable_safe_overflow_for_requests(false)
                .enable_safe_overflow_for_responses(false)
                .max_active_requests_per_client(REQUESTS)
                .max_response_buffer_size(1)
                .max_borrowed_responses_per_pending_response(1)
                .max_loaned_requests(1)
                .max_servers(1)
                .max_clients(CLIENTS)
                .max_nodes(NODES)
                .open_or_create()
        })
    }

    /// Tries until it works, or fails for a reason that will not pass. What a killed process left half made,
    /// `age` ago or longer, is discarded.
    fn persist<T, E: Debug>(
        &self,
        name: &str,
        pattern: MessagingPattern,
        age: Duration,
        mut attempt: impl FnMut(&ServiceName) -> Result<T, E>,
    ) -> Result<T, SharedMemoryError> {
        let service = service_name(name)?;
        let begun = Instant::now();
        loop {
            match attempt(&service) {
                Ok(done) => return Ok(done),
                Err(error) if passes(&error) && begun.elapsed() < PATIENCE => {
                    discard(self.node.config(), &service, pattern, age);
                    sleep(INTERVAL);
                }
                Err(error) => return Err(SharedMemoryError::transport("create", name)(error)),
            }
        }
    }

    /// Opens the service of all inlets; none if the run is not there.
    pub fn open_inlets(&self) -> Result<Option<Inlets>, SharedMemoryError> {
        let name = self.run.inlets();
        let service = service_name(&name)?;
        let builder = self.node.service_builder(&service);
        let opened = builder
            .request_response::<[u8], [u8]>()
            .request_user_header::<CallHeader>()
            .response_user_header::<ReplyHeader>()
            .open();
        found(&name, opened)
    }
}

/// Why iceoryx2 cannot be joined; most often, since another user was here first.
fn refusal(config: &Config, error: NodeCreationFailure) -> SharedMemoryError {
    let folder = PathBuf::from(config.global.root_path().to_string());
    match fs::read_dir(&folder) {
        Err(source) if folder.exists() => SharedMemoryError::Folder { folder, source },
        _ => SharedMemoryError::transport("join", "iceoryx2")(error),
    }
}

/// A service that was opened; none if it is not there, or just being made or removed.
fn found<T, E: Debug>(name: &str, opened: Result<T, E>) -> Result<Option<T>, SharedMemoryError> {
    match opened {
        Ok(service) => Ok(Some(service)),
        Err(error) if passes(&error) => Ok(None),
        Err(error) => Err(SharedMemoryError::transport("open", name)(error)),
    }
}

/// Whether an error passes by itself. iceoryx2 has a family of errors for each kind of service, with the same
/// names in all of them.
fn passes(error: &impl Debug) -> bool {
    const PASSING: [&str; 7] = [
        "AlreadyExists",
        "DoesNotExist",
        "HangsInCreation",
        "IsBeingCreatedByAnotherInstance",
        "IsMarkedForDestruction",
        "ServiceInCorruptedState",
        "SystemInFlux",
    ];
    let error = format!("{error:?}");
    PASSING.iter().any(|name| error.contains(name))
}
