//! Replay: the recorded commands at their steps, through the very loop of a run, and every message compared.
//!
//! Each report holds a digest of the whole state, and each state follows from the one before. So a digest covers
//! all steps since the one before it: reports at the output rate are enough to say that no step differs, and
//! narrow a difference down to the steps between two of them.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use serde::Serialize;

use super::clock::Stopwatch;
use super::compare::{Comparer, Verdict};
use super::difference::{Difference, What};
use super::drive::Drive;
use super::mode::Mode;
use super::pace::Pacer;
use super::recorder::Recorder;
use super::records::Span;
use super::{About, Inbox, NodeError, Order, Pace, Progress, Recording};
use crate::sim::Simulation;
use crate::wire::messages::toile_msgs::AppliedCommand;
use crate::wire::{inbound, nanoseconds};

/// How a recording is replayed.
#[derive(Clone, Debug, Default)]
pub struct ReplayOptions {
    /// Starts from the last keyframe at or before this step; from the start if there is none.
    pub from: Option<u64>,
    /// Threads of the solver; results do not depend on it. 0 counts as 1.
    pub threads: usize,
    /// Set from outside to end the replay early.
    pub stop: Arc<AtomicBool>,
}

/// What a replay came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Replay {
    /// The step that it started from.
    pub from: u64,
    /// The last step.
    pub to: u64,
    /// States compared.
    pub states: u64,
    /// Commands compared.
    pub commands: u64,
    /// How the recording was made.
    pub recorded: About,
    /// This build and processor.
    pub here: About,
    /// Whether every bit had to be the same: the recording is of this build and processor.
    pub strict: bool,
    /// The first place where bits differ; within the tolerance unless there is a `difference`.
    pub bits: Option<Difference>,
    /// The first place that differs by more than it may; none if the replay agrees.
    pub difference: Option<Difference>,
    /// Largest distance between a vertex and its recorded position \[m\].
    pub largest: f64,
}

/// Replays a recording to its end, from its start or from a keyframe.
pub fn replay(
    path: &Path,
    options: &ReplayOptions,
    progress: &mut dyn FnMut(&Progress),
) -> Result<Replay, NodeError> {
    let watch = Stopwatch::start();
    let recording = Recording::open(path)?;
    let scene = recording.scene();
    let mut simulation = Simulation::new(scene, options.threads.max(1))?;
    let here = About::run(simulation.model(), Pace::Free, false);
    let strict = recording.about().same_bits(&here);
    let start = Start::new(&recording, options.from, &mut simulation)?;
    let verdict = Arc::new(Mutex::new(Verdict::default()));
    let comparer = Comparer {
        recorded: recording.scan(start.chunk)?,
        strict,
        from: start.stamp,
        dt: scene.method.dt,
        verdict: Arc::clone(&verdict),
        stop: Arc::clone(&options.stop),
        ended: false,
    };
    let obstacles = simulation.state().obstacles.clone();
    let recorder = Recorder::start(
        simulation.model().clone(),
        obstacles,
        vec![Box::new(comparer)],
    )?;
    let inbox = Inbox::default().scripted(orders(&recording, start.step)?);
    let pacer = Pacer::new(Pace::Free);
    let mut drive = Drive::new(&mut simulation, &recorder, inbox, pacer, &options.stop);
    drive.schedule.halt = Some(recording.last_step());
    drive.mode = start.mode;
    let end = recording.last_step();
    let ended = drive.run(&mut |report| {
        progress(&Progress {
            time: report.time,
            duration: end as f64 * report.dt,
            step: report.step,
            wall_seconds: watch.wall_seconds(),
        });
    });
    let stopped = options.stop.load(Ordering::Relaxed);
    recorder.finish()?;
    let mut verdict = verdict
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .clone();
    // What is missing after a stop from outside is no difference.
    let difference = verdict.difference.as_ref().map(|d| &d.what);
    if stopped && matches!(difference, None | Some(What::Missing { .. })) {
        let (step, last) = (simulation.state().step, recording.last_step());
        return Err(NodeError::ReplayStopped { step, last });
    }
    if let Err(NodeError::Diverged(diverged)) = &ended {
        // Where it stopped is before whatever else is missing.
        verdict.difference = Some(Difference {
            step: diverged.step,
            time: diverged.time,
            what: What::Diverged(diverged.to_string()),
        });
    } else {
        ended?;
    }
    Ok(Replay {
        from: start.step,
        to: simulation.state().step,
        states: verdict.states,
        commands: verdict.commands,
        recorded: recording.about().clone(),
        here,
        strict,
        bits: verdict.bits,
        difference: verdict.difference,
        largest: verdict.largest,
    })
}

/// Where a replay starts.
struct Start {
    step: u64,
    /// \[ns\]
    stamp: u64,
    /// The first chunk to compare with; the first of all if not given.
    chunk: Option<Span>,
    mode: Mode,
}

impl Start {
    /// Takes the simulation to where the replay starts.
    fn new(
        recording: &Recording,
        from: Option<u64>,
        simulation: &mut Simulation,
    ) -> Result<Self, NodeError> {
        let kept = match from {
            Some(step) => recording.kept(step)?,
            None => None,
        };
        let mut start = Self {
            step: 0,
            stamp: 0,
            chunk: None,
            mode: mode_at(recording, 0),
        };
        if let Some((state, span)) = kept {
            start.step = state.step;
            start.stamp = nanoseconds(state.step as f64 * recording.scene().method.dt);
            start.chunk = Some(span);
            start.mode = mode_at(recording, state.step);
            let resumed = simulation.resume(state);
            resumed.map_err(|error| NodeError::unreadable(recording.path(), error))?;
        }
        Ok(start)
    }
}

/// Whether the run went on or stood when a step had been taken, before the orders at that boundary.
fn mode_at(recording: &Recording, step: u64) -> Mode {
    let mut mode = match recording.about().paused {
        true => Mode::Paused,
        false => Mode::Running,
    };
    let earlier = recording.commands().iter().filter(|c| c.step < step);
    for command in earlier.filter(|c| c.accepted) {
        let request = inbound::find(&command.channel)
            .and_then(|inlet| inbound::decode(inlet, &command.payload).ok());
        if let Some(request) = request {
            mode = mode.at(command.step).after(&request, command.step);
        }
    }
    mode.at(step)
}

/// The recorded commands as they came in, from a step on.
fn orders(recording: &Recording, from: u64) -> Result<Vec<(u64, Order)>, NodeError> {
    let order = |command: &AppliedCommand| {
        let inlet = inbound::find(&command.channel).ok_or_else(|| {
            let reason = format!("a command on {}, which is not known", command.channel);
            NodeError::unreadable(recording.path(), reason)
        })?;
        let order = Order {
            inlet,
            bytes: command.payload.clone(),
            reply: None,
        };
        Ok((command.step, order))
    };
    let commands = recording.commands().iter();
    commands.filter(|c| c.step >= from).map(order).collect()
}
