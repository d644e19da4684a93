//! One process's connection to iceoryx2, and how the services of a run are made and opened.

use std::sync::Once;
use std::thread::sleep;
use std::time::Duration;

use iceoryx2::prelude::*;
use iceoryx2::service::builder::event::EventOpenOrCreateError;
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeCreateError, PublishSubscribeOpenError,
};
use iceoryx2::service::builder::request_response::RequestResponseOpenError;
use iceoryx2::service::port_factory::{event, publish_subscribe, request_response};

use super::header::{CallHeader, Header, ReplyHeader};
use super::names::service_name;
use super::{RunName, SharedMemoryError};

/// The same files as iceoryx2's `ipc`, with ports that may move between threads.
pub(super) type Ipc = ipc_threadsafe::Service;
pub(super) type Channel = publish_subscribe::PortFactory<Ipc, [u8], Header>;
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

/// A service that is just being made or removed by another process is tried again so often, at this interval.
const TRIES: usize = 50;
const INTERVAL: Duration = Duration::from_millis(20);

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
        let node = NodeBuilder::new()
            .config(Config::global_config())
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Ipc>()
            .map_err(SharedMemoryError::transport("join", "iceoryx2"))?;
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
        let name = self.run.channel(topic);
        let service = service_name(&name)?;
        let builder = || {
            self.node
                .service_builder(&service)
                .publish_subscribe::<[u8]>()
                .user_header::<Header>()
                .enable_safe_overflow(true)
                .history_size(1)
        };
        for _ in 0..TRIES {
            let made = builder()
                .subscriber_max_buffer_size(depth)
                .subscriber_max_borrowed_samples(BORROWED)
                .max_subscribers(SUBSCRIBERS)
                // One, and one that died and is not yet cleaned up.
                .max_publishers(2)
                .max_nodes(NODES)
                .create();
            match made {
                Ok(channel) => return Ok((channel, true)),
                Err(PublishSubscribeCreateError::AlreadyExists) => match builder().open() {
                    Ok(channel) => return Ok((channel, false)),
                    Err(error) if !passing(&error) => {
                        return Err(SharedMemoryError::transport("open", &name)(error));
                    }
                    Err(_) => {}
                },
                Err(
                    PublishSubscribeCreateError::IsBeingCreatedByAnotherInstance
                    | PublishSubscribeCreateError::HangsInCreation
                    | PublishSubscribeCreateError::ServiceInCorruptedState,
                ) => {}
                Err(error) => return Err(SharedMemoryError::transport("create", &name)(error)),
            }
            sleep(INTERVAL);
        }
        Err(SharedMemoryError::transport("create", &name)(
            "another process holds it half made",
        ))
    }

    /// Opens the service of a topic; none if nobody publishes it at present.
    pub fn open_channel(&self, topic: &str) -> Result<Option<Channel>, SharedMemoryError> {
        let name = self.run.channel(topic);
        let opened = self
            .node
            .service_builder(&service_name(&name)?)
            .publish_subscribe::<[u8]>()
            .user_header::<Header>()
            .open();
        match opened {
            Ok(channel) => Ok(Some(channel)),
            Err(error) if passing(&error) => Ok(None),
            Err(error) => Err(SharedMemoryError::transport("open", &name)(error)),
        }
    }

    /// Makes or opens an event service.
    pub fn event(&self, name: &str) -> Result<event::PortFactory<Ipc>, SharedMemoryError> {
        let service = service_name(name)?;
        for _ in 0..TRIES {
            let opened = self
                .node
                .service_builder(&service)
                .event()
                .max_listeners(NODES)
                .max_notifiers(NODES)
                .max_nodes(NODES)
                .open_or_create();
            match opened {
                Ok(events) => return Ok(events),
                Err(EventOpenOrCreateError::SystemInFlux) => sleep(INTERVAL),
                Err(error) => return Err(SharedMemoryError::transport("open", name)(error)),
            }
        }
        Err(SharedMemoryError::transport("open", name)(
            "it comes and goes",
        ))
    }

    /// Makes or opens the service of all inlets.
    pub fn make_inlets(&self) -> Result<Inlets, SharedMemoryError> {
        let name = self.run.inlets();
        let made = self
            .node
            .service_builder(&service_name(&name)?)
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
            .open_or_create();
        made.map_err(SharedMemoryError::transport("create", &name))
    }

    /// Opens the service of all inlets; none if the run is not there.
    pub fn open_inlets(&self) -> Result<Option<Inlets>, SharedMemoryError> {
        let name = self.run.inlets();
        let opened = self
            .node
            .service_builder(&service_name(&name)?)
            .request_response::<[u8], [u8]>()
            .request_user_header::<CallHeader>()
            .response_user_header::<ReplyHeader>()
            .open();
        match opened {
            Ok(inlets) => Ok(Some(inlets)),
            Err(
                RequestResponseOpenError::DoesNotExist
                | RequestResponseOpenError::IsMarkedForDestruction
                | RequestResponseOpenError::HangsInCreation
                | RequestResponseOpenError::ServiceInCorruptedState,
            ) => Ok(None),
            Err(error) => Err(SharedMemoryError::transport("open", &name)(error)),
        }
    }
}

/// A service that is not there, or just being made or removed.
fn passing(error: &PublishSubscribeOpenError) -> bool {
    matches!(
        error,
        PublishSubscribeOpenError::DoesNotExist
            | PublishSubscribeOpenError::IsMarkedForDestruction
            | PublishSubscribeOpenError::HangsInCreation
            | PublishSubscribeOpenError::ServiceInCorruptedState
    )
}
