//! The only wall clock.

use std::time::Instant;

use cpu_time::ProcessTime;

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
