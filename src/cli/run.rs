//! `toile run`: simulate a scene and record it.

use std::path::PathBuf;
#[cfg(feature = "iceoryx2")]
use std::sync::Arc;

use clap::Args;

use super::chart::budget;
use super::kept::{self, Kept};
use super::progress::Bar;
#[cfg(feature = "ros2")]
use super::ros2::{self, Ros2Args};
#[cfg(feature = "iceoryx2")]
use super::shared;
use super::{CliError, commands, output, plan, signals, source, summary};
use crate::chart::plan::{Plan, Tolerance};
#[cfg(feature = "ros2")]
use crate::node::ros2::Supervisor;
#[cfg(feature = "iceoryx2")]
use crate::node::shared_memory::{Counts, RunName, SharedMemory};
use crate::node::{self, NodeError, Order, Pace, RunOptions};
#[cfg(feature = "iceoryx2")]
use crate::node::{Carrier, Inbox};
use crate::scene::{Method, Override, Scene, Warning};

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
    /// Method: a scheme (backward-euler, bdf2, generalised-alpha, central-difference, equilibrium), a solver
    /// (quasi-newton, xpbd) with its usual scheme, or SCHEME+SOLVER (sets method.scheme and method.solver).
    #[arg(long, value_name = "M")]
    method: Option<String>,
    /// Plan method, step and mesh for this error of what the scene observes (1%), run, and check afterwards.
    #[arg(long, value_name = "T", conflicts_with_all = ["method", "dt"])]
    tolerance: Option<Tolerance>,
    /// CPU seconds that a planned run may cost on this machine.
    #[arg(long, value_name = "S", default_value = "60", value_parser = budget, requires = "tolerance")]
    budget: f64,
    /// Step in seconds (sets method.dt).
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    dt: Option<String>,
    /// Simulated time in seconds (sets duration).
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    duration: Option<String>,
    /// Seed of the perturbed start (sets perturbation.seed).
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    seed: Option<String>,
    /// Threads of a step; the result does not depend on it.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    /// Simulated against wall time: free (as fast as possible), real, a factor such as 0.5, or lockstep (steps only
    /// when told).
    #[arg(long, value_name = "P", default_value_t = Pace::Free, allow_negative_numbers = true)]
    pace: Pace,
    /// Start paused, until somebody says go.
    #[arg(long)]
    wait_for_start: bool,
    /// Commands at set steps, a TOML file (see `toile list commands`).
    #[arg(long, value_name = "FILE.toml")]
    commands: Option<PathBuf>,
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
    bridge: Ros2Args,
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
    /// How the scene came to its method, step and mesh.
    planned: Option<Plan>,
    /// Commands, each with the step after which it is due.
    commands: Vec<(u64, Order)>,
}

impl RunArgs {
    pub(super) fn run(&self) -> Result<(), CliError> {
        let job = self.check()?;
        let mut options = RunOptions {
            output: Some(job.output.clone()),
            threads: job.threads,
            stop: signals::stop_flag()?,
            pace: self.pace,
            wait_for_start: self.wait_for_start,
            ..RunOptions::default()
        };
        #[cfg(feature = "iceoryx2")]
        let shared = self.share(&mut options)?;
        options.inbox = options.inbox.scripted(job.commands);
        let waits = options.wait_for_start || options.pace == Pace::Lockstep;
        if waits && options.live.is_empty() && self.commands.is_none() {
            return Err(CliError::Input(
                "nobody could start this run; let others in with --shm or --ros2".to_string(),
            ));
        }
        for warning in &job.warnings {
            eprintln!("warning: {warning}");
        }
        #[cfg(feature = "ros2")]
        let bridge = self.bridge.supervise(self.ros2, &self.name)?;
        let bar = Bar::new(&job.scene.name);
        let result = node::run(&job.scene, options, &mut |progress| bar.show(progress));
        drop(bar);
        #[cfg(feature = "ros2")]
        let bridge = bridge.map(Supervisor::finish);
        let summary = result.map_err(|error| match error {
            NodeError::Diverged(diverged) => CliError::Diverged {
                diverged,
                recording: job.output.clone(),
            },
            other => other.into(),
        })?;
        let kept = match (&job.planned, self.tolerance) {
            (Some(plan), Some(tolerance)) => Some(Kept::check(plan, tolerance)?),
            _ => None,
        };
        if self.json {
            let json = summary::json(&job.scene, &job.warnings, &summary);
            let json = kept::with_check(json, kept.as_ref());
            #[cfg(feature = "iceoryx2")]
            let json = shared::with_counts(json, shared.as_deref());
            #[cfg(feature = "ros2")]
            let json = ros2::with_bridge(json, bridge.as_ref());
            return output::print_json(&json);
        }
        let text = summary::text(&job.scene, &summary) + &kept::text(kept.as_ref());
        #[cfg(feature = "iceoryx2")]
        shared::warn(shared.as_deref());
        #[cfg(feature = "ros2")]
        let text = ros2::text_with_bridge(text, bridge.as_ref());
        output::print(&text)
    }

    /// Shared memory, if asked for.
    #[cfg(feature = "iceoryx2")]
    fn share(&self, options: &mut RunOptions) -> Result<Option<Arc<Counts>>, CliError> {
        if !self.is_shared() {
            return Ok(None);
        }
        let (mailbox, inbox) = Inbox::with_mailbox();
        let carrier = SharedMemory::open(self.name.clone(), mailbox).map_err(NodeError::from)?;
        let counts = carrier.counts();
        let carrier: Box<dyn Carrier> = Box::new(carrier);
        options.inbox = inbox;
        options.live.push(("shared memory".to_string(), carrier));
        Ok(Some(counts))
    }

    /// Whether others reach the run through shared memory; the bridge to ROS 2 is one of them.
    #[cfg(feature = "iceoryx2")]
    fn is_shared(&self) -> bool {
        #[cfg(feature = "ros2")]
        if self.ros2 {
            return true;
        }
        self.shm
    }

    /// Scene, overrides and options into a job that can be run.
    fn check(&self) -> Result<Job, CliError> {
        let (mut scene, warnings) = source::scene(&self.scene, &self.overrides()?)?;
        let planned = match self.tolerance {
            Some(tolerance) => Some(plan::find(&scene, (tolerance, self.budget))?),
            None => None,
        };
        if let Some(plan) = &planned {
            scene = plan.scene.clone();
        }
        let output = match &self.output {
            Some(path) => path.clone(),
            None => PathBuf::from(format!("{}.mcap", scene.name)),
        };
        Ok(Job {
            scene,
            warnings,
            output,
            threads: usize::from(self.threads),
            planned,
            commands: match &self.commands {
                Some(path) => commands::read(path)?,
                None => vec![],
            },
        })
    }

    /// `--set` first: an option of its own is the stronger word.
    fn overrides(&self) -> Result<Vec<Override>, CliError> {
        let set = self.set.iter().map(|text| Override::parse(text));
        let mut overrides = set.collect::<Result<Vec<_>, _>>()?;
        for (option, key, value) in [
            ("--fabric", "fabric.name", &self.fabric),
            ("--dt", "method.dt", &self.dt),
            ("--duration", "duration", &self.duration),
            ("--seed", "perturbation.seed", &self.seed),
        ] {
            if let Some(value) = value {
                overrides.push(Override::new(key, value, &format!("{option} {value}")));
            }
        }
        if let Some(name) = &self.method {
            overrides.extend(method(name));
        }
        Ok(overrides)
    }
}

/// What a method's name stands for; the key of the scheme refuses what stands for none.
fn method(name: &str) -> Vec<Override> {
    let option = format!("--method {name}");
    match Method::named(name) {
        Some(Method { scheme, solver }) => vec![
            Override::new("method.scheme", scheme.name(), &option),
            Override::new("method.solver", solver.name(), &option),
        ],
        None => vec![Override::new("method.scheme", name, &option)],
    }
}
