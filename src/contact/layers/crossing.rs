//! Whether a sheet crosses itself, with exact predicates (Shewchuk 1997, crate `robust`).

use nalgebra::Vector3;
use robust::{Coord3D, orient3d};

use crate::sheet::Mesh;

type Point = Vector3<f64>;

/// Whether the segment from `p` to `q` passes through the inside of a triangle. Exact for every input; what merely
/// touches, or lies in the triangle's plane, does not cross.
pub fn crosses([p, q]: [&Point; 2], [a, b, c]: [&Point; 3]) -> bool {
    let side = |a: &Point, b: &Point, c: &Point, d: &Point| {
        let [a, b, c, d] = [a, b, c, d].map(|v| Coord3D {
            x: v.x,
            y: v.y,
            z: v.z,
        });
        orient3d(a, b, c, d)
    };
    let (above, below) = (side(a, b, c, p), side(a, b, c, q));
    if above == 0.0 || below == 0.0 || (above > 0.0) == (below > 0.0) {
        return false;
    }
    let turns = [side(p, q, a, b), side(p, q, b, c), side(p, q, c, a)];
    turns.iter().all(|t| *t > 0.0) || turns.iter().all(|t| *t < 0.0)
}

/// Edges and faces that cross among some pairs of faces; features that share a vertex do not count. Sorted.
pub fn crossings(
    mesh: &Mesh,
    positions: &[Point],
    pairs: impl Iterator<Item = [u32; 2]>,
) -> Vec<[u32; 2]> {
    let mut found = vec![];
    for [f, g] in pairs {
        for [f, g] in [[f, g], [g, f]] {
            let corners = mesh.faces[g as usize];
            for e in mesh.face_edges[f as usize] {
                let ends = mesh.edges[e as usize];
                if corners.iter().any(|v| ends.contains(v)) {
                    continue;
                }
                let segment = ends.map(|v| &positions[v as usize]);
                if crosses(segment, corners.map(|v| &positions[v as usize])) {
                    found.push([e, g]);
                }
            }
        }
    }
    found.sort_unstable();
    found.dedup();
    found
}
