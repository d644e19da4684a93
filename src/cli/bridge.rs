//! `toile bridge`: a run's channels and commands on ROS 2, in a process of its own.

use std::io::{Read, stdin};
use std::process::exit;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use clap::{Args, ValueEnum};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use super::{CliError, output};
use crate::node::NodeError;
use crate::node::ros2::{self, ServiceMapping, Settings, Traffic};
use crate::node::shared_memory::RunName;

/// How long a bridge that has lost its run may take to end.
const FAREWELL: Duration = Duration::from_secs(2);

/// Where and under which name a run appears on ROS 2.
#[derive(Args)]
pub(super) struct Ros2Args {
    /// Name of the ROS 2 node.
    #[arg(long, value_name = "NAME", default_value = "toile")]
    node_name: String,
    /// Namespace of the node; topics and services below /toile move into it.
    #[arg(long, value_name = "/SPACE", default_value = "/")]
    namespace: String,
    /// Speak on every network interface instead of the loopback alone. Whoever reaches the port can send commands.
    #[arg(long)]
    allow_lan: bool,
    /// How services tell requests apart; both sides must agree.
    #[arg(long, value_name = "MAPPING", value_enum, default_value_t)]
    service_mapping: Mapping,
    /// Address space that the DDS process may have [MiB]; beyond it, it ends and is started again.
    #[arg(long, value_name = "MIB", default_value_t = ros2::MEMORY_LIMIT_MIB, value_parser = clap::value_parser!(u64).range(512..=1_048_576))]
    memory_limit: u64,
}

#[derive(Clone, Copy, Default, ValueEnum)]
enum Mapping {
    /// Fast DDS, Connext.
    #[default]
    Enhanced,
    /// Cyclone DDS.
    Cyclone,
}

impl Ros2Args {
    /// The options with ROS 2's environment variables, checked.
    pub(super) fn settings(&self) -> Result<Settings, CliError> {
        let settings = Settings {
            lan: self.allow_lan,
            node_name: self.node_name.clone(),
            namespace: self.namespace.clone(),
            services: match self.service_mapping {
                Mapping::Enhanced => ServiceMapping::Enhanced,
                Mapping::Cyclone => ServiceMapping::Cyclone,
            },
            ..Settings::default()
        };
        Ok(settings.from_environment().map_err(NodeError::from)?)
    }
}

/// Arguments of `toile bridge`.
#[derive(Args)]
pub(super) struct BridgeArgs {
    /// Name of the run in shared memory.
    #[arg(long, value_name = "RUN", default_value_t)]
    name: RunName,
    #[command(flatten)]
    ros2: Ros2Args,
    /// Started by a run: tells it the counts, and ends with it.
    #[arg(long, hide = true)]
    supervised: bool,
}

impl BridgeArgs {
    pub(super) fn run(&self) -> Result<(), CliError> {
        let settings = self.ros2.settings()?;
        ros2::limit_memory(self.ros2.memory_limit).map_err(NodeError::from)?;
        let stop = Arc::new(AtomicBool::new(false));
        if self.supervised {
            end_with_parent(Arc::clone(&stop));
        }
        for signal in [SIGINT, SIGTERM] {
            // The terminal's Ctrl-C reaches the run too, which then ends this process when all is sent.
            let flag = match (signal, self.supervised) {
                (SIGINT, true) => Arc::default(),
                _ => Arc::clone(&stop),
            };
            flag::register(signal, flag)
                .map_err(|error| CliError::Input(format!("cannot handle signals: {error}")))?;
        }
        let mut beat = |traffic: &Traffic| {
            if self.supervised
                && let Ok(line) = serde_json::to_string(traffic)
            {
                // Without a reader there is no run either.
                let _ = output::print(&format!("{line}\n"));
            }
        };
        let traffic = ros2::bridge(&self.name, &settings, &stop, &mut beat)?;
        match self.supervised {
            true => Ok(()),
            false => output::print(&format!("{}\n", summary(&traffic))),
        }
    }
}

/// Sets the flag when standard input ends, which it does with the process that holds its other end.
fn end_with_parent(stop: Arc<AtomicBool>) {
    thread::spawn(move || {
        let mut rest = [0; 64];
        while matches!(stdin().read(&mut rest), Ok(1..)) {}
        stop.store(true, Ordering::Relaxed);
        thread::sleep(FAREWELL);
        exit(0);
    });
}

/// What a bridge carried, in one line.
pub(super) fn summary(traffic: &Traffic) -> String {
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
        "out: {published} messages, {unsent} dropped at slow subscribers, {missed} missed; in: {received} messages, \
         {delivered} delivered, {refused} refused, {dropped} dropped, {lost} lost, {answered} answered"
    )
}
