//! PLACEHOLDER physics while the house goes up (replaced by the real step before the first landing).

use nalgebra::{Vector2, Vector3};

use super::{Model, State, StepReport};
use crate::contact::{Obstacle, Pose, Velocity};
use crate::fabric;
use crate::scene::Scene;
use crate::sheet::Mesh;

/// A step that could not be taken.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "step {step} at {time:.4} s did not converge: residual {residual:.2e} of the weight, worst at vertex {vertex}; {advice}"
)]
pub struct Diverged {
    /// The step that failed.
    pub step: u64,
    /// Its start time \[s\].
    pub time: f64,
    /// Residual over the weight \[-\].
    pub residual: f64,
    /// Vertex with the largest residual force.
    pub vertex: usize,
    /// What to try.
    pub advice: String,
}

/// A model with its state.
pub struct Simulation {
    model: Model,
    state: State,
    report: StepReport,
}

impl Simulation {
    /// Builds model and start state from a checked scene.
    pub fn new(scene: &Scene, _threads: usize) -> Self {
        let n = 30usize;
        let mut outline = vec![];
        for i in 0..n {
            for j in 0..n {
                outline.push(Vector2::new(
                    0.2 * (i as f64 / (n - 1) as f64 - 0.5),
                    0.2 * (j as f64 / (n - 1) as f64 - 0.5),
                ));
            }
        }
        let mut faces = vec![];
        for i in 0..n - 1 {
            for j in 0..n - 1 {
                let (a, b, c, d) = (
                    i * n + j,
                    (i + 1) * n + j,
                    (i + 1) * n + j + 1,
                    i * n + j + 1,
                );
                faces.push([a as u32, b as u32, c as u32]);
                faces.push([a as u32, c as u32, d as u32]);
            }
        }
        let mesh = Mesh {
            material: outline.clone(),
            face_edges: vec![],
            edges: vec![],
            edge_faces: vec![],
            face_areas: vec![0.04 / faces.len() as f64; faces.len()],
            vertex_areas: vec![0.04 / outline.len() as f64; outline.len()],
            faces,
            outline,
        };
        let positions: Vec<_> = mesh
            .outline
            .iter()
            .map(|p| Vector3::new(p.x, p.y, 0.0))
            .collect();
        let obstacles = scene
            .obstacle
            .iter()
            .map(|(name, o)| Obstacle {
                name: name.clone(),
                shape: o.shape.clone(),
                pose: Pose::translation(o.position[0], o.position[1], o.position[2]),
                velocity: Velocity::default(),
                friction: o.friction,
            })
            .collect();
        let state = State {
            step: 0,
            velocities: vec![Vector3::zeros(); positions.len()],
            positions,
            slopes: vec![],
            obstacles,
        };
        let fabric = fabric::find(&scene.fabric.name).expect("checked");
        let model = Model {
            scene: scene.clone(),
            fabric,
            mesh,
        };
        Self {
            model,
            state,
            report: StepReport {
                converged: true,
                ..StepReport::default()
            },
        }
    }

    /// The constant part.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The state.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Report of the last step (of the start, before the first).
    pub fn report(&self) -> &StepReport {
        &self.report
    }

    /// Takes one step.
    pub fn step(&mut self) -> Result<&StepReport, Diverged> {
        self.state.step += 1;
        let dt = self.model.scene.method.dt;
        let t = self.state.step as f64 * dt;
        for (x, p) in self
            .state
            .positions
            .iter_mut()
            .zip(&self.model.mesh.outline)
        {
            let r = (p.x.abs().max(p.y.abs()) - 0.05).max(0.0);
            x.z =
                3e-4 - r * r * 10.0 * t.min(1.0) + 0.001 * (20.0 * t + 60.0 * p.x).sin() * r * 20.0;
        }
        self.report.step = self.state.step;
        self.report.time = t;
        self.report.dt = dt;
        self.report.digest = self.state.step.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        self.report.work.iterations = 3;
        Ok(&self.report)
    }
}
