//! What a run came to: the reports of its steps, added up.

use std::path::PathBuf;

use serde::Serialize;

use super::{Lateness, LiveTally, Pace};
use crate::sim::{Energies, StepReport, Work};

/// A quantity of every step, in the unit of its field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Peak {
    /// Largest value of the run.
    pub largest: f64,
    /// Value of the last step.
    pub end: f64,
}

impl Peak {
    fn add(&mut self, value: f64) {
        self.largest = self.largest.max(value);
        self.end = value;
    }
}

/// When layers of the sheet touched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Layers {
    /// End of the first step after which they did \[s\].
    pub from: Option<f64>,
    /// After how many steps they did.
    pub steps: u64,
}

/// What became of the orders that came in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Orders {
    /// Taken.
    pub applied: u64,
    /// Understood, but not what the scene or the state allows.
    pub rejected: u64,
    /// Not understood.
    pub malformed: u64,
    /// Lost because too many were waiting.
    pub dropped: u64,
    /// Waiting when the run was over.
    pub late: u64,
}

/// What a run came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Steps taken.
    pub steps: u64,
    /// Simulated time \[s\].
    pub time: f64,
    /// Whether the run was stopped from outside before its end.
    pub stopped: bool,
    /// Steps that the sheet slept through.
    pub slept: u64,
    /// Work of all steps.
    pub work: Work,
    /// Energy ledger at the end \[J\].
    pub energies: Energies,
    /// Readings at the end, named by the scene \[m\].
    pub readings: Vec<(String, f64)>,
    /// Largest principal membrane strain, absolute \[-\].
    pub largest_strain: Peak,
    /// Deepest penetration into an obstacle \[m\].
    pub deepest_penetration: Peak,
    /// Most edges of the sheet that passed through its faces after a step.
    pub crossings: u64,
    /// When layers touched, whether the scene has them or not.
    pub layers: Layers,
    /// Terms that the scene leaves out and should not, each with the time at which that showed \[s\].
    pub neglected: Vec<(&'static str, f64)>,
    /// Whether every step converged.
    pub converged: bool,
    /// Digest of the last state.
    pub digest: u64,
    /// How simulated time went against the wall.
    pub pace: Pace,
    /// How late a paced run was.
    pub lateness: Lateness,
    /// Orders that came in.
    pub orders: Orders,
    /// Live carriers.
    pub live: Vec<LiveTally>,
    /// Wall time \[s\].
    pub wall_seconds: f64,
    /// CPU time of the whole process, recording included \[s\].
    pub cpu_seconds: f64,
    /// The recording, if there is one.
    pub recording: Option<PathBuf>,
    /// Its size \[bytes\].
    pub recording_bytes: u64,
}

impl Summary {
    /// Of a run that has taken no step.
    pub(super) fn new(pace: Pace) -> Self {
        Self {
            pace,
            converged: true,
            ..Self::default()
        }
    }

    /// Counts a step.
    pub(super) fn add(&mut self, report: &StepReport) {
        self.steps = report.step;
        self.time = report.time;
        self.slept += u64::from(report.work == Work::default());
        self.work += report.work;
        self.crossings = self.crossings.max(report.crossings);
        if report.layer_contacts > 0 {
            self.layers.from.get_or_insert(report.time);
            self.layers.steps += 1;
        }
        for &term in &report.neglected {
            if !self.neglected.iter().any(|(name, _)| *name == term) {
                self.neglected.push((term, report.time));
            }
        }
        self.energies = report.energies;
        self.largest_strain.add(report.largest_strain);
        self.deepest_penetration.add(report.deepest_penetration);
        self.converged &= report.converged;
        self.digest = report.digest;
    }
}
