//! ROS 2 on the command line: where and as whom to speak, the bridge of a run, and a way to a running simulation.

use std::env;
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use serde_json::{Value, json};

use super::CliError;
use super::transport::{Seen, Source, Transport};
use crate::node::NodeError;
use crate::node::ros2::{
    self, BridgeCommand, BridgeReport, Peer, Reader, ServiceMapping, Settings, Supervisor, Traffic,
};
use crate::node::shared_memory::RunName;
use crate::wire::channels::Channel;
use crate::wire::inbound::Inlet;

/// How often it is looked whether a message has come.
const LOOK: Duration = Duration::from_millis(1);

/// The part of a DDS domain that is spoken on; the domain itself is `ROS_DOMAIN_ID`.
#[derive(Args)]
pub(super) struct DomainArgs {
    /// Namespace of the ROS 2 node [default: /]; topics and services below /toile are in it.
    #[arg(long, value_name = "/SPACE", global = true)]
    namespace: Option<String>,
    /// Speak on every network interface instead of the loopback alone. Whoever reaches the port can send commands.
    #[arg(long, global = true)]
    allow_lan: bool,
    /// How services tell requests apart, as the other side's middleware does [default: enhanced].
    #[arg(long, value_name = "MAPPING", value_enum, global = true)]
    service_mapping: Option<Mapping>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Mapping {
    /// Fast DDS, Connext.
    Enhanced,
    /// Cyclone DDS.
    Cyclone,
}

/// Where and under which name a run appears on ROS 2.
#[derive(Args)]
pub(super) struct Ros2Args {
    #[command(flatten)]
    domain: DomainArgs,
    /// Name of the ROS 2 node [default: toile].
    #[arg(long, value_name = "NAME")]
    node_name: Option<String>,
    /// Address space that the DDS process may have [MiB, default: 1024]; beyond it, it ends and is started again.
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(512..=1_048_576))]
    memory_limit: Option<u64>,
}

impl DomainArgs {
    /// The options with ROS 2's environment variables, checked.
    fn settings(&self, node_name: Option<&str>) -> Result<Settings, CliError> {
        let usual = Settings::default();
        let settings = Settings {
            lan: self.allow_lan,
            node_name: node_name.unwrap_or(&usual.node_name).to_string(),
            namespace: self.namespace.clone().unwrap_or(usual.namespace),
            services: match self.service_mapping {
                None | Some(Mapping::Enhanced) => ServiceMapping::Enhanced,
                Some(Mapping::Cyclone) => ServiceMapping::Cyclone,
            },
            domain: usual.domain,
        };
        Ok(settings.from_environment().map_err(NodeError::from)?)
    }

    /// Joins the domain beside whoever is there.
    pub(super) fn open(&self) -> Result<Box<dyn Transport>, CliError> {
        let settings = self.settings(Some("toile_client"))?;
        let peer = Peer::join(settings).map_err(NodeError::from)?;
        Ok(Box::new(OnRos2(peer)))
    }

    /// Options that mean nothing without `--ros2`.
    fn given(&self) -> [(&'static str, bool); 3] {
        [
            ("--namespace", self.namespace.is_some()),
            ("--allow-lan", self.allow_lan),
            ("--service-mapping", self.service_mapping.is_some()),
        ]
    }

    /// An option that would do nothing is a mistake.
    pub(super) fn refuse_any(&self) -> Result<(), CliError> {
        refuse(&self.given())
    }
}

fn refuse(given: &[(&str, bool)]) -> Result<(), CliError> {
    match given.iter().find(|(_, given)| *given) {
        Some((option, _)) => Err(CliError::Input(format!("{option} needs --ros2"))),
        None => Ok(()),
    }
}

impl Ros2Args {
    /// The options with ROS 2's environment variables, checked.
    pub(super) fn settings(&self) -> Result<Settings, CliError> {
        self.domain.settings(self.node_name.as_deref())
    }

    /// Address space that the DDS process may have \[MiB\].
    pub(super) fn memory_limit(&self) -> u64 {
        self.memory_limit.unwrap_or(ros2::MEMORY_LIMIT_MIB)
    }

    /// Starts the bridge of a run, if it is wanted; it starts again when it dies.
    pub(super) fn supervise(
        &self,
        wanted: bool,
        run: &RunName,
    ) -> Result<Option<Supervisor>, CliError> {
        if !wanted {
            self.domain.refuse_any()?;
            refuse(&[
                ("--node-name", self.node_name.is_some()),
                ("--memory-limit", self.memory_limit.is_some()),
            ])?;
            return Ok(None);
        }
        let program = env::current_exe()
            .map_err(|error| CliError::Input(format!("cannot find the toile binary: {error}")))?;
        let command = BridgeCommand {
            program,
            run: run.clone(),
            settings: self.settings()?,
            memory_limit: self.memory_limit(),
        };
        let notice = |line: &str| eprintln!("warning: {line}");
        let supervisor = Supervisor::start(command, Box::new(notice));
        Ok(Some(supervisor.map_err(NodeError::from)?))
    }
}

/// The summary of a run in words, and what came of its bridge.
pub(super) fn text_with_bridge(text: String, report: Option<&BridgeReport>) -> String {
    let Some(report) = report else {
        return text;
    };
    let again = match &report.last_death {
        None => String::new(),
        Some(death) => format!(
            "; started again {} times, the last time it died of {death}",
            report.restarts
        ),
    };
    format!("{text}ROS 2: {}{again}\n", carried(&report.traffic))
}

/// The same in the run's JSON summary.
pub(super) fn with_bridge(mut summary: Value, report: Option<&BridgeReport>) -> Value {
    if let Some(report) = report {
        summary["bridge"] = json!(report);
    }
    summary
}

/// What a bridge carried, in one line.
pub(super) fn carried(traffic: &Traffic) -> String {
    let Traffic {
        published,
        unsent,
        missed,
        received,
        lost,
        dropped,
        delivered,
        refused,
        answered,
    } = traffic;
    format!(
        "out {published} messages ({unsent} dropped at slow subscribers, {missed} missed); in {received} messages \
         ({delivered} delivered, {refused} refused, {dropped} dropped, {lost} lost, {answered} answered)"
    )
}

/// The way over ROS 2.
struct OnRos2(Peer);

impl Transport for OnRos2 {
    fn call(
        &mut self,
        inlet: &'static Inlet,
        message: &[u8],
        timeout: Duration,
    ) -> Result<Option<Vec<u8>>, CliError> {
        let answer = self.0.send(inlet, message, timeout);
        Ok(answer.map_err(NodeError::from)?)
    }

    fn watch(
        mut self: Box<Self>,
        channel: &'static Channel,
        topic: &str,
    ) -> Result<Box<dyn Source>, CliError> {
        let reader = self.0.subscribe(channel, topic).map_err(NodeError::from)?;
        Ok(Box::new(RosTopic {
            _peer: self.0,
            reader,
            channel,
            lost: 0,
            seen: false,
        }))
    }
}

/// A topic that is read; the participant lives as long.
struct RosTopic {
    reader: Reader,
    channel: &'static Channel,
    lost: u64,
    seen: bool,
    _peer: Peer,
}

impl Source for RosTopic {
    fn next(&mut self, timeout: Duration) -> Result<Option<Seen>, CliError> {
        let begun = Instant::now();
        loop {
            if let Some(sample) = self.reader.take() {
                let missed = self.reader.lost() - self.lost;
                self.lost = self.reader.lost();
                return Ok(Some(Seen {
                    stamp: stamp(self.channel, &sample.bytes),
                    state: None,
                    missed,
                    first: !std::mem::replace(&mut self.seen, true),
                    bytes: sample.bytes,
                }));
            }
            let left = timeout.saturating_sub(begun.elapsed());
            if left.is_zero() {
                return Ok(None);
            }
            std::thread::sleep(left.min(LOOK));
        }
    }
}

/// Simulated time of a message \[ns\]: nearly all begin with it; 0 for those that have none.
fn stamp(channel: &Channel, bytes: &[u8]) -> u64 {
    let word = |at: usize| {
        let word = bytes.get(at..at + 4).and_then(|word| word.try_into().ok());
        u64::from(word.map_or(0, u32::from_le_bytes))
    };
    let at = match channel.message.name {
        "std_msgs/msg/String" => return 0,
        // A sequence of what has a header: its length stands in front.
        "tf2_msgs/msg/TFMessage" | "visualization_msgs/msg/MarkerArray" => 8,
        _ => 4,
    };
    1_000_000_000 * word(at) + word(at + 4)
}
