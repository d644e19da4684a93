//! The paper's explicit scheme (16): central differences with lumped mass, substepping at its own stable limit.
//!
//! ```text
//! (rho/dt² + mu/2dt) x_(n+1) = f_n + 2 rho/dt² x_n - (rho/dt² - mu/2dt) x_(n-1)
//! ```
//!
//! in its kick-drift-kick form, which gives the same positions and takes a variable step. Slopes carry no mass:
//! after each substep they take the value of least bending energy. The limit is 2/omega_max of the undamped
//! system (Courant, Friedrichs, Lewy), by power iteration on the actual mesh.

use nalgebra::Vector3;

use crate::math::sparse::NO_SLOT;
use crate::physics::Potential;
use crate::sim::assembly::{Assembly, pick};
use crate::sim::model::Model;
use crate::sim::slopes::SlopeSolver;
use crate::sim::state::State;
use crate::sim::touch::{Before, Touch};

/// Substep over the stable limit when the user leaves it open.
pub const SAFETY: f64 = 0.9;
/// Power iterations; the limit is then good to about 1 %.
const POWER_ITERATIONS: usize = 200;

/// Forces and accelerations without a linear system; also the start of every other scheme.
pub struct Explicit {
    slopes: SlopeSolver,
    assembly: Assembly,
}

impl Explicit {
    /// Prepares the slope solve.
    pub fn new(model: &Model, threads: usize) -> Self {
        Self {
            slopes: SlopeSolver::new(model),
            assembly: Assembly::new(model, threads),
        }
    }

    /// Gives the slopes in `nodes` their value of least bending energy.
    pub fn relax(&mut self, model: &Model, nodes: &mut [Vector3<f64>]) {
        self.slopes.relax(model, nodes);
    }

    /// Largest stable substep at `nodes` \[s\]: 2/omega_max of M^-1 K, with contact at every vertex if the model
    /// has any.
    pub fn limit(&mut self, model: &Model, nodes: &[Vector3<f64>]) -> f64 {
        let vertices = model.masses.len();
        let contact = model.contact.map_or(0.0, |law| 2.0 * law.stiffness);
        let mut mode = vec![Vector3::zeros(); nodes.len()];
        for (v, x) in mode[..vertices].iter_mut().enumerate() {
            // Any vector that no mode is orthogonal to will do; this one has all wavelengths.
            let phase = (v as f64 * 0.754_877_666) % 1.0;
            *x = free(
                model,
                v,
                Vector3::new(phase - 0.5, 0.5 - phase * phase, phase * 0.7 - 0.3),
            );
        }
        let mut omega_squared = 0.0;
        for _ in 0..POWER_ITERATIONS {
            let norm = mode[..vertices]
                .iter()
                .map(|x| x.norm_squared())
                .sum::<f64>()
                .sqrt();
            mode.iter_mut().for_each(|x| *x /= norm);
            mode[vertices..].fill(Vector3::zeros());
            self.relax_mode(model, &mut mode);
            let force = stiffness_times(model, nodes, &mode);
            for v in 0..vertices {
                mode[v] = free(model, v, (force[v] + mode[v] * contact) / model.masses[v]);
            }
            omega_squared = mode[..vertices]
                .iter()
                .map(|x| x.norm_squared())
                .sum::<f64>()
                .sqrt();
        }
        2.0 / omega_squared.sqrt()
    }

    /// Slopes of a displacement: those that a clamp holds do not move.
    fn relax_mode(&mut self, model: &Model, mode: &mut [Vector3<f64>]) {
        self.slopes.relax(model, mode);
    }

    /// Accelerations at the state's positions, with the contacts there.
    pub fn accelerations(
        &mut self,
        model: &Model,
        state: &State,
        before: &Before,
    ) -> (Vec<Vector3<f64>>, Touch) {
        let nodes = state.nodes();
        let (force, touch) = self.forces(model, state, &nodes, before);
        let accelerations = (0..model.masses.len())
            .map(|v| {
                let pull = force[v] + model.damping.force(v, &state.velocities[v]);
                free(model, v, pull / model.masses[v])
            })
            .collect();
        (accelerations, touch)
    }

    /// Forces on the nodes without damping \[N\].
    fn forces(
        &mut self,
        model: &Model,
        state: &State,
        nodes: &[Vector3<f64>],
        before: &Before,
    ) -> (Vec<Vector3<f64>>, Touch) {
        let mut gradient = vec![Vector3::zeros(); nodes.len()];
        self.assembly.internal(model, nodes, &mut gradient);
        let mut touch = Touch {
            obstacles: state.obstacles.clone(),
            ..Touch::default()
        };
        if let Some(law) = &model.contact {
            touch.find(model, law, nodes, before);
            touch.gradient(model, law, nodes, &mut gradient);
        }
        for v in 0..model.masses.len() {
            gradient[v] += model.gravity.gradient(v, &[nodes[v]])[0];
        }
        gradient.iter_mut().for_each(|g| *g = -*g);
        (gradient, touch)
    }

    /// Takes one substep of `dt` \[s\]; the obstacles of `state` are moved too. Returns the contacts at its end.
    pub fn substep(&mut self, model: &Model, state: &mut State, dt: f64) -> Touch {
        let vertices = model.masses.len();
        let start = state.clone();
        let mut nodes = state.nodes();
        for v in 0..vertices {
            state.velocities[v] += state.history.accelerations[v] * (0.5 * dt);
            nodes[v] += free(model, v, state.velocities[v]) * dt;
        }
        state.obstacles.iter_mut().for_each(|o| o.advance(dt));
        self.slopes.relax(model, &mut nodes);
        let before = Before {
            positions: &start.positions,
            obstacles: &start.obstacles,
            bonds: &start.bonds,
        };
        let (force, touch) = self.forces(model, state, &nodes, &before);
        for v in 0..vertices {
            let (mass, drag) = (model.masses[v], model.damping.coefficients[v]);
            let kicked = state.velocities[v] + force[v] * (0.5 * dt / mass);
            let velocity = free(model, v, kicked / (1.0 + 0.5 * dt * drag / mass));
            state.velocities[v] = velocity;
            state.history.accelerations[v] = free(model, v, (force[v] - velocity * drag) / mass);
        }
        state.positions.copy_from_slice(&nodes[..vertices]);
        state.slopes.copy_from_slice(&nodes[vertices..]);
        state.history.dt = dt;
        touch
    }
}

/// A vector on a vertex with its prescribed components removed.
fn free(model: &Model, v: usize, x: Vector3<f64>) -> Vector3<f64> {
    let index = model.dofs.index[v];
    Vector3::from_fn(|axis, _| if index[axis] == NO_SLOT { 0.0 } else { x[axis] })
}

fn stiffness_times(model: &Model, at: &[Vector3<f64>], mode: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let mut force = vec![Vector3::zeros(); mode.len()];
    for f in 0..model.mesh.faces.len() {
        let stencil = model.bend.nodes(f);
        let d = pick(mode, &stencil);
        let mut sum = model.bend.gradient(f, &d);
        let hessian = model.stretch.hessian(f, &pick(at, &model.stretch.nodes(f)));
        for i in 0..3 {
            for j in 0..3 {
                sum[i] += hessian[i][j] * d[j];
            }
        }
        for (n, s) in stencil.iter().zip(sum) {
            force[*n as usize] += s;
        }
    }
    force
}
