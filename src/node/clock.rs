//! The only wall clock.

use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use serde::Serialize;

/// Measures wall and CPU time of the whole process since its start.
pub struct Stopwatch {
    wall: Instant,
    cpu: Option<ProcessTime>,
}

impl Stopwatch {
    /// Starts now.
    pub fn start() -> Self {
        Self {
            wall: Instant::now(),
            cpu: ProcessTime::try_now().ok(),
        }
    }

    /// Wall time \[s\].
    pub fn wall_seconds(&self) -> f64 {
        self.wall.elapsed().as_secs_f64()
    }

    /// CPU time of all threads \[s\]; zero where the system does not say.
    pub fn cpu_seconds(&self) -> f64 {
        let elapsed = self.cpu.as_ref().and_then(|start| start.try_elapsed().ok());
        elapsed.map_or(0.0, |time| time.as_secs_f64())
    }
}

/// Longest lag that is caught up with \[s\]; what is behind by more is given up, not raced through.
const MOST_LAG: f64 = 0.1;
/// Longest sleep, so that a stop is noticed \[s\].
const NAP: f64 = 0.05;

/// When the steps of a paced run are due: simulated time against the wall.
pub struct Metronome {
    /// Simulated seconds per second of the wall.
    factor: f64,
    /// Time of the watch at simulated time zero \[s\], had nothing been late.
    zero: f64,
    watch: Instant,
    lateness: Lateness,
}

/// How late a paced run was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Lateness {
    /// Steps that ended after they were due.
    pub overruns: u64,
    /// The latest of them \[s\] of the wall.
    pub worst: f64,
    /// Time given up for good \[s\] of the wall: simulated time lags behind the wall by as much.
    pub slipped: f64,
}

impl Metronome {
    /// Of `factor` simulated seconds per second.
    pub fn new(factor: f64) -> Self {
        Self {
            factor,
            zero: 0.0,
            watch: Instant::now(),
            lateness: Lateness::default(),
        }
    }

    /// The run goes on from a simulated time \[s\] now; whatever passed on the wall before does not count.
    pub fn restart(&mut self, time: f64) {
        self.zero = self.watch.elapsed().as_secs_f64() - time / self.factor;
    }

    /// Sleeps until a boundary at a simulated time \[s\] is due, or `stopped`; counts it if it is late already.
    pub fn wait(&mut self, time: f64, stopped: &dyn Fn() -> bool) {
        let due = self.zero + time / self.factor;
        let late = self.watch.elapsed().as_secs_f64() - due;
        if late > 0.0 {
            self.lateness.overruns += 1;
            self.lateness.worst = self.lateness.worst.max(late);
            if late > MOST_LAG {
                self.lateness.slipped += late;
                self.zero += late;
            }
            return;
        }
        loop {
            let left = due - self.watch.elapsed().as_secs_f64();
            if left <= 0.0 || stopped() {
                return;
            }
            std::thread::sleep(Duration::from_secs_f64(left.min(NAP)));
        }
    }

    /// How late the run was so far.
    pub fn lateness(&self) -> Lateness {
        self.lateness
    }
}
