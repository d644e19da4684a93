//! A run that is watched: where the observed point is at given times, what the steps cost, and how it died.

use nalgebra::{Vector2, Vector3};

use crate::sim::{Probe, Simulation, StepReport};

/// CPU time of this process \[s\].
pub type CpuClock<'a> = dyn FnMut() -> f64 + 'a;

/// Called now and then with the finished share of a run, 0 to 1.
pub type Watch<'a> = dyn FnMut(f64) + 'a;

/// A run as it went.
#[derive(Default)]
pub(super) struct Course {
    /// Triangles of the mesh.
    pub triangles: usize,
    /// Step that was asked for \[s\]; 0 if there was none.
    pub asked_dt: f64,
    /// Displacement of the observed point \[m\] at each of the times that were reached.
    pub displacements: Vec<Vector3<f64>>,
    /// When \[s\] and of what it died, if it did.
    pub died: Option<(f64, String)>,
    /// Whether it was left before the last of the times, since it cost too much.
    pub unfinished: bool,
    /// CPU time of the steps \[s\].
    pub cpu: f64,
    /// Simulated time \[s\].
    pub simulated: f64,
    /// Steps, and the work of all of them.
    pub sum: StepReport,
    /// Steps that ended above the tolerance.
    pub starved: u64,
}

impl Course {
    /// A run that could not begin.
    pub fn stillborn(message: String) -> Self {
        Self {
            died: Some((0.0, message)),
            ..Self::default()
        }
    }

    /// Steps of `dt` \[s\] up to the last of `times` \[s\], to its death, or until they have cost `budget` \[CPU-s\].
    /// The mean displacement of `points`, in the sheet's x, y \[m\], is noted at each of the times.
    pub fn run(
        mut simulation: Simulation,
        dt: f64,
        points: &[Vector2<f64>],
        times: &[f64],
        (cpu, budget): (&mut CpuClock, f64),
        watch: &mut Watch,
    ) -> Self {
        let probe = Probe::at(&simulation.model().mesh, points);
        let origin = probe.read(&simulation.state().positions);
        let mut course = Self {
            triangles: simulation.model().mesh.faces.len(),
            asked_dt: dt,
            ..Self::default()
        };
        let last = times.iter().copied().fold(0.0, f64::max);
        let mut times = times.iter().copied().peekable();
        for step in 1..=(last / dt).round() as u64 {
            let time = step as f64 * dt;
            let before = cpu();
            let taken = simulation.step().cloned();
            course.cpu += cpu() - before;
            let here = probe.read(&simulation.state().positions) - origin;
            match taken {
                Err(diverged) => course.died = Some((diverged.time, diverged.to_string())),
                Ok(_) if !here.iter().all(|x| x.is_finite()) => {
                    course.died = Some((time, "positions are not finite".to_string()));
                }
                Ok(report) => course.count(&report, time),
            }
            if course.died.is_some() {
                return course;
            }
            if times.next_if(|t| (t - time).abs() < 1e-3 * dt).is_some() {
                course.displacements.push(here);
            }
            watch(time / last);
            if course.cpu > budget && times.peek().is_some() {
                course.unfinished = true;
                return course;
            }
        }
        if times.peek().is_some() {
            let missed = "its steps miss a time of the reference".to_string();
            course.died = Some((course.simulated, missed));
        }
        course
    }

    /// Adds a step that ends at `time` \[s\] and went well.
    fn count(&mut self, report: &StepReport, time: f64) {
        self.simulated = time;
        self.sum.step += 1;
        self.sum.work += report.work;
        self.starved += u64::from(!report.converged);
    }
}
