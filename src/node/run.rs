//! A run: a scene, what it publishes to and listens to, and what came of it.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::clock::Stopwatch;
use super::drive::{Drive, End};
use super::live::Gauge;
use super::mode::Mode;
use super::pace::Pacer;
use super::recorder::Recorder;
use super::{About, Carrier, Destination, Inbox, Live, McapFile, NodeError, Pace, Summary};
use crate::scene::Scene;
use crate::sim::Simulation;

/// How a scene is run.
#[derive(Default)]
pub struct RunOptions {
    /// Where the recording goes, see [`Destination`]; none if nothing is recorded.
    pub output: Option<PathBuf>,
    /// Threads of the solver; results do not depend on it. 0 counts as 1.
    pub threads: usize,
    /// Set from outside (a signal handler) to end the run after the step at hand, recording closed properly.
    pub stop: Arc<AtomicBool>,
    /// Further carriers of the same bytes, which drop nothing: the run waits for them.
    pub carriers: Vec<Box<dyn Carrier>>,
    /// Carriers that the run never waits for, by name; see [`Live`].
    pub live: Vec<(String, Box<dyn Carrier>)>,
    /// What the world asks of the run.
    pub inbox: Inbox,
    /// How simulated time goes against the wall.
    pub pace: Pace,
    /// Whether the run starts paused; with [`Pace::Lockstep`] it always does.
    pub wait_for_start: bool,
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
/// `1 / output.mesh_rate`, rounded to whole outputs; besides, with the surface, the first and the last state and
/// any at which the run pauses. Orders are taken at step boundaries. The run ends with the scene's duration, by
/// order, by `options.stop`, or when it is paused and nobody is left who could say go. When a step diverges the
/// last good state is recorded, the recording closed, and the error returned.
pub fn run(
    scene: &Scene,
    options: RunOptions,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Summary, NodeError> {
    let watch = Stopwatch::start();
    let mut simulation = Simulation::new(scene, options.threads.max(1))?;
    let destination = options.output.as_deref().map(Destination::new);
    let mut carriers = options.carriers;
    let paused = options.wait_for_start || options.pace == Pace::Lockstep;
    if let Some(destination) = &destination {
        let about = About::run(simulation.model(), options.pace, paused);
        let file = McapFile::create(destination.clone(), simulation.model(), &about)?;
        carriers.push(Box::new(file));
    }
    let mut gauges = vec![];
    for (name, carrier) in options.live {
        let live = Live::start(&name, carrier)?;
        gauges.push(live.gauge());
        carriers.push(Box::new(live));
    }
    let obstacles = simulation.state().obstacles.clone();
    let recorder = Recorder::start(simulation.model().clone(), obstacles, carriers)?;
    let mut summary = Summary::new(options.pace);
    let pacer = Pacer::new(options.pace);
    let mut drive = Drive::new(
        &mut simulation,
        &recorder,
        options.inbox,
        pacer,
        &options.stop,
    );
    drive.gauges = &gauges;
    if paused {
        drive.mode = Mode::Paused;
    }
    let ended = drive.run(&mut |report| {
        summary.add(report);
        progress(&Progress {
            time: report.time,
            duration: scene.duration,
            step: report.step,
            wall_seconds: watch.wall_seconds(),
        });
    });
    summary.orders = drive.orders;
    summary.lateness = drive.pacer.lateness();
    recorder.finish()?;
    summary.stopped = ended? == End::Stopped;
    let names = scene.observe.keys().cloned();
    summary.readings = names
        .zip(simulation.report().readings.iter().copied())
        .collect();
    summary.live = gauges.iter().map(Gauge::tally).collect();
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
