//! A run that is measured: its cost by parts, what it leaves out, what it observes.

use nalgebra::Vector3;

use super::CliError;
use super::explain::cpu;
use super::progress::share_bar;
use crate::scene::{Scene, Term};
use crate::sim::{Neglects, Refused, Simulation, Work};

/// Least time over which the unit of a part is measured \[s\].
const LONG_ENOUGH: f64 = 0.02;
/// Looks at what is left out in a run.
const LOOKS: u64 = 20;

/// A finished run.
pub(super) struct Trial {
    pub simulation: Simulation,
    pub work: Work,
    pub neglects: Neglects,
    /// CPU time of the steps alone, one thread \[s\].
    pub cpu: f64,
    /// What stopped it early.
    pub died: Option<String>,
    /// Readings after each step \[m\]; where a scene observes nothing, how far the vertices are from the start (root of
    /// the mean square).
    pub observed: Vec<Vec<f64>>,
}

/// What one part of the steps cost.
pub(super) struct Cost {
    pub name: String,
    pub term: Option<Term>,
    /// Of the CPU time of all steps \[-\].
    pub share: f64,
    pub count: u64,
    /// Time of one unit \[s\].
    pub unit: f64,
}

impl Trial {
    /// Runs a scene to its end, or to its death.
    pub fn run(scene: &Scene, label: &str) -> Result<Self, CliError> {
        let refused = |refused: Refused| CliError::Input(refused.to_string());
        let simulation = Simulation::new(scene, 1).map_err(refused)?;
        let start = simulation.state().positions.clone();
        let mut trial = Self {
            simulation,
            work: Work::default(),
            neglects: Neglects::new(),
            cpu: 0.0,
            died: None,
            observed: vec![],
        };
        let bar = share_bar(label);
        let steps = scene.steps();
        for step in 1..=steps {
            let before = cpu();
            let taken = trial.simulation.step().map(|report| report.work);
            trial.cpu += cpu() - before;
            match taken {
                Ok(work) => trial.work += work,
                Err(diverged) => {
                    trial.died = Some(diverged.to_string());
                    break;
                }
            }
            trial.observe(&start);
            if step % steps.div_ceil(LOOKS) == 0 || step == steps {
                trial.neglects.look(&trial.simulation);
            }
            bar.set_position(1000 * step / steps);
        }
        bar.finish_and_clear();
        Ok(trial)
    }

    fn observe(&mut self, start: &[Vector3<f64>]) {
        let report = self.simulation.report();
        let mut seen = report.readings.clone();
        if seen.is_empty() {
            let places = &self.simulation.state().positions;
            let squares: f64 = places
                .iter()
                .zip(start)
                .map(|(a, b)| (a - b).norm_squared())
                .sum();
            seen.push((squares / start.len() as f64).sqrt());
        }
        self.observed.push(seen);
    }

    /// What each part cost, the dearest first, and the rest.
    pub fn costs(&self) -> Vec<Cost> {
        let mut costs: Vec<Cost> = vec![];
        for mut part in self.simulation.parts(&self.work) {
            let unit = time_of(&mut part.once);
            let name = match part.term {
                Some(term) => format!("{term} {}", part.name),
                None => part.name.to_string(),
            };
            costs.push(Cost {
                name,
                term: part.term,
                share: unit * part.count as f64 / self.cpu.max(f64::MIN_POSITIVE),
                count: part.count,
                unit,
            });
        }
        costs.sort_by(|a, b| b.share.total_cmp(&a.share));
        let known: f64 = costs.iter().map(|c| c.share).sum();
        let steps = self.observed.len() as u64;
        let share = (1.0 - known).max(0.0);
        costs.push(Cost {
            name: "the rest (advance, ledger, copies)".to_string(),
            term: None,
            share,
            count: steps,
            unit: share * self.cpu / steps.max(1) as f64,
        });
        costs
    }
}

/// Mean time of one unit \[s\].
fn time_of(once: &mut dyn FnMut()) -> f64 {
    let start = cpu();
    let mut count = 0u32;
    loop {
        once();
        count += 1;
        let spent = cpu() - start;
        if spent > LONG_ENOUGH {
            return spent / f64::from(count);
        }
    }
}

/// A time as people read it.
pub(super) fn seconds(time: f64) -> String {
    let (value, unit) = match time {
        t if t < 1e-3 => (1e6 * t, "µs"),
        t if t < 1.0 => (1e3 * t, "ms"),
        t => (t, "s"),
    };
    format!("{} {unit}", super::output::significant(value, 3))
}
