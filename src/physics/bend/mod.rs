#![doc = include_str!("doc.md")]

#[cfg(test)]
mod test;

use nalgebra::{Matrix3, SMatrix, Vector3};

use super::stencil::{Gradient, Hessian, Nodes, Potential};
use crate::fabric::Orthotropic;
use crate::sheet::Mesh;

/// The scalar 6 x 6 matrix of a face, the same for x, y and z; rows are 3 vertices \[N/m\] and 3 slopes \[N·m\].
pub type ScalarMatrix = SMatrix<f64, 6, 6>;

/// Bending energy over the faces of a sheet.
#[derive(Clone, Debug)]
pub struct Bend {
    nodes: Vec<[u32; 6]>,
    matrices: Vec<ScalarMatrix>,
}

impl Bend {
    /// Bending of stiffness D \[N·m\] on a mesh.
    pub fn new(mesh: &Mesh, stiffness: Orthotropic) -> Self {
        // Voigt order (11, 22, 12) with the tensor component 12, whose energy weight is 4 D66.
        let mut weight = stiffness.matrix();
        weight.m33 *= 4.0;
        let matrices = (0..mesh.faces.len())
            .map(|f| {
                let b = curvature_operator(mesh, f);
                b.transpose() * weight * b * mesh.face_areas[f]
            })
            .collect();
        let nodes = (0..mesh.faces.len()).map(|f| mesh.face_nodes(f)).collect();
        Self { nodes, matrices }
    }

    /// The constant matrix of a face.
    pub fn matrix(&self, s: usize) -> &ScalarMatrix {
        &self.matrices[s]
    }
}

/// Maps the six unknowns of a face to (r,11 r,22 r,12) of one coordinate \[1/m\].
pub fn curvature_operator(mesh: &Mesh, face: usize) -> SMatrix<f64, 3, 6> {
    let shape = mesh.shape_gradients(face);
    let area = mesh.face_areas[face];
    let mut operator = SMatrix::<f64, 3, 6>::zeros();
    for k in 0..3 {
        let edge = mesh.face_edges[face][k] as usize;
        // The gradient of the opposite shape function points inwards.
        let outward = -shape[k].normalize();
        let sign = mesh.edge_normal(edge).dot(&outward).signum();
        let dyad = Vector3::new(
            outward.x * outward.x,
            outward.y * outward.y,
            outward.x * outward.y,
        ) * (mesh.edge_length(edge) / area);
        let mut slope = operator.column_mut(3 + k);
        slope += dyad * sign;
        for i in 0..3 {
            let mut vertex = operator.column_mut(i);
            vertex -= dyad * shape[i].dot(&outward);
        }
    }
    operator
}

impl Potential<6> for Bend {
    fn count(&self) -> usize {
        self.matrices.len()
    }

    fn nodes(&self, s: usize) -> [u32; 6] {
        self.nodes[s]
    }

    fn value(&self, s: usize, x: &Nodes<6>) -> f64 {
        let gradient = self.gradient(s, x);
        0.5 * (0..6).map(|i| gradient[i].dot(&x[i])).sum::<f64>()
    }

    fn gradient(&self, s: usize, x: &Nodes<6>) -> Gradient<6> {
        let matrix = &self.matrices[s];
        let mut gradient = [Vector3::zeros(); 6];
        for j in 0..6 {
            for (i, sum) in gradient.iter_mut().enumerate() {
                *sum += x[j] * matrix[(i, j)];
            }
        }
        gradient
    }

    fn hessian(&self, s: usize, _x: &Nodes<6>) -> Hessian<6> {
        let matrix = &self.matrices[s];
        std::array::from_fn(|i| {
            std::array::from_fn(|j| Matrix3::from_diagonal_element(matrix[(i, j)]))
        })
    }

    fn hessian_projected(&self, s: usize, x: &Nodes<6>) -> Hessian<6> {
        self.hessian(s, x)
    }
}
