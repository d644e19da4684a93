//! Planes that part two faces: a cheap look at what has long not touched.

use nalgebra::Vector3;

use super::bounds::{max, min};
use crate::sheet::Mesh;

type Point = Vector3<f64>;

/// Whether a plane across the line between their centres keeps two faces `reach` apart: most have long not touched, and
/// their features need no look.
#[inline]
pub(super) fn separated(mesh: &Mesh, positions: &[Point], faces: [u32; 2], reach: f64) -> bool {
    let line = between_centres(mesh, positions, faces);
    parted(mesh, positions, faces, &line, reach)
}

/// The same while they move straight from one place to another: along a fixed line the gap is least at one of the ends.
#[inline]
pub(super) fn separated_throughout(
    mesh: &Mesh,
    moments: [&[Point]; 2],
    faces: [u32; 2],
    reach: f64,
) -> bool {
    let [from, to] = moments.map(|positions| between_centres(mesh, positions, faces));
    let line = from + to;
    let parted = |positions: &[Point]| parted(mesh, positions, faces, &line, reach);
    moments.into_iter().all(parted)
}

/// The same for two features on a straight way: an edge and an edge, or a vertex and a face, each given by its vertices
/// at both ends of it.
#[inline]
pub(super) fn features_separated(edges: bool, moments: [&[Point; 4]; 2], reach: f64) -> bool {
    let split = if edges { 2 } else { 1 };
    let centre = |part: &[Point]| part.iter().sum::<Point>() / part.len() as f64;
    let way = |x: &[Point; 4]| centre(&x[split..]) - centre(&x[..split]);
    let line = way(moments[0]) + way(moments[1]);
    let gap = |x: &[Point; 4]| {
        let along = x.map(|p| line.dot(&p));
        let last = along[..split]
            .iter()
            .fold(f64::NEG_INFINITY, |m, a| max(m, *a));
        let first = along[split..].iter().fold(f64::INFINITY, |m, a| min(m, *a));
        first - last
    };
    let gap = min(gap(moments[0]), gap(moments[1]));
    gap >= 0.0 && gap * gap >= reach * reach * line.norm_squared()
}

/// Three times the way from the centre of one face to that of another.
#[inline]
fn between_centres(mesh: &Mesh, positions: &[Point], faces: [u32; 2]) -> Point {
    let [first, second] = faces.map(|f| mesh.faces[f as usize]);
    let sum =
        |[a, b, c]: [u32; 3]| positions[a as usize] + positions[b as usize] + positions[c as usize];
    sum(second) - sum(first)
}

#[inline]
fn parted(mesh: &Mesh, positions: &[Point], faces: [u32; 2], line: &Point, reach: f64) -> bool {
    let along = |f: u32| mesh.faces[f as usize].map(|v| line.dot(&positions[v as usize]));
    let ([a, b, c], [d, e, h]) = (along(faces[0]), along(faces[1]));
    let gap = min(d, min(e, h)) - max(a, max(b, c));
    gap >= 0.0 && gap * gap >= reach * reach * line.norm_squared()
}
