//! How a verb reaches a running simulation.

use std::time::{Duration, Instant};

use clap::Args;

use super::CliError;
#[cfg(feature = "ros2")]
use super::ros2::DomainArgs;
use crate::node::NodeError;
use crate::node::shared_memory::{Client, RunName, Subscription};
use crate::wire::channels::Channel;
use crate::wire::inbound::Inlet;

/// How often a run is looked for that is not there.
const LOOK: Duration = Duration::from_millis(20);

/// Where the simulation is to be found.
#[derive(Args)]
pub(super) struct TransportArgs {
    /// Reach it over shared memory, which is the default.
    #[arg(long, global = true)]
    shm: bool,
    /// Name of the run in shared memory.
    #[arg(
        long = "name",
        id = "run_name",
        value_name = "NAME",
        global = true,
        default_value_t
    )]
    name: RunName,
    /// Reach it over ROS 2, on the domain of ROS_DOMAIN_ID.
    #[cfg(feature = "ros2")]
    #[arg(long, global = true, conflicts_with_all = ["shm", "run_name"])]
    ros2: bool,
    #[cfg(feature = "ros2")]
    #[command(flatten)]
    domain: DomainArgs,
}

/// A way to a running simulation.
pub(super) trait Transport {
    /// Sends a message to an inlet and waits for what becomes of it: the answer of a service, an AppliedCommand
    /// for a topic, both in CDR; none where the way does not tell.
    fn call(
        &mut self,
        inlet: &'static Inlet,
        message: &[u8],
        timeout: Duration,
    ) -> Result<Option<Vec<u8>>, CliError>;

    /// Reads a topic of a channel from its latest message on, of the run that is there or comes.
    fn watch(
        self: Box<Self>,
        channel: &'static Channel,
        topic: &str,
    ) -> Result<Box<dyn Source>, CliError>;
}

/// Messages of one topic.
pub(super) trait Source {
    /// The next message; none if none comes in this time.
    fn next(&mut self, timeout: Duration) -> Result<Option<Seen>, CliError>;
}

/// A message as it came.
pub(super) struct Seen {
    /// Simulated time since the start of the run \[ns\].
    pub stamp: u64,
    /// Step of the state that it speaks of, and the digest of that state, where the way tells.
    pub state: Option<(u64, u64)>,
    /// Messages lost just before it.
    pub missed: u64,
    /// Whether it is the first that is seen of a run.
    pub first: bool,
    /// CDR with its encapsulation header.
    pub bytes: Vec<u8>,
}

impl TransportArgs {
    /// The way that was asked for.
    pub(super) fn open(&self) -> Result<Box<dyn Transport>, CliError> {
        #[cfg(feature = "ros2")]
        match self.ros2 {
            true => return self.domain.open(),
            false => self.domain.refuse_any()?,
        }
        let client = Client::new(self.name.clone()).map_err(NodeError::from)?;
        Ok(Box::new(SharedMemory(client)))
    }
}

struct SharedMemory(Client);

impl Transport for SharedMemory {
    fn call(
        &mut self,
        inlet: &'static Inlet,
        message: &[u8],
        timeout: Duration,
    ) -> Result<Option<Vec<u8>>, CliError> {
        let answer = self.0.call(inlet.name, message, timeout);
        Ok(Some(answer.map_err(NodeError::from)?))
    }

    fn watch(
        self: Box<Self>,
        _: &'static Channel,
        topic: &str,
    ) -> Result<Box<dyn Source>, CliError> {
        Ok(Box::new(SharedTopic {
            subscription: self.0.subscribe(topic),
            client: self.0,
        }))
    }
}

struct SharedTopic {
    subscription: Subscription,
    client: Client,
}

impl Source for SharedTopic {
    fn next(&mut self, timeout: Duration) -> Result<Option<Seen>, CliError> {
        let begun = Instant::now();
        loop {
            if let Some(message) = self.subscription.receive().map_err(NodeError::from)? {
                let header = message.header();
                return Ok(Some(Seen {
                    stamp: header.stamp,
                    state: Some((header.step, header.digest)),
                    missed: message.missed,
                    first: message.first,
                    bytes: message.bytes().to_vec(),
                }));
            }
            let left = timeout.saturating_sub(begun.elapsed());
            if left.is_zero() {
                return Ok(None);
            }
            self.client.wait(left.min(LOOK));
        }
    }
}
