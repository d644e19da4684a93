//! Error against CPU time of every scheme and step: each run becomes a [`Row`], also one that dies.
//!
//! The CPU clock is handed in, since nothing in this crate's core reads a clock; it counts the steps only,
//! not the building of mesh and matrices, in one thread.

use nalgebra::Vector2;

use super::course::{Course, CpuClock, Watch};
use super::reference::{Reference, ReferenceError};
use super::rows::{Asked, Key, Outcome, Row};
use crate::scene::{MethodSpec, Perturbation, Scene, Scheme};
use crate::sheet::Outline;
use crate::sim::Simulation;

/// A scene with an observed point, the times at which it is compared, and the steps to try.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The scene; its scheme and step are replaced in every run.
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
}

/// A scene that has no chart, or a reference that could not be had.
#[derive(Debug, thiserror::Error)]
pub enum ChartError {
    /// Nobody has said what to compare it with.
    #[error("scene `{0}` has no reference; there are `strip-release` and `four-edges`")]
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
    /// The chart that belongs to a scene, by its name.
    pub fn of(scene: Scene) -> Result<Self, ChartError> {
        match scene.name.as_str() {
            "strip-release" => Ok(Self::strip_release(scene)?),
            "four-edges" => Ok(Self::four_edges(scene)),
            name => Err(ChartError::NoReference(name.to_string())),
        }
    }

    /// A horizontal strip is let go; its tip against an independent code.
    fn strip_release(mut scene: Scene) -> Result<Self, ChartError> {
        scene.duration = 0.3;
        scene.damping = 0.0;
        scene.gravity = [0.0, 0.0, -9.80665];
        scene.perturbation = Perturbation::default();
        let Outline::Rectangle { length, width } = scene.sheet.outline else {
            return Err(ChartError::NoReference(scene.name));
        };
        Ok(Self {
            scene,
            points: [-1.0, -0.5, 0.0, 0.5, 1.0]
                .map(|s| 0.5 * Vector2::new(length, s * width))
                .to_vec(),
            reference: Some(Reference::strip_release()?),
            times: vec![],
            length: Some(length),
            steps: vec![10e-3, 5e-3, 2e-3, 1e-3, 0.5e-3],
        })
    }

    /// A square pinned along its boundary falls into its sag; its centre against small explicit steps.
    fn four_edges(mut scene: Scene) -> Self {
        scene.duration = 0.1;
        scene.damping = 0.1;
        scene.sheet.triangles = Some(800);
        scene.sheet.edge = None;
        scene.perturbation = Perturbation::default();
        Self {
            scene,
            points: vec![Vector2::zeros()],
            reference: None,
            times: (1..=20).map(|k| f64::from(k) * 5e-3).collect(),
            length: None,
            steps: vec![5e-3, 2.5e-3, 1e-3, 0.5e-3, 0.25e-3],
        }
    }

    /// Makes the reference with the explicit scheme at a quarter of its limit; what it differs from the run at
    /// half the limit, which is three times its own error to be, is its uncertainty.
    pub fn make_reference(&self, watch: &mut Watch) -> Result<Reference, ChartError> {
        let mut runs = vec![];
        for (part, done, share) in [(4, 0.0, 0.67), (2, 0.67, 0.33)] {
            let key = self.key(Scheme::CentralDifference, Asked::Limit(part));
            let course = self.course(&key, &self.times, &mut || 0.0, &mut |f| {
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
            times: self.times.clone(),
            uncertainty: apart.fold(0.0, f64::max),
            displacements: runs.swap_remove(0),
            source: "central-difference at a quarter of its limit, same mesh".to_string(),
        })
    }

    /// Keys of every run, in the order to run them: the cheap ones first.
    pub fn plan(&self) -> Vec<Key> {
        let mut keys = vec![];
        for scheme in Scheme::IN_TIME {
            match scheme {
                Scheme::CentralDifference => {
                    keys.extend([1, 2].map(|part| self.key(scheme, Asked::Limit(part))));
                }
                _ => keys.extend(
                    self.steps
                        .iter()
                        .map(|dt| self.key(scheme, Asked::Step(*dt))),
                ),
            }
        }
        keys
    }

    fn key(&self, scheme: Scheme, asked: Asked) -> Key {
        let sheet = &self.scene.sheet;
        let mesh = match (sheet.triangles, sheet.edge) {
            (Some(n), _) => format!("triangles={n}"),
            (None, Some(edge)) => format!("edge={edge}"),
            (None, None) => "default".to_string(),
        };
        Key {
            scene: self.scene.name.clone(),
            fabric: self.scene.fabric.name.clone(),
            mesh,
            scheme,
            asked,
        }
    }

    /// Length by which errors are divided \[m\].
    pub fn error_length(&self, reference: &Reference) -> f64 {
        self.length.unwrap_or_else(|| reference.largest())
    }

    /// Runs one key against a reference.
    pub fn run(
        &self,
        key: &Key,
        reference: &Reference,
        cpu: &mut CpuClock,
        watch: &mut Watch,
    ) -> Row {
        let course = self.course(key, &reference.times, cpu, watch);
        let apart = course.displacements.iter().zip(&reference.displacements);
        let worst = apart.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        let outcome = match course.died {
            Some((time, message)) => Outcome::Died { time, message },
            None => Outcome::Done {
                error: worst / self.error_length(reference),
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
            substeps: course.sum.work.substeps,
            rejected: course.sum.work.rejected,
            iterations: course.sum.work.iterations,
            factorisations: course.sum.work.factorisations,
        }
    }

    /// Runs a key and looks at the observed point at the given times.
    fn course(&self, key: &Key, times: &[f64], cpu: &mut CpuClock, watch: &mut Watch) -> Course {
        let ready = self.method_of(key).and_then(|method| {
            let simulation = start(&self.with(method))?;
            Ok((method.dt, simulation))
        });
        match ready {
            Ok((dt, simulation)) => Course::run(simulation, dt, &self.points, times, cpu, watch),
            Err(message) => Course::stillborn(message),
        }
    }

    /// The method of a key; a share of the explicit limit is taken of the substep that the scheme chooses.
    fn method_of(&self, key: &Key) -> Result<MethodSpec, String> {
        let method = MethodSpec {
            scheme: key.scheme,
            substep: None,
            ..self.scene.method
        };
        let part = match key.asked {
            Asked::Step(dt) => return Ok(MethodSpec { dt, ..method }),
            Asked::Limit(part) => part,
        };
        let dt = self.steps.iter().copied().fold(f64::INFINITY, f64::min);
        let outer = MethodSpec { dt, ..method };
        let mut simulation = start(&self.with(outer))?;
        let report = simulation.step().map_err(|d| d.to_string())?;
        let substep = dt / (report.work.substeps.max(1) * u64::from(part)) as f64;
        let substep = (part > 1).then_some(substep);
        Ok(MethodSpec { substep, ..outer })
    }

    fn with(&self, method: MethodSpec) -> Scene {
        Scene {
            method,
            ..self.scene.clone()
        }
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
    };
    format!("{} {} {step}", key.scene, key.scheme.name())
}
