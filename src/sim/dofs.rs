//! Which unknown stands where in the linear system.

use nalgebra::Vector3;

use crate::math::ordering::nested_dissection;
use crate::math::sparse::NO_SLOT;
use crate::physics::support::Support;
use crate::sheet::Mesh;

/// Numbers of the free scalar unknowns, in elimination order. Nodes are the vertices, then the edges.
#[derive(Clone, Debug)]
pub struct Dofs {
    /// Number of each component of each node, [`NO_SLOT`] where it is prescribed, shape \[nodes\].
    pub index: Vec<[u32; 3]>,
    /// How many are free.
    pub size: usize,
}

impl Dofs {
    /// Numbers what the supports leave free.
    pub fn new(mesh: &Mesh, supports: &[Support]) -> Self {
        let vertices = mesh.material.len();
        let nodes = vertices + mesh.edges.len();
        let mut free = vec![[true; 3]; nodes];
        for support in supports {
            for &v in &support.vertices {
                for axis in 0..3 {
                    free[v as usize][axis] &= !support.axes[axis];
                }
            }
            for &e in &support.edges {
                free[vertices + e as usize] = [false; 3];
            }
        }
        let elements: Vec<[u32; 6]> = (0..mesh.faces.len()).map(|f| mesh.face_nodes(f)).collect();
        let mut index = vec![[NO_SLOT; 3]; nodes];
        let mut size = 0;
        for node in nested_dissection(&elements, &centres(mesh), nodes) {
            for axis in 0..3 {
                if free[node as usize][axis] {
                    index[node as usize][axis] = size;
                    size += 1;
                }
            }
        }
        Self {
            index,
            size: size as usize,
        }
    }

    /// A vector on a node without its prescribed components.
    pub fn free(&self, node: usize, vector: Vector3<f64>) -> Vector3<f64> {
        let index = self.index[node];
        Vector3::from_fn(|axis, _| {
            if index[axis] == NO_SLOT {
                0.0
            } else {
                vector[axis]
            }
        })
    }

    /// Writes the free components of `nodes` into `z`.
    pub fn gather(&self, nodes: &[Vector3<f64>], z: &mut [f64]) {
        for (node, index) in nodes.iter().zip(&self.index) {
            for axis in 0..3 {
                if index[axis] != NO_SLOT {
                    z[index[axis] as usize] = node[axis];
                }
            }
        }
    }

    /// Writes `z` into the free components of `nodes`.
    pub fn scatter(&self, z: &[f64], nodes: &mut [Vector3<f64>]) {
        for (node, index) in nodes.iter_mut().zip(&self.index) {
            for axis in 0..3 {
                if index[axis] != NO_SLOT {
                    node[axis] = z[index[axis] as usize];
                }
            }
        }
    }
}

/// Centres of the faces in material coordinates \[m\].
pub fn centres(mesh: &Mesh) -> Vec<[f64; 2]> {
    let centre = |face: &[u32; 3]| {
        let sum = face
            .iter()
            .map(|&v| mesh.material[v as usize])
            .sum::<nalgebra::Vector2<f64>>();
        [sum.x / 3.0, sum.y / 3.0]
    };
    mesh.faces.iter().map(centre).collect()
}
