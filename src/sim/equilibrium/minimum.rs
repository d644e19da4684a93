//! Whether a state of rest is a minimum of the energy: Cholesky's factorisation of the exact second derivative, and
//! the softest mode by inverse iteration.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::math::sparse::NO_SLOT;
use crate::sim::implicit::Implicit;
use crate::sim::model::Model;
use crate::sim::report::Work;
use crate::sim::state::State;
use crate::sim::touch::Touch;

/// Squared angular frequency above which a mode that is not stable counts as neutral \[1/s²\]: it would take minutes
/// to grow.
const NEUTRAL: f64 = -1e-4;
/// Shifts tried, each ten times the one before \[1/s²\].
const FIRST_SHIFT: f64 = 1e-3;
const LAST_SHIFT: f64 = 1e12;
/// Iterations at most, and the relative change at which they end.
const ITERATIONS: usize = 40;
const SETTLED: f64 = 1e-3;
/// Largest displacement that leaves a saddle, over the length of an edge.
const KICK: f64 = 0.1;

/// The softest mode of vibration about a state of rest.
pub struct Softest {
    positive_definite: bool,
    /// Squared angular frequency \[1/s²\].
    rate: f64,
    /// Displacements of the vertices, largest 1.
    mode: Vec<Vector3<f64>>,
}

/// Finds the softest mode. The load of air, which is no energy, counts as constant.
pub fn softest(model: &Model, solver: &mut Implicit, state: &State, work: &mut Work) -> Softest {
    let touch = Touch::of(model, state, None);
    let mut shift = 0.0;
    let mut positive_definite = |shift: f64| {
        work.factorisations += 1;
        work.tests += 1;
        solver.factorise_exact(model, state, &touch, shift)
    };
    while !positive_definite(shift) && shift < LAST_SHIFT {
        shift = (10.0 * shift).max(FIRST_SHIFT);
    }
    let mut nodes = vec![Vector3::zeros(); model.dofs.index.len()];
    let mut random = Pcg64::seed_from_u64(0);
    for node in &mut nodes[..model.masses.len()] {
        *node = Vector3::from_fn(|_, _| random.random::<f64>() - 0.5);
    }
    let mut z = vec![0.0; model.dofs.size];
    let mut weighted = vec![0.0; z.len()];
    model.dofs.gather(&nodes, &mut z);
    let mut rate = f64::INFINITY;
    for _ in 0..ITERATIONS {
        weigh(model, &z, &mut weighted);
        let mut next = weighted.clone();
        solver.back_substitute(&mut next);
        work.solves += 1;
        let across = dot(&next, &weighted);
        weigh(model, &next, &mut weighted);
        let along = dot(&next, &weighted);
        let before = std::mem::replace(&mut rate, across / along - shift);
        let scale = 1.0 / along.sqrt();
        z = next.iter().map(|c| c * scale).collect();
        if (rate - before).abs() < SETTLED * rate.abs() {
            break;
        }
    }
    nodes.fill(Vector3::zeros());
    model.dofs.scatter(&z, &mut nodes);
    nodes.truncate(model.masses.len());
    let largest = nodes.iter().map(Vector3::norm).fold(0.0, f64::max);
    nodes
        .iter_mut()
        .for_each(|n| *n /= largest.max(f64::MIN_POSITIVE));
    Softest {
        positive_definite: shift == 0.0,
        rate,
        mode: nodes,
    }
}

impl Softest {
    /// The squared angular frequency of a mode that is stable or neutral \[1/s²\].
    pub fn stable(&self) -> Option<f64> {
        (self.positive_definite || self.rate > NEUTRAL).then_some(self.rate)
    }

    /// Pushes a state off its saddle, downhill.
    pub fn leave(&self, model: &Model, state: &mut State) {
        let faces = model.mesh.faces.len() as f64;
        let edge = (4.0 * model.mesh.area() / (3f64.sqrt() * faces)).sqrt();
        for (v, (position, mode)) in state.positions.iter_mut().zip(&self.mode).enumerate() {
            *position += model.dofs.free(v, mode * (KICK * edge));
        }
    }
}

/// Product of the mass matrix, in which slopes have no part, with a vector.
fn weigh(model: &Model, z: &[f64], out: &mut [f64]) {
    out.fill(0.0);
    for (index, mass) in model.dofs.index.iter().zip(&model.masses) {
        for &i in index.iter().filter(|&&i| i != NO_SLOT) {
            out[i as usize] = mass * z[i as usize];
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
