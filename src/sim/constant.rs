//! The constant matrix of the solver `quasi-newton`: inertia, bending (exact) and a bound on the membrane, the same for
//! x, y and z, so that one factorisation of a third of the size serves all three.

use super::model::Model;
use crate::math::cholesky::Cholesky;
use crate::math::sparse::{NO_SLOT, Pattern};
use crate::physics::Potential;

/// Scalar matrix with its factor.
pub struct Constant {
    /// Number of each node, [`NO_SLOT`] where all of it is prescribed, shape \[nodes\].
    number: Vec<u32>,
    size: usize,
    /// Bending and membrane.
    stiffness: Vec<f64>,
    /// Slot of the diagonal of each vertex, shape \[vertices\].
    diagonal: Vec<u32>,
    cholesky: Cholesky,
    /// Weights of mass and damping in the present factor.
    weights: Option<(f64, f64)>,
    columns: Vec<f64>,
}

impl Constant {
    /// Lays out a model's matrix.
    pub fn new(model: &Model) -> Self {
        let (number, size) = numbers(model);
        let stencils: Vec<[u32; 6]> = (0..model.mesh.faces.len())
            .map(|f| model.bend.nodes(f).map(|n| number[n as usize]))
            .collect();
        let pattern = Pattern::from_groups(size, stencils.iter().map(|s| &s[..]));
        let mut stiffness = vec![0.0; pattern.entries()];
        for (f, stencil) in stencils.iter().enumerate() {
            let bend = model.bend.matrix(f);
            for i in 0..6 {
                for j in 0..=i {
                    let slot = pattern.slot(stencil[i], stencil[j]);
                    if slot != NO_SLOT {
                        let membrane = if i < 3 { membrane(model, f, i, j) } else { 0.0 };
                        stiffness[slot as usize] += bend[(i, j)] + membrane;
                    }
                }
            }
        }
        let vertices = &number[..model.masses.len()];
        Self {
            diagonal: vertices.iter().map(|&n| pattern.slot(n, n)).collect(),
            columns: vec![0.0; 3 * size],
            cholesky: Cholesky::new(pattern),
            number,
            size,
            stiffness,
            weights: None,
        }
    }

    /// Forgets the factor, so that a step depends on the state alone.
    pub fn forget(&mut self) {
        self.weights = None;
    }

    /// Factorises for weights of mass and damping, unless that is done; says whether it was needed.
    pub fn prepare(&mut self, model: &Model, weights: (f64, f64)) -> bool {
        if self.weights == Some(weights) {
            return false;
        }
        let mut values = self.stiffness.clone();
        for (v, &slot) in self.diagonal.iter().enumerate() {
            if slot != NO_SLOT {
                values[slot as usize] +=
                    weights.0 * model.masses[v] + weights.1 * model.damping.coefficients[v];
            }
        }
        let made = self.cholesky.factorise(&values);
        debug_assert!(made.is_ok(), "mass and stiffness are positive definite");
        self.weights = Some(weights);
        true
    }

    /// Applies the inverse to a vector of the unknowns, in place; what is prescribed stays.
    pub fn solve(&mut self, model: &Model, z: &mut [f64]) {
        self.columns.fill(0.0);
        let nodes = self.number.iter().zip(&model.dofs.index);
        let nodes = nodes.filter(|(number, _)| **number != NO_SLOT);
        for (&number, index) in nodes.clone() {
            for axis in (0..3).filter(|&axis| index[axis] != NO_SLOT) {
                self.columns[axis * self.size + number as usize] = z[index[axis] as usize];
            }
        }
        self.cholesky.solve(&mut self.columns, 3);
        for (&number, index) in nodes {
            for axis in (0..3).filter(|&axis| index[axis] != NO_SLOT) {
                z[index[axis] as usize] = self.columns[axis * self.size + number as usize];
            }
        }
    }
}

/// Numbers of the nodes with a free component, in the elimination order of the unknowns.
fn numbers(model: &Model) -> (Vec<u32>, usize) {
    let first = |index: &[u32; 3]| index.iter().copied().min().unwrap_or(NO_SLOT);
    let mut free: Vec<(u32, usize)> = model
        .dofs
        .index
        .iter()
        .enumerate()
        .map(|(node, index)| (first(index), node))
        .filter(|(first, _)| *first != NO_SLOT)
        .collect();
    free.sort_unstable();
    let mut number = vec![NO_SLOT; model.dofs.index.len()];
    for (k, (_, node)) in free.iter().enumerate() {
        number[*node] = k as u32;
    }
    (number, free.len())
}

/// Entry of a face's membrane: with the stiffness of warp and weft across every direction of space, which no state
/// of small strain exceeds.
fn membrane(model: &Model, face: usize, i: usize, j: usize) -> f64 {
    let n = model.mesh.shape_gradients(face);
    let c = model.fabric.membrane();
    let (warp, weft) = (n[i].x * n[j].x, n[i].y * n[j].y);
    model.mesh.face_areas[face] * (c.c11.max(c.c66) * warp + c.c22.max(c.c66) * weft)
}
