//! Vertices, edges and faces of the sheet in pairs: who answers for them, and how far apart they are.

use nalgebra::Vector3;

use super::bounds::{max, min};
use super::closest::between;
use super::tiles::Tiles;
use crate::sheet::Mesh;

type Point = Vector3<f64>;

/// Calls `each` with the pairs of features that two faces answer for and that share no vertex: a vertex and a face
/// (false), or two edges (true), the smaller first.
#[inline]
pub(super) fn features(
    tiles: &Tiles,
    mesh: &Mesh,
    pair: [u32; 2],
    mut each: impl FnMut(bool, [u32; 2]),
) {
    for [f, g] in [pair, [pair[1], pair[0]]] {
        let corners = mesh.faces[g as usize];
        for v in mesh.faces[f as usize] {
            if tiles.vertex_keeper[v as usize] == f && !corners.contains(&v) {
                each(false, [v, g]);
            }
        }
    }
    let [f, g] = pair;
    for a in mesh.face_edges[f as usize] {
        if tiles.edge_keeper[a as usize] != f {
            continue;
        }
        let [p, q] = mesh.edges[a as usize];
        for b in mesh.face_edges[g as usize] {
            let ends = mesh.edges[b as usize];
            if tiles.edge_keeper[b as usize] == g && !ends.contains(&p) && !ends.contains(&q) {
                each(true, [a.min(b), a.max(b)]);
            }
        }
    }
}

/// The four nodes of a pair of features.
#[inline]
pub(super) fn nodes(mesh: &Mesh, edges: bool, [first, second]: [u32; 2]) -> [u32; 4] {
    if edges {
        let ([a, b], [c, d]) = (mesh.edges[first as usize], mesh.edges[second as usize]);
        [a, b, c, d]
    } else {
        let [a, b, c] = mesh.faces[second as usize];
        [first, a, b, c]
    }
}

/// Distance of a pair of features \[m\] if it is below `reach`.
#[inline]
pub(super) fn closer(
    mesh: &Mesh,
    positions: &[Point],
    (edges, pair): (bool, [u32; 2]),
    reach: f64,
) -> Option<f64> {
    let x = nodes(mesh, edges, pair).map(|v| positions[v as usize]);
    // Most pairs are apart along an axis, which is cheap to see.
    for k in 0..3 {
        let [a, b, c, d] = [x[0][k], x[1][k], x[2][k], x[3][k]];
        let (first, second) = match edges {
            true => ([min(a, b), max(a, b)], [min(c, d), max(c, d)]),
            false => ([a, a], [min(b, min(c, d)), max(b, max(c, d))]),
        };
        if first[0] - second[1] >= reach || second[0] - first[1] >= reach {
            return None;
        }
    }
    let distance = between(edges, &x);
    (distance < reach).then_some(distance)
}

/// Distance of a pair of features \[m\].
#[cfg(test)]
pub(super) fn distance(mesh: &Mesh, positions: &[Point], edges: bool, pair: [u32; 2]) -> f64 {
    between(
        edges,
        &nodes(mesh, edges, pair).map(|v| positions[v as usize]),
    )
}
