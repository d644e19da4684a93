//! Dead loads as forces on vertices.

use nalgebra::Vector3;

use super::model::region;
use crate::scene::Scene;
use crate::sheet::Mesh;

/// Dead loads on the vertices \[N\].
pub fn loads(scene: &Scene, mesh: &Mesh) -> Vec<Vector3<f64>> {
    let mut forces = vec![Vector3::zeros(); mesh.outline.len()];
    for load in scene.load.values() {
        let inside = region(&load.region, mesh);
        let bears: Vec<bool> = mesh.outline.iter().map(inside).collect();
        let mut shares = vec![0.0; forces.len()];
        for e in (0..mesh.edges.len()).filter(|&e| mesh.is_boundary(e)) {
            let ends = mesh.edges[e].map(|v| v as usize);
            if ends.iter().all(|&v| bears[v]) {
                ends.iter().for_each(|&v| shares[v] += mesh.edge_length(e));
            }
        }
        if shares.iter().all(|share| *share == 0.0) {
            let area = |v: usize| if bears[v] { mesh.vertex_areas[v] } else { 0.0 };
            shares = (0..forces.len()).map(area).collect();
        }
        let all: f64 = shares.iter().sum();
        if all > 0.0 {
            for (force, share) in forces.iter_mut().zip(shares) {
                *force += Vector3::from(load.force) * (share / all);
            }
        }
    }
    forces
}
