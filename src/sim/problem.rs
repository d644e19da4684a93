//! The equations of an implicit step, for Newton: residual, tangent, and how far a step may go.

use nalgebra::Vector3;

use super::assembly::{Assembly, pick};
use super::carry::Prescribed;
use super::integrate::Map;
use super::layers::LayerTouch;
use super::model::Model;
use super::near::Near;
use super::state::Memory;
use super::touch::{Before, Touch};
use super::travel::before_passing;
use crate::math::newton::Problem;
use crate::math::sparse::Pattern;
use crate::physics::drag::Drag;
use crate::physics::layers::LayerLaw;
use crate::physics::{Load, Potential};

/// The equations of a step, with what their evaluation needs and leaves.
pub struct StepProblem<'a> {
    pub model: &'a Model,
    pub before: Before<'a>,
    /// How layers touch, if they are watched.
    pub law: Option<LayerLaw>,
    pub layer_bonds: &'a [Memory],
    pub layers: LayerTouch,
    pub near: &'a mut Near,
    /// Nodes of a step that is considered.
    pub trial: Vec<Vector3<f64>>,
    pub map: &'a Map,
    pub assembly: &'a mut Assembly,
    pub touch: Touch,
    pub drag: Option<Drag<'a>>,
    pub velocities: Vec<Vector3<f64>>,
    pub nodes: &'a mut Vec<Vector3<f64>>,
    pub forces: &'a mut Vec<Vector3<f64>>,
    /// Stress of each face for the geometric part of the tangent.
    pub stresses: &'a mut Vec<Vector3<f64>>,
    /// Nodes of the iterate before.
    pub iterate: Vec<Vector3<f64>>,
    /// Whether an iteration goes where no time leads, so that nothing else keeps it from jumping over an obstacle.
    pub timeless: bool,
}

impl StepProblem<'_> {
    /// Fills `forces` with M a + mu A v + dW/dx at the current nodes.
    pub fn evaluate(&mut self) {
        self.forces.fill(Vector3::zeros());
        self.assembly.internal(self.model, self.nodes, self.forces);
        let (map, model) = (self.map, self.model);
        for v in 0..model.masses.len() {
            let x = self.nodes[v];
            let acceleration = x * map.alpha_a + map.b_a[v];
            let velocity = x * map.alpha_v + map.b_v[v];
            self.forces[v] += acceleration * model.masses[v]
                - model.damping.force(v, &[x], &[velocity])[0]
                + model.gravity.gradient(v, &[x])[0];
            self.velocities[v] = velocity;
        }
        if let Some(drag) = &self.drag {
            let pushes = drag.forces(self.nodes, &self.velocities);
            for (force, push) in self.forces.iter_mut().zip(pushes) {
                *force -= push;
            }
        }
        if let Some(law) = &model.contact {
            let positions = &self.nodes[..model.masses.len()];
            self.touch.find(model, law, positions, None);
            self.touch.bind(model, law, &self.before);
            for (v, push) in self.touch.pushes(model, law, self.nodes) {
                self.forces[v as usize] -= push;
            }
        }
        if let Some(law) = &self.law {
            let positions = &self.nodes[..model.masses.len()];
            let start = (self.before.positions, self.layer_bonds);
            self.near
                .find(model, law, positions, start, &mut self.layers);
            for (v, push) in self.layers.pushes(law, self.nodes) {
                self.forces[v as usize] -= push;
            }
        }
    }

    /// Work of moving supports from the nodes at the start of the step to its end, at a time since the start of the
    /// run, but for the inertia of what they hold \[J\].
    pub fn work_of_supports(&self, start: &[Vector3<f64>], end: f64) -> f64 {
        let carried = self.model.carried.iter();
        let work = |held: Prescribed| -> f64 {
            let n = held.node;
            let mut force = self.forces[n];
            if let Some(mass) = self.model.masses.get(n) {
                force -= (self.nodes[n] * self.map.alpha_a + self.map.b_a[n]) * *mass;
            }
            let along = (0..3).filter(|&axis| held.axes[axis]);
            along
                .map(|axis| force[axis] * (held.value[axis] - start[n][axis]))
                .sum()
        };
        carried.flat_map(|carried| carried.at(end)).map(work).sum()
    }

    /// Residual force of a node on its free components \[N\].
    pub fn free(&self, node: usize) -> Vector3<f64> {
        self.model.dofs.free(node, self.forces[node])
    }

    pub fn worst(&self) -> usize {
        (0..self.model.masses.len())
            .max_by(|&a, &b| {
                self.free(a)
                    .norm_squared()
                    .total_cmp(&self.free(b).norm_squared())
            })
            .unwrap_or(0)
    }

    /// Sum of the residual forces over the weight; the moments on slopes count over their edge's length.
    pub fn norm(&self) -> f64 {
        let vertices = self.model.masses.len();
        let forces: f64 = (0..vertices).map(|v| self.free(v).norm()).sum();
        let moments: f64 = (vertices..self.nodes.len())
            .map(|n| self.free(n).norm() / self.model.mesh.edge_length(n - vertices))
            .sum();
        (forces + moments) / self.model.weight
    }
}

impl Problem for StepProblem<'_> {
    fn residual(&mut self, z: &[f64], r: &mut [f64]) -> f64 {
        self.model.dofs.scatter(z, self.nodes);
        self.evaluate();
        self.model.dofs.gather(self.forces, r);
        self.norm()
    }

    fn accept(&mut self) {
        for (f, stress) in self.stresses.iter_mut().enumerate() {
            let stencil = self.model.stretch.nodes(f);
            let [from, to] = [&self.iterate, &*self.nodes].map(|nodes| pick(nodes, &stencil));
            *stress = self.model.stretch.linearised_stress(f, &from, &to);
        }
        self.iterate.copy_from_slice(self.nodes);
    }

    fn grown(&mut self) -> Option<Pattern> {
        self.law?;
        let grown = self.near.widen(self.model, &self.layers, self.assembly);
        grown.then(|| self.assembly.pattern().clone())
    }

    fn longest(&mut self, z: &[f64], step: &[f64]) -> f64 {
        if self.law.is_none() && !self.timeless {
            return 1.0;
        }
        let vertices = self.model.masses.len();
        let end: Vec<f64> = z.iter().zip(step).map(|(z, step)| z + step).collect();
        self.trial.clone_from(self.nodes);
        self.model.dofs.scatter(&end, &mut self.trial);
        let way = [&self.iterate[..vertices], &self.trial[..vertices]];
        let mut share = 1.0f64;
        if self.law.is_some() {
            share = self.near.safe(self.model, way[0], way[1]);
        }
        if self.timeless {
            let still = [&self.touch.obstacles[..]; 2];
            share = share.min(before_passing(self.model, way, still));
        }
        share
    }

    fn tangent(&mut self, projection: f64, values: &mut [f64]) {
        let weights = (self.map.alpha_a, self.map.alpha_v);
        self.assembly.tangent(
            self.model,
            self.nodes,
            self.stresses,
            weights,
            projection,
            values,
        );
        if let Some(drag) = &self.drag {
            // The derivative by position is not symmetric and stays out: the residual alone decides the solution.
            for s in 0..drag.count() {
                let stencil = drag.nodes(s);
                let x = pick(self.nodes, &stencil);
                let v = pick(&self.velocities, &stencil);
                let matrix = drag.by_velocity(s, &x, &v);
                let scaled = matrix.map(|row| row.map(|block| block * -self.map.alpha_v));
                self.assembly.add_face(s as u32, &scaled, values);
            }
        }
        if let Some(law) = &self.law {
            let (assembly, dofs) = (&*self.assembly, &self.model.dofs);
            self.layers
                .tangent(law, self.nodes, projection, |stencil, hessian| {
                    assembly.add_pair(dofs, stencil, hessian, values);
                });
        }
        if let Some(law) = &self.model.contact {
            self.touch.tangent(
                self.model,
                law,
                self.nodes,
                projection,
                self.assembly,
                values,
            );
        }
    }
}
