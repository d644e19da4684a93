//! `toile bridge`: a run's channels and commands on ROS 2, in a process of its own.

use std::env;
use std::io::{Read, stdin};
use std::panic;
use std::process::{self, exit};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use clap::{Args, ValueEnum};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use super::{CliError, output};
use crate::node::NodeError;
use serde_json::{Value, json};

use crate::node::ros2::{
    self, BridgeCommand, BridgeReport, ServiceMapping, Settings, Supervisor, Traffic,
};
use crate::node::shared_memory::RunName;

/// How long a bridge that has lost its run may take to end.
const FAREWELL: Duration = Duration::from_secs(2);

/// Where and under which name a run appears on ROS 2.
#[derive(Args)]
pub(super) struct Ros2Args {
    /// Name of the ROS 2 node [default: toile].
    #[arg(long, value_name = "NAME")]
    node_name: Option<String>,
    /// Namespace of the node [default: /]; topics and services below /toile move into it.
    #[arg(long, value_name = "/SPACE")]
    namespace: Option<String>,
    /// Speak on every network interface instead of the loopback alone. Whoever reaches the port can send commands.
    #[arg(long)]
    allow_lan: bool,
    /// How services tell requests apart, as the other side's middleware does [default: enhanced].
    #[arg(long, value_name = "MAPPING", value_enum)]
    service_mapping: Option<Mapping>,
    /// Address space that the DDS process may have [MiB, default: 1024]; beyond it, it ends and is started again.
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(512..=1_048_576))]
    memory_limit: Option<u64>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Mapping {
    /// Fast DDS, Connext.
    Enhanced,
    /// Cyclone DDS.
    Cyclone,
}

impl Ros2Args {
    /// The options with ROS 2's environment variables, checked.
    pub(super) fn settings(&self) -> Result<Settings, CliError> {
        let usual = Settings::default();
        let settings = Settings {
            lan: self.allow_lan,
            node_name: self.node_name.clone().unwrap_or(usual.node_name),
            namespace: self.namespace.clone().unwrap_or(usual.namespace),
            services: match self.service_mapping {
                None | Some(Mapping::Enhanced) => ServiceMapping::Enhanced,
                Some(Mapping::Cyclone) => ServiceMapping::Cyclone,
            },
            domain: usual.domain,
        };
        Ok(settings.from_environment().map_err(NodeError::from)?)
    }

    fn memory_limit(&self) -> u64 {
        self.memory_limit.unwrap_or(ros2::MEMORY_LIMIT_MIB)
    }

    /// Starts the bridge of a run, if it is wanted; it starts again when it dies.
    pub(super) fn supervise(
        &self,
        wanted: bool,
        run: &RunName,
    ) -> Result<Option<Supervisor>, CliError> {
        if !wanted {
            return self.refuse_any().map(|()| None);
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

    /// An option that would do nothing is a mistake.
    fn refuse_any(&self) -> Result<(), CliError> {
        let given = [
            ("--node-name", self.node_name.is_some()),
            ("--namespace", self.namespace.is_some()),
            ("--allow-lan", self.allow_lan),
            ("--service-mapping", self.service_mapping.is_some()),
            ("--memory-limit", self.memory_limit.is_some()),
        ];
        match given.iter().find(|(_, given)| *given) {
            Some((option, _)) => Err(CliError::Input(format!("{option} needs --ros2"))),
            None => Ok(()),
        }
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
        end_at_panic();
        ros2::limit_memory(self.ros2.memory_limit()).map_err(NodeError::from)?;
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
            false => output::print(&format!("{}\n", carried(&traffic))),
        }
    }
}

/// A thread of the DDS library that panics would leave a bridge that stands and carries nothing.
fn end_at_panic() {
    let report = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        report(info);
        process::abort();
    }));
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

/// What came of a run's bridge, in one line.
pub(super) fn text(report: &BridgeReport) -> String {
    let traffic = carried(&report.traffic);
    match &report.last_death {
        None => format!("ROS 2: {traffic}"),
        Some(death) => {
            let times = report.restarts;
            format!("ROS 2: {traffic}; started again {times} times, died last by {death}")
        }
    }
}

/// The same in the run's JSON summary.
pub(super) fn add_json(summary: &mut Value, report: Option<&BridgeReport>) {
    if let Some(report) = report {
        summary["bridge"] = json!(report);
    }
}

/// What a bridge carried.
fn carried(traffic: &Traffic) -> String {
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
