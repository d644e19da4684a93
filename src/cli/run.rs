//! `toile run`: simulate a scene and record it.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Args;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use super::progress::Bar;
use super::{CliError, output, source, summary};
#[cfg(feature = "iceoryx2")]
use crate::node::shared_memory::{RunName, SharedMemory};
use crate::node::{self, NodeError, RunOptions};
#[cfg(feature = "iceoryx2")]
use crate::node::{Carrier, Inbox};
use crate::scene::{Override, Scene, Warning};

/// Arguments of `toile run`.
///
/// Options that stand for a key of the scene are taken as text, so that one place checks and refuses them.
#[derive(Args)]
pub(super) struct RunArgs {
    /// A built-in scene (see `toile list scenes`), a TOML file, or `-` for standard input.
    scene: String,
    /// Recording: FILE.mcap, or a directory for a rosbag2 bag [default: <scene name>.mcap]. It is overwritten.
    #[arg(short, long, value_name = "FILE.mcap")]
    output: Option<PathBuf>,
    /// Fabric of the catalogue, F1 to F12 (sets fabric.name).
    #[arg(long, value_name = "F")]
    fabric: Option<String>,
    /// Replace any key of the scene, such as damping=0 or obstacle.table.friction=0.5.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Time scheme: backward-euler, bdf2, generalised-alpha, central-difference (sets method.scheme).
    #[arg(long, value_name = "M")]
    method: Option<String>,
    /// Step in seconds (sets method.dt).
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    dt: Option<String>,
    /// Simulated time in seconds (sets duration).
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    duration: Option<String>,
    /// Seed of the perturbed start (sets perturbation.seed).
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    seed: Option<String>,
    /// Threads of the solver; the result does not depend on it.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    /// Publish over shared memory, and take commands from there.
    #[cfg(feature = "iceoryx2")]
    #[arg(long)]
    shm: bool,
    /// Name under which the run is found in shared memory.
    #[cfg(feature = "iceoryx2")]
    #[arg(long, value_name = "NAME", default_value_t)]
    name: RunName,
    /// The same on ROS 2, through a process of its own that reads and writes shared memory.
    #[cfg(feature = "ros2")]
    #[arg(long)]
    ros2: bool,
    #[cfg(feature = "ros2")]
    #[command(flatten)]
    bridge: super::bridge::Ros2Args,
    #[arg(long, default_value_t)]
    pace: crate::node::Pace,
    /// A JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

/// A checked run.
struct Job {
    scene: Scene,
    warnings: Vec<Warning>,
    output: PathBuf,
    threads: usize,
}

impl RunArgs {
    pub(super) fn run(&self) -> Result<(), CliError> {
        let job = self.check()?;
        let mut options = RunOptions {
            output: Some(job.output.clone()),
            threads: job.threads,
            stop: stop_flag()?,
            pace: self.pace,
            ..RunOptions::default()
        };
        #[cfg(feature = "iceoryx2")]
        self.share(&mut options)?;
        #[cfg(feature = "ros2")]
        let bridge = self.start_bridge()?;
        for warning in &job.warnings {
            eprintln!("warning: {warning}");
        }
        let bar = Bar::new(&job.scene.name);
        let result = node::run(&job.scene, options, &mut |progress| bar.show(progress));
        drop(bar);
        #[cfg(feature = "ros2")]
        let bridge = bridge.map(crate::node::ros2::Supervisor::finish);
        let summary = result.map_err(|error| match error {
            NodeError::Diverged(diverged) => CliError::Diverged {
                diverged,
                recording: job.output.clone(),
            },
            other => other.into(),
        })?;
        match self.json {
            true => {
                let mut json = summary::json(&job.scene, &job.warnings, &summary);
                json["bridge"] = serde_json::to_value(&bridge).unwrap();
                json["orders"] = serde_json::to_value(&summary.orders).unwrap();
                output::print_json(&json)
            }
            false => output::print(&summary::text(&job.scene, &summary)),
        }
    }

    /// Shared memory, if asked for.
    #[cfg(feature = "iceoryx2")]
    fn share(&self, options: &mut RunOptions) -> Result<(), CliError> {
        if self.live() {
            let (mailbox, inbox) = Inbox::with_mailbox();
            let carrier =
                SharedMemory::open(self.name.clone(), mailbox).map_err(NodeError::from)?;
            let carrier: Box<dyn Carrier> = Box::new(carrier);
            options.inbox = inbox;
            options.live.push(("shared memory".to_string(), carrier));
        }
        Ok(())
    }

    fn live(&self) -> bool {
        self.shm || self.ros2
    }

    /// The bridge to ROS 2, if asked for.
    #[cfg(feature = "ros2")]
    fn start_bridge(&self) -> Result<Option<crate::node::ros2::Supervisor>, CliError> {
        match self.ros2 {
            true => self.bridge.supervise(&self.name).map(Some),
            false => Ok(None),
        }
    }

    /// Scene, overrides and options into a job that can be run.
    fn check(&self) -> Result<Job, CliError> {
        let (scene, warnings) = source::scene(&self.scene, &self.overrides()?)?;
        let output = match &self.output {
            Some(path) => path.clone(),
            None => PathBuf::from(format!("{}.mcap", scene.name)),
        };
        Ok(Job {
            scene,
            warnings,
            output,
            threads: usize::from(self.threads),
        })
    }

    /// `--set` first: an option of its own is the stronger word.
    fn overrides(&self) -> Result<Vec<Override>, CliError> {
        let set = self.set.iter().map(|text| Override::parse(text));
        let mut overrides = set.collect::<Result<Vec<_>, _>>()?;
        for (option, key, value) in [
            ("--fabric", "fabric.name", &self.fabric),
            ("--method", "method.scheme", &self.method),
            ("--dt", "method.dt", &self.dt),
            ("--duration", "duration", &self.duration),
            ("--seed", "perturbation.seed", &self.seed),
        ] {
            if let Some(value) = value {
                overrides.push(Override::new(key, value, &format!("{option} {value}")));
            }
        }
        Ok(overrides)
    }
}

/// A flag that Ctrl-C and SIGTERM set, so that the run ends after the step at hand with its recording closed.
/// A second signal ends the process at once.
pub(super) fn stop_flag() -> Result<Arc<AtomicBool>, CliError> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // In this order, or the first signal would find the flag set already.
        flag::register_conditional_shutdown(signal, 1, Arc::clone(&stop))
            .and_then(|_| flag::register(signal, Arc::clone(&stop)))
            .map_err(|error| CliError::Input(format!("cannot handle signals: {error}")))?;
    }
    Ok(stop)
}
