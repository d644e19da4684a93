//! Error against CPU time of every method, step and mesh: each run becomes a [`Row`], also one that dies.
//!
//! The CPU clock is handed in, since nothing in this crate's core reads a clock; it counts the steps only,
//! not the building of mesh and matrices, in one thread.

use nalgebra::Vector2;

use super::course::{Course, CpuClock, Watch};
use super::reference::{Reference, ReferenceError};
use super::rows::{Asked, Key, Outcome, Parts, Row};
use crate::scene::{Method, MethodSpec, Scene, Scheme, Solver, StableLimit};
use crate::sim::Simulation;

/// A scene with an observed point, the times at which it is compared, and the steps and meshes to try.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Name of the chart and of its rows: the scene's, or that with the part of it that is looked at.
    pub name: String,
    /// The scene; its method, step and mesh are replaced in every run.
    pub scene: Scene,
    /// Points in the sheet's x, y \[m\]; their mean displacement is compared.
    pub points: Vec<Vector2<f64>>,
    /// What it is compared with; without one, [`Problem::make_reference`] runs it.
    pub reference: Option<Reference>,
    /// Comparison times of a reference still to be made \[s\].
    pub times: Vec<f64>,
    /// Length by which errors are divided \[m\]; without one, the largest displacement of the reference.
    pub length: Option<f64>,
    /// Implicit steps \[s\]; each divides every comparison time.
    pub steps: Vec<f64>,
    /// Meshes, by their number of triangles.
    pub meshes: Vec<usize>,
    /// Mesh of a reference still to be made.
    pub finest: usize,
    /// What a run may cost before it is left unfinished; references have no limit \[CPU-s\].
    pub budget: f64,
}

/// A scene that has no chart, or a reference that could not be had.
#[derive(Debug, thiserror::Error)]
pub enum ChartError {
    /// Nobody has said what to look at.
    #[error("scene `{0}` observes nothing that could be compared; give it an [observe.NAME]")]
    NoReference(String),
    /// The embedded reference is damaged.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// The run that was to be the reference died.
    #[error("the reference run of `{scene}` died at {time} s: {message}")]
    ReferenceDied {
        /// Scene.
        scene: String,
        /// When \[s\].
        time: f64,
        /// What it said.
        message: String,
    },
}

impl Problem {
    /// Times at which the problem is looked at \[s\].
    fn times(&self) -> &[f64] {
        self.reference.as_ref().map_or(&self.times, |r| &r.times)
    }

    /// The truth of one mesh: the explicit scheme at half its limit. What it differs from the run at the limit is
    /// three times its own error to be, and stands as its uncertainty.
    pub fn truth_on(&self, triangles: usize, watch: &mut Watch) -> Result<Reference, ChartError> {
        let mut runs = vec![];
        for (part, done, share) in [(2, 0.0, 0.67), (1, 0.67, 0.33)] {
            let key = self.key(
                Scheme::CentralDifference.into(),
                Asked::Limit(part),
                triangles,
            );
            let course = self.course(&key, self.times(), &mut || 0.0, &mut |f| {
                watch(done + share * f);
            });
            if let Some((time, message)) = course.died {
                let scene = self.scene.name.clone();
                return Err(ChartError::ReferenceDied {
                    scene,
                    time,
                    message,
                });
            }
            runs.push(course.displacements);
        }
        let apart = runs[0].iter().zip(&runs[1]).map(|(a, b)| (a - b).norm());
        Ok(Reference {
            times: self.times().to_vec(),
            uncertainty: apart.fold(0.0, f64::max),
            displacements: runs.swap_remove(0),
            source: format!("central-difference at half its limit, {triangles} triangles"),
        })
    }

    /// Makes the reference on the finest mesh. To its uncertainty counts a third of what it differs from a mesh of a
    /// quarter of the triangles, its error to be at second order.
    pub fn make_reference(&self, watch: &mut Watch) -> Result<Reference, ChartError> {
        let coarse = self.truth_on(self.finest / 4, &mut |f| watch(0.15 * f))?;
        let fine = self.truth_on(self.finest, &mut |f| watch(0.15 + 0.85 * f))?;
        let uncertainty = fine.uncertainty + fine.largest_distance(&coarse) / 3.0;
        Ok(Reference {
            uncertainty,
            ..fine
        })
    }

    /// Keys of every run, in the order to run them: the cheap ones first.
    pub fn plan(&self) -> Vec<Key> {
        let mut keys = vec![];
        let mut meshes = self.meshes.clone();
        meshes.sort_unstable();
        for triangles in meshes {
            for method in Method::IN_TIME {
                let asked: Vec<Asked> = match method.scheme {
                    Scheme::CentralDifference => {
                        vec![Asked::Past(2), Asked::Limit(1), Asked::Limit(2)]
                    }
                    _ => self.steps.iter().map(|dt| Asked::Step(*dt)).collect(),
                };
                keys.extend(
                    asked
                        .into_iter()
                        .map(|asked| self.key(method, asked, triangles)),
                );
            }
        }
        keys
    }

    /// The key of a run.
    pub fn key(&self, method: Method, asked: Asked, triangles: usize) -> Key {
        Key {
            scene: self.name.clone(),
            fabric: self.scene.fabric.name.clone(),
            mesh: format!("triangles={triangles}"),
            method,
            asked,
        }
    }

    /// Length by which errors are divided \[m\].
    pub fn error_length(&self, reference: &Reference) -> f64 {
        self.length.unwrap_or_else(|| reference.largest())
    }

    /// Runs one key against a reference, and against the truth of its own mesh if that is given; then a run of Newton's
    /// is repeated with a thousandth of its tolerance, to see what its equations are not solved by.
    pub fn run(
        &self,
        key: &Key,
        (reference, own): (&Reference, Option<&Reference>),
        cpu: &mut CpuClock,
        watch: &mut Watch,
    ) -> Row {
        let course = self.course(key, &reference.times, cpu, watch);
        let length = self.error_length(reference);
        let seen = |course: &Course| Reference {
            displacements: course.displacements.clone(),
            ..reference.clone()
        };
        let mine = seen(&course);
        let mut parts = Parts::default();
        let whole = course.died.is_none() && !course.unfinished;
        if let (Some(own), true) = (own, whole) {
            parts.time = Some(mine.largest_distance(own) / length);
            parts.space = Some(own.largest_distance(reference) / length);
            parts.algebra = self.algebra(key, &mine, cpu).map(|error| error / length);
        }
        let outcome = match course.died {
            Some((time, message)) => Outcome::Died { time, message },
            None if course.unfinished => Outcome::Unfinished {
                time: course.simulated,
            },
            None => Outcome::Done {
                error: mine.largest_distance(reference) / length,
            },
        };
        Row {
            key: key.clone(),
            triangles: course.triangles,
            dt: course.simulated.max(course.asked_dt) / course.sum.work.substeps.max(1) as f64,
            tolerance: self.scene.method.tolerance,
            outcome,
            cpu: course.cpu,
            simulated: course.simulated,
            steps: course.sum.step,
            starved: course.starved,
            work: course.sum.work,
            parts,
        }
    }

    /// How far a run of Newton's is from one with a thousandth of the tolerance \[m\]; not known if that dies or costs
    /// too much.
    fn algebra(&self, key: &Key, mine: &Reference, cpu: &mut CpuClock) -> Option<f64> {
        let explicit = key.method.scheme == Scheme::CentralDifference;
        if explicit || key.method.solver != Solver::Newton {
            return None;
        }
        let mut exact = self.clone();
        exact.scene.method.tolerance = (1e-3 * exact.scene.method.tolerance).max(1e-10);
        let course = exact.course(key, &mine.times, cpu, &mut |_| {});
        (course.died.is_none() && !course.unfinished).then(|| {
            let exact = Reference {
                displacements: course.displacements,
                ..mine.clone()
            };
            mine.largest_distance(&exact)
        })
    }

    /// Runs a key and looks at the observed point at the given times.
    fn course(&self, key: &Key, times: &[f64], cpu: &mut CpuClock, watch: &mut Watch) -> Course {
        let ready = self.scene_of(key).and_then(|scene| {
            let simulation = start(&scene)?;
            Ok((scene.method.dt, simulation))
        });
        match ready {
            Ok((dt, simulation)) => {
                let purse = (cpu, self.budget);
                Course::run(simulation, dt, &self.points, times, purse, watch)
            }
            Err(message) => Course::stillborn(message),
        }
    }

    /// The scene of a key. Shares and multiples of the explicit limit are of the substep that the scheme chooses; a step
    /// given to the explicit scheme is its substep, stable or not.
    pub fn scene_of(&self, key: &Key) -> Result<Scene, String> {
        let triangles = key.mesh.strip_prefix("triangles=");
        let mut scene = match triangles.and_then(|count| count.parse().ok()) {
            Some(count) => self.scene.on_mesh(count),
            None => self.scene.clone(),
        };
        // Reports cost time, too: no more of them than the longest step makes.
        let longest = self.steps.iter().copied().fold(0.0, f64::max);
        scene.method = MethodSpec {
            dt: longest,
            substep: None,
            ..scene.method.with(key.method)
        };
        let limit = |scene: &Scene| {
            Ok::<_, String>(start(scene)?.substep().unwrap_or(longest).min(longest))
        };
        let step = match key.asked {
            Asked::Step(dt) => dt,
            Asked::Past(times) => f64::from(times) * limit(&scene)?,
            Asked::Limit(1) => return Ok(scene),
            Asked::Limit(part) => {
                let parts = (longest / limit(&scene)?).ceil() * f64::from(part);
                scene.method.substep = Some(longest / parts);
                return Ok(scene);
            }
        };
        scene.method.dt = step;
        if key.method.scheme == Scheme::CentralDifference {
            scene.method.substep = Some(step);
            scene.method.limit = StableLimit::Ignore;
        }
        Ok(scene)
    }
}

/// One thread, so that CPU time is the time of the method.
fn start(scene: &Scene) -> Result<Simulation, String> {
    Simulation::new(scene, 1).map_err(|refused| refused.to_string())
}

/// What a progress bar calls a run.
pub fn label(key: &Key) -> String {
    let step = match key.asked {
        Asked::Step(dt) => format!("{:.3} ms", dt * 1e3),
        Asked::Limit(1) => "at its limit".to_string(),
        Asked::Limit(part) => format!("at 1/{part} of its limit"),
        Asked::Past(times) => format!("at {times} times its limit"),
    };
    format!("{} {} {} {step}", key.scene, key.mesh, key.method.name())
}
