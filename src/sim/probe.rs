//! Where a reading is taken: the mean over places of the sheet, as weights of vertices.

use nalgebra::{Vector2, Vector3};

use super::regions::shares;
use crate::scene::Region;
use crate::sheet::Mesh;

/// A mean position as weights of vertices, which sum to one; none where a region holds no vertex.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    weights: Vec<(usize, f64)>,
}

impl Probe {
    /// The mean over some points, in the sheet's x, y \[m\], each linear in its face.
    pub fn at(mesh: &Mesh, points: &[Vector2<f64>]) -> Self {
        let share = 1.0 / points.len() as f64;
        let mut weights = vec![];
        for point in points {
            let found = mesh.faces.iter().map(|f| (f, barycentric(mesh, f, point)));
            let least = |w: &[f64; 3]| w.iter().copied().fold(f64::INFINITY, f64::min);
            let best = found.max_by(|(_, a), (_, b)| least(a).total_cmp(&least(b)));
            if let Some((face, w)) = best {
                weights.extend((0..3).map(|k| (face[k] as usize, w[k] * share)));
            }
        }
        Self { weights }
    }

    /// The mean over a region, along boundary edges if it has some, else by area.
    pub fn over(mesh: &Mesh, region: &Region) -> Self {
        let shares = shares(region, mesh);
        let weights = shares.into_iter().enumerate().filter(|(_, w)| *w > 0.0);
        Self {
            weights: weights.collect(),
        }
    }

    /// Whether there is nothing to read: no vertex lies in the region.
    pub fn is_empty(&self) -> bool {
        self.weights.is_empty()
    }

    /// Mean of positions \[m\].
    pub fn read(&self, positions: &[Vector3<f64>]) -> Vector3<f64> {
        self.weights.iter().map(|(v, w)| positions[*v] * *w).sum()
    }
}

fn barycentric(mesh: &Mesh, face: &[u32; 3], p: &Vector2<f64>) -> [f64; 3] {
    let [a, b, c] = face.map(|v| mesh.outline[v as usize]);
    let area = (b - a).perp(&(c - a));
    let (u, v) = ((c - b).perp(&(p - b)) / area, (a - c).perp(&(p - c)) / area);
    [u, v, 1.0 - u - v]
}
