//! `toile run`: simulate a scene and record it.

use std::path::PathBuf;

use clap::Args;

use super::progress::Bar;
use super::{CliError, output, signals, source, summary};
#[cfg(feature = "iceoryx2")]
use crate::node::shared_memory::{RunName, SharedMemory};
use crate::node::{self, NodeError, Pace, RunOptions};
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
    /// Simulated against wall time: free (as fast as possible), real, a factor such as 0.5, or lockstep (steps only
    /// when told).
    #[arg(long, value_name = "P", default_value_t = Pace::Free, allow_negative_numbers = true)]
    pace: Pace,
    /// Start paused, until somebody says go.
    #[arg(long)]
    wait_for_start: bool,
    /// Publish over shared memory, and take commands from there.
    #[cfg(feature = "iceoryx2")]
    #[arg(long)]
    shm: bool,
    /// Name under which the run is found in shared memory.
    #[cfg(feature = "iceoryx2")]
    #[arg(long, value_name = "NAME", default_value_t, requires = "shm")]
    name: RunName,
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
            stop: signals::stop_flag()?,
            pace: self.pace,
            wait_for_start: self.wait_for_start,
            ..RunOptions::default()
        };
        #[cfg(feature = "iceoryx2")]
        self.share(&mut options)?;
        let waits = options.wait_for_start || options.pace == Pace::Lockstep;
        if waits && options.live.is_empty() {
            return Err(CliError::Input(
                "nobody could start this run; let others in with --shm".to_string(),
            ));
        }
        for warning in &job.warnings {
            eprintln!("warning: {warning}");
        }
        let bar = Bar::new(&job.scene.name);
        let result = node::run(&job.scene, options, &mut |progress| bar.show(progress));
        drop(bar);
        let summary = result.map_err(|error| match error {
            NodeError::Diverged(diverged) => CliError::Diverged {
                diverged,
                recording: job.output.clone(),
            },
            other => other.into(),
        })?;
        match self.json {
            true => output::print_json(&summary::json(&job.scene, &job.warnings, &summary)),
            false => output::print(&summary::text(&job.scene, &summary)),
        }
    }

    /// Shared memory, if asked for.
    #[cfg(feature = "iceoryx2")]
    fn share(&self, options: &mut RunOptions) -> Result<(), CliError> {
        if self.shm {
            let (mailbox, inbox) = Inbox::with_mailbox();
            let carrier =
                SharedMemory::open(self.name.clone(), mailbox).map_err(NodeError::from)?;
            let carrier: Box<dyn Carrier> = Box::new(carrier);
            options.inbox = inbox;
            options.live.push(("shared memory".to_string(), carrier));
        }
        Ok(())
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
