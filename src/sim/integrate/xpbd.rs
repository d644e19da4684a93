//! Position-based dynamics with compliance in small steps, one sweep each (Macklin et al. 2019,
//! doi:10.1145/3309486.3340247): what games use, on the same energies as every other method here. A baseline: first
//! order, and never asked whether its equations are solved; the step says how far they are not.
//!
//! A face has a block of three membrane strains and one of three curvatures for each coordinate; each is relaxed by
//! itself, in the order of the faces, then the contacts:
//!
//! ```text
//! d lambda = -(1 + S J W J^T)^-1 S c(x),   d x = W J^T d lambda,   S = dt² area stiffness
//! ```

use nalgebra::{Matrix3, SMatrix, Vector3};

use super::stable::{MARGIN, most_inertia, quickest};
use crate::contact::Nearby;
use crate::physics::bend::curvature_operator;
use crate::physics::contact::weighted;
use crate::sim::air::{Breeze, resistances};
use crate::sim::kernel::Kernel;
use crate::sim::lanes::{Lanes, ZERO, lanes, vector};
use crate::sim::model::Model;
use crate::sim::state::State;
use crate::sim::touch::Touch;

/// Places or rates of the nodes.
type Nodes<'a> = &'a [Vector3<f64>];

/// Substeps in a step when the user leaves them open.
pub const SUBSTEPS: f64 = 20.0;

/// The integrator: constants and work space.
pub struct Xpbd {
    faces: Vec<Face>,
    /// 1/m and 1/J by component, zero where prescribed, shape \[nodes\].
    lightness: Vec<Vector3<f64>>,
    inertia: Vec<f64>,
    kernel: Kernel,
    /// Substep that the faces are prepared for \[s\].
    prepared: f64,
}

struct Face {
    nodes: [usize; 6],
    area: f64,
    /// Shape gradients of the corners \[1/m\].
    shape: [[f64; 2]; 3],
    /// Curvatures 11, 22, 12 by the nodes.
    curvature: SMatrix<f64, 3, 6>,
    /// -(1 + S G)^-1 S of the curvatures, for x, y and z.
    bend: [Matrix3<f64>; 3],
}

impl Xpbd {
    /// Lays out a model.
    pub fn new(model: &Model) -> Self {
        let mut inertia = model.masses.clone();
        let edges = 0..model.mesh.edges.len();
        inertia.extend(edges.map(|e| most_inertia(model, e)));
        let face = |f: usize| Face {
            nodes: model.mesh.face_nodes(f).map(|n| n as usize),
            area: model.mesh.face_areas[f],
            shape: model.mesh.shape_gradients(f).map(Into::into),
            curvature: curvature_operator(&model.mesh, f),
            bend: [Matrix3::zeros(); 3],
        };
        let lightness = inertia.iter().enumerate();
        let lightness = lightness.map(|(n, m)| model.dofs.free(n, Vector3::repeat(1.0 / m)));
        Self {
            faces: (0..model.mesh.faces.len()).map(face).collect(),
            lightness: lightness.collect(),
            kernel: Kernel::new(model),
            inertia,
            prepared: 0.0,
        }
    }

    /// Takes `count` substeps of `dt`; returns the contacts at the end, and the residual there over the weight with the
    /// vertex where it is largest.
    pub fn advance(
        &mut self,
        model: &Model,
        state: &mut State,
        dt: f64,
        count: u64,
    ) -> (Touch, f64, usize) {
        self.prepare(model, dt);
        let mut x = state.nodes();
        let rates = state.velocities.iter().chain(&state.slope_rates);
        let mut v: Vec<Vector3<f64>> = rates.copied().collect();
        let mut touch = Touch::default();
        let mut before = v.clone();
        let nearby = self.nearby(model, state, dt * count as f64);
        for substep in 0..count {
            before.clone_from(&v);
            let moment = (substep + 1) as f64 * dt;
            state.ledger.damping += self.push(model, state, (&x, &mut v), (moment, dt));
            let start = x.clone();
            for (x, v) in x.iter_mut().zip(&v) {
                *x += v * dt;
            }
            let within = match substep + 1 == count {
                true => model.scene.method.dt,
                false => moment,
            };
            let time = model.script_time(state, within);
            model.place_supports(&mut x, time);
            let [stretch, _] = stiffnesses(model, dt);
            for face in &self.faces {
                self.relax_membrane(face, &stretch, &mut x);
                self.relax_bending(face, &mut x);
            }
            let obstacles = state.obstacles.clone();
            model.move_obstacles(&mut state.obstacles, time, dt);
            touch.obstacles.clone_from(&state.obstacles);
            if let Some(law) = &model.contact {
                touch.find(model, law, &x[..model.masses.len()], Some(&nearby));
                let friction = self.relax_contacts(model, &touch, (&start, &mut x), dt);
                state.ledger.friction += friction;
                state.ledger.supports += touch.work_of_obstacles(model, &obstacles, &x);
            }
            for ((v, x), start) in v.iter_mut().zip(&x).zip(&start) {
                *v = (x - start) / dt;
            }
        }
        let (residual, worst) = self.residual(model, state, &touch, (&x, &v, &before), dt);
        let vertices = model.masses.len();
        state.positions.copy_from_slice(&x[..vertices]);
        state.slopes.copy_from_slice(&x[vertices..]);
        state.velocities.copy_from_slice(&v[..vertices]);
        state.slope_rates.copy_from_slice(&v[vertices..]);
        model.hold(state, model.script_time(state, model.scene.method.dt));
        state.history.restart();
        (touch, residual, worst)
    }

    /// What of the sheet may come near each obstacle within `span` seconds.
    fn nearby(&self, model: &Model, state: &State, span: f64) -> Vec<Nearby> {
        let Some(law) = &model.contact else {
            return vec![];
        };
        let fastest = state
            .velocities
            .iter()
            .map(|v| v.norm())
            .fold(0.0, f64::max);
        let gravity = Vector3::from(model.scene.gravity).norm();
        let find = |body| {
            let speed = fastest + gravity * span + quickest(model, body, &state.positions);
            let margin = MARGIN + 2.0 * speed * span;
            Nearby::find(&model.mesh, &state.positions, body, law.offset, margin)
        };
        state.obstacles.iter().map(find).collect()
    }

    /// The part of the faces' blocks that the substep decides.
    fn prepare(&mut self, model: &Model, dt: f64) {
        if self.prepared == dt {
            return;
        }
        let [_, bending] = stiffnesses(model, dt);
        for face in &mut self.faces {
            let stiffness = bending * face.area;
            for axis in 0..3 {
                let mut moved = face.curvature;
                for (k, n) in face.nodes.iter().enumerate() {
                    moved.column_mut(k).scale_mut(self.lightness[*n][axis]);
                }
                let block = moved * face.curvature.transpose();
                let inverse = (Matrix3::identity() + stiffness * block).try_inverse();
                face.bend[axis] = -inverse.unwrap_or_default() * stiffness;
            }
        }
        self.prepared = dt;
    }

    /// Velocities after weight, damping and air, these two implicitly; returns what damping took out \[J\].
    fn push(
        &self,
        model: &Model,
        state: &mut State,
        (x, v): (&[Vector3<f64>], &mut [Vector3<f64>]),
        (moment, dt): (f64, f64),
    ) -> f64 {
        let gravity = Vector3::from(model.scene.gravity);
        let breeze = Breeze::of(model, state).map(|breeze| breeze.at(moment));
        let resistance = breeze.as_ref().map(|drag| resistances(drag, x));
        let mut taken = 0.0;
        for n in 0..model.masses.len() {
            let (mass, c) = (model.masses[n], model.damping.coefficients[n]);
            let mut matrix = Matrix3::identity() * (mass + c * dt);
            let mut momentum = (v[n] + gravity * dt) * mass;
            if let (Some(drag), Some(resistance)) = (&breeze, &resistance) {
                matrix += resistance[n] * dt;
                momentum += resistance[n] * drag.air[n] * dt;
            }
            let free = self.lightness[n].map(|w| f64::from(u8::from(w > 0.0)));
            v[n] = (matrix.try_inverse().unwrap_or_default() * momentum).component_mul(&free);
            taken += c * v[n].norm_squared() * dt;
        }
        taken
    }

    fn relax_membrane(&self, face: &Face, stiffness: &Matrix3<f64>, x: &mut [Vector3<f64>]) {
        let corners = [face.nodes[0], face.nodes[1], face.nodes[2]];
        let mut r = [Vector3::zeros(); 2];
        for (k, n) in corners.iter().enumerate() {
            r[0] += x[*n] * face.shape[k][0];
            r[1] += x[*n] * face.shape[k][1];
        }
        let [r1, r2] = r;
        let strain = Vector3::new(
            0.5 * (r1.norm_squared() - 1.0),
            0.5 * (r2.norm_squared() - 1.0),
            r1.dot(&r2),
        );
        let rows = |k: usize| {
            let [a, b] = face.shape[k];
            Matrix3::from_rows(&[
                (r1 * a).transpose(),
                (r2 * b).transpose(),
                (r2 * a + r1 * b).transpose(),
            ])
        };
        let jacobians = [rows(0), rows(1), rows(2)];
        let mut block = Matrix3::zeros();
        for (jacobian, n) in jacobians.iter().zip(corners) {
            let moved = Matrix3::from_diagonal(&self.lightness[n]) * jacobian.transpose();
            block += jacobian * moved;
        }
        let stiffness = stiffness * face.area;
        let Some(inverse) = (Matrix3::identity() + stiffness * block).try_inverse() else {
            return;
        };
        let lambda = -(inverse * (stiffness * strain));
        for (jacobian, n) in jacobians.iter().zip(corners) {
            x[n] += (jacobian.transpose() * lambda).component_mul(&self.lightness[n]);
        }
    }

    fn relax_bending(&self, face: &Face, x: &mut [Vector3<f64>]) {
        for axis in 0..3 {
            let mut at = SMatrix::<f64, 6, 1>::zeros();
            for (k, n) in face.nodes.iter().enumerate() {
                at[k] = x[*n][axis];
            }
            let lambda = face.bend[axis] * (face.curvature * at);
            let push = face.curvature.transpose() * lambda;
            for (k, n) in face.nodes.iter().enumerate() {
                x[*n][axis] += self.lightness[*n][axis] * push[k];
            }
        }
    }

    /// Out of the obstacles, with Coulomb friction; returns what friction took out \[J\].
    fn relax_contacts(
        &self,
        model: &Model,
        touch: &Touch,
        (start, x): (&[Vector3<f64>], &mut [Vector3<f64>]),
        dt: f64,
    ) -> f64 {
        let Some(law) = &model.contact else {
            return 0.0;
        };
        let mut taken = 0.0;
        for near in &touch.proximities {
            let force = law.normal_force(near);
            if force <= 0.0 {
                continue;
            }
            let vertices = model.mesh.faces[near.face as usize].map(|v| v as usize);
            let normal = near.distance.normal;
            let feel = |along: &Vector3<f64>| -> f64 {
                let felt = vertices.iter().zip(near.weights);
                felt.map(|(&v, w)| w * w * self.lightness[v].component_mul(along).dot(along))
                    .sum()
            };
            // The law's force at the end of the substep, to first order.
            let stiffness = law.stiffness * near.share;
            let push = force * dt * dt / (1.0 + stiffness * dt * dt * feel(&normal));
            let at = |x: &[Vector3<f64>]| weighted(&near.weights, &vertices.map(|v| x[v]));
            let body = &touch.obstacles[near.obstacle as usize];
            let moved = at(x) - at(start) - body.surface_velocity(&at(x), &normal) * dt;
            let slid = moved - normal * normal.dot(&moved);
            let mut shift = normal * push;
            let (length, light) = (
                slid.norm(),
                feel(&slid.try_normalize(0.0).unwrap_or(normal)),
            );
            if length > 0.0 && light > 0.0 {
                let stop = (length / light).min(body.friction * push);
                shift -= slid * (stop / length);
                taken += stop * (length - 0.5 * stop * light).max(0.0) / (dt * dt);
            }
            for (&v, w) in vertices.iter().zip(near.weights) {
                x[v] += self.lightness[v].component_mul(&shift) * w;
            }
        }
        taken
    }

    /// Sum of the residual forces of the last substep over the weight, and the vertex with the largest.
    fn residual(
        &self,
        model: &Model,
        state: &State,
        touch: &Touch,
        (x, v, before): (Nodes, Nodes, Nodes),
        dt: f64,
    ) -> (f64, usize) {
        let nodes: Vec<Lanes> = x.iter().map(lanes).collect();
        let mut forces = vec![ZERO; nodes.len()];
        self.kernel.add_forces(&nodes, &mut forces);
        let mut forces: Vec<_> = forces.iter().map(vector).collect();
        if let Some(law) = &model.contact {
            for (v, push) in touch.pushes(model, law, x) {
                forces[v as usize] += push;
            }
        }
        if let Some(breeze) = Breeze::of(model, state) {
            let vertices = model.masses.len();
            let pushes = breeze.at(model.scene.method.dt).forces(x, &v[..vertices]);
            forces
                .iter_mut()
                .zip(pushes)
                .for_each(|(f, push)| *f += push);
        }
        let gravity = Vector3::from(model.scene.gravity);
        let (mut sum, mut worst) = (0.0, (0.0, 0));
        for (n, force) in forces.iter().enumerate() {
            let mut rest = force - (v[n] - before[n]) * (self.inertia[n] / dt);
            let is_vertex = n < model.masses.len();
            if is_vertex {
                rest += gravity * model.masses[n] - v[n] * model.damping.coefficients[n];
            }
            let size = model.dofs.free(n, rest).norm();
            if is_vertex {
                sum += size;
                if size > worst.0 {
                    worst = (size, n);
                }
            } else {
                sum += size / model.mesh.edge_length(n - model.masses.len());
            }
        }
        (sum / model.weight, worst.1)
    }
}

/// dt² times the membrane's matrix (with the shear strain doubled) and the bending's, per area.
fn stiffnesses(model: &Model, dt: f64) -> [Matrix3<f64>; 2] {
    let membrane = model.fabric.membrane().matrix();
    let mut bending = model.fabric.bending().matrix();
    bending.m33 *= 4.0;
    [membrane * (dt * dt), bending * (dt * dt)]
}
