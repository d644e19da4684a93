//! Edge slopes of least bending energy for given positions: K_pp p = -K_px x, by a factor made once.

use nalgebra::Vector3;

use super::assembly::pick;
use super::dofs::centres;
use super::model::Model;
use crate::math::cholesky::Cholesky;
use crate::math::ordering::nested_dissection;
use crate::math::sparse::{NO_SLOT, Pattern};
use crate::physics::Potential;

/// Solver for the slopes, which carry no mass.
pub struct SlopeSolver {
    factor: Cholesky,
    /// Number of each free edge, [`NO_SLOT`] where a clamp holds it.
    index: Vec<u32>,
    rhs: Vec<f64>,
}

impl SlopeSolver {
    /// Factorises the slope block of the bending matrix.
    pub fn new(model: &Model) -> Self {
        let (vertices, edges) = (model.masses.len(), model.mesh.edges.len());
        let faces = &model.mesh.face_edges;
        let mut index = vec![NO_SLOT; edges];
        let mut size = 0;
        for e in nested_dissection(faces, &centres(&model.mesh), edges) {
            if model.dofs.index[vertices + e as usize][0] != NO_SLOT {
                index[e as usize] = size;
                size += 1;
            }
        }
        let groups: Vec<[u32; 3]> = faces.iter().map(|f| f.map(|e| index[e as usize])).collect();
        let pattern = Pattern::from_groups(size as usize, groups.iter().map(|g| g.as_slice()));
        let mut values = vec![0.0; pattern.entries()];
        for (f, group) in groups.iter().enumerate() {
            for i in 0..3 {
                for j in 0..=i {
                    let slot = pattern.slot(group[i], group[j]);
                    if slot != NO_SLOT {
                        values[slot as usize] += model.bend.matrix(f)[(3 + i, 3 + j)];
                    }
                }
            }
        }
        let mut factor = Cholesky::new(pattern);
        factor.factorise(&values).expect(
            "a checked fabric bends with positive energy, so its slope block is positive definite",
        );
        let rhs = vec![0.0; 3 * size as usize];
        Self { factor, index, rhs }
    }

    /// Gives the free slopes in `nodes` (positions, then slopes) their value of least bending energy.
    pub fn relax(&mut self, model: &Model, nodes: &mut [Vector3<f64>]) {
        let (vertices, size) = (model.masses.len(), self.rhs.len() / 3);
        for (e, &i) in self.index.iter().enumerate() {
            if i != NO_SLOT {
                nodes[vertices + e] = Vector3::zeros();
            }
        }
        self.rhs.fill(0.0);
        for (f, face) in model.mesh.face_edges.iter().enumerate() {
            let gradient = model.bend.gradient(f, &pick(nodes, &model.bend.nodes(f)));
            for (k, &e) in face.iter().enumerate() {
                let i = self.index[e as usize];
                if i != NO_SLOT {
                    for axis in 0..3 {
                        self.rhs[axis * size + i as usize] -= gradient[3 + k][axis];
                    }
                }
            }
        }
        self.factor.solve(&mut self.rhs, 3);
        for (e, &i) in self.index.iter().enumerate() {
            if i != NO_SLOT {
                nodes[vertices + e] =
                    Vector3::from_fn(|axis, _| self.rhs[axis * size + i as usize]);
            }
        }
    }
}
