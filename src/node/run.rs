//! The loop: step, publish, until the scene's duration is over or somebody says stop.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::clock::Stopwatch;
use super::recorder::{Instant, Recorder};
use super::{Carrier, Destination, McapFile, NodeError, Summary};
use crate::scene::Scene;
use crate::sim::{Simulation, StepReport};

/// How a scene is run.
#[derive(Default)]
pub struct RunOptions {
    /// Where the recording goes, see [`Destination`]; none if nothing is recorded.
    pub output: Option<PathBuf>,
    /// Threads of the solver; results do not depend on it. 0 counts as 1.
    pub threads: usize,
    /// Set from outside (a signal handler) to end the run after the step at hand, recording closed properly.
    pub stop: Arc<AtomicBool>,
    /// Further carriers of the same bytes.
    pub carriers: Vec<Box<dyn Carrier>>,
}

/// Where a run is, after each step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Simulated time \[s\].
    pub time: f64,
    /// Simulated time at the end \[s\].
    pub duration: f64,
    /// Steps taken.
    pub step: u64,
    /// Wall time since the start \[s\].
    pub wall_seconds: f64,
}

/// Runs a checked scene to its end.
///
/// A state is published every `1 / output.rate`, rounded to whole steps, the surface every
/// `1 / output.mesh_rate`, rounded to whole outputs; the first and the last state always, with the surface.
/// When a step diverges the last good state is recorded, the recording closed, and the error returned.
pub fn run(
    scene: &Scene,
    options: RunOptions,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Summary, NodeError> {
    let watch = Stopwatch::start();
    let mut simulation = Simulation::new(scene, options.threads.max(1))?;
    let destination = options.output.as_deref().map(Destination::new);
    let mut carriers = options.carriers;
    if let Some(destination) = &destination {
        let file = McapFile::create(destination.clone(), simulation.model())?;
        carriers.push(Box::new(file));
    }
    let obstacles = simulation.state().obstacles.clone();
    let recorder = Recorder::start(simulation.model().clone(), obstacles, carriers)?;
    let mut summary = Summary::new();
    let stepped = advance(&mut simulation, &recorder, &options.stop, &mut |report| {
        summary.add(report);
        progress(&Progress {
            time: report.time,
            duration: scene.duration,
            step: report.step,
            wall_seconds: watch.wall_seconds(),
        });
    });
    recorder.finish()?;
    summary.stopped = stepped? == End::Stopped;
    let names = scene.observe.keys().cloned();
    summary.readings = names
        .zip(simulation.report().readings.iter().copied())
        .collect();
    summary.recording = destination.map(|d| d.file().to_path_buf());
    let size = summary
        .recording
        .as_deref()
        .and_then(|path| path.metadata().ok());
    summary.recording_bytes = size.map_or(0, |metadata| metadata.len());
    summary.wall_seconds = watch.wall_seconds();
    summary.cpu_seconds = watch.cpu_seconds();
    Ok(summary)
}

/// Why the loop ended without an error of the physics.
#[derive(PartialEq, Eq)]
enum End {
    /// All steps taken, or the recorder gave up (which its own error explains).
    Done,
    /// The stop flag.
    Stopped,
}

/// Steps to the end, publishing at the scene's rates.
fn advance(
    simulation: &mut Simulation,
    recorder: &Recorder,
    stop: &AtomicBool,
    after_step: &mut dyn FnMut(&StepReport),
) -> Result<End, NodeError> {
    let schedule = Schedule::new(&simulation.model().scene);
    let mut open = recorder.publish(instant(simulation, schedule.with_mesh));
    for step in 1..=schedule.steps {
        if !open {
            return Ok(End::Done);
        }
        let report = match simulation.step() {
            Ok(report) => report,
            Err(diverged) => {
                if !schedule.output(step - 1) {
                    recorder.publish(instant(simulation, schedule.with_mesh));
                }
                return Err(diverged.into());
            }
        };
        after_step(report);
        let stopped = stop.load(Ordering::Relaxed) && step < schedule.steps;
        let last = stopped || step == schedule.steps;
        if last || schedule.output(step) {
            let with_mesh = schedule.with_mesh && (last || schedule.mesh(step));
            open = recorder.publish(instant(simulation, with_mesh));
        }
        if stopped {
            return Ok(End::Stopped);
        }
    }
    Ok(End::Done)
}

fn instant(simulation: &Simulation, with_mesh: bool) -> Instant {
    Instant {
        state: simulation.state().clone(),
        report: simulation.report().clone(),
        with_mesh,
    }
}

/// Which steps are published.
struct Schedule {
    steps: u64,
    /// Steps between outputs.
    output: u64,
    /// Steps between surfaces.
    mesh: u64,
    with_mesh: bool,
}

impl Schedule {
    fn new(scene: &Scene) -> Self {
        let output = scene.output_steps();
        let interval = 1.0 / (scene.output.mesh_rate * scene.method.dt);
        let surfaces = ((interval / output as f64).round() as u64).max(1);
        Self {
            steps: scene.steps(),
            output,
            mesh: output.saturating_mul(surfaces),
            with_mesh: scene.output.mesh_rate > 0.0,
        }
    }

    fn output(&self, step: u64) -> bool {
        step.is_multiple_of(self.output)
    }

    fn mesh(&self, step: u64) -> bool {
        step.is_multiple_of(self.mesh)
    }
}
