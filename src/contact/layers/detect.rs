//! Pairs that are nearer than a reach, each point of the surface counted once.
//!
//! A vertex is compared with faces. Where it is nearest to a rim that faces share, each of them finds the same
//! distance. So shared edges are taken off and inner vertices put on again, as in Euler's formula: over flat or convex
//! cloth one of them is left, in a valley one for each side, and the sum has no jump anywhere (after the quadrature of
//! Li, Ferguson, Schneider et al., Convergent Incremental Potential Contact, 2023). Two edges count where they are nearer
//! to each other than any of their ends is to the other edge.

use nalgebra::Vector3;

use super::closest::{Pair, combine, point_to_face, point_to_segment, segment_to_segment};
use super::tiles::Tiles;
use crate::sheet::Mesh;

type Point = Vector3<f64>;

/// Lead of an edge's inside over its ends at which it counts in full, over the reach.
const LEAD: f64 = 0.05;
/// Distance below which there is no normal \[m\].
const TOUCHING: f64 = 1e-12;

/// Work space of [`vertex_pairs`].
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    faces: Vec<u32>,
    rims: Vec<(u64, f64, [u32; 4], [f64; 4])>,
}

fn key(kind: u64, first: u32, second: u32) -> u64 {
    kind << 62 | u64::from(first) << 31 | u64::from(second)
}

/// Whether a key belongs to a pair of vertex and face, edge or vertex, or of two edges, that the mesh has.
pub fn is_pair_of(mesh: &Mesh, key: u64) -> bool {
    let there = |part: Part| match part {
        Part::Vertex(v) => (v as usize) < mesh.material.len(),
        Part::Edge(e) => (e as usize) < mesh.edges.len(),
        Part::Face(f) => (f as usize) < mesh.faces.len(),
    };
    parts_of(key).into_iter().all(there)
}

/// A part of the sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// A vertex.
    Vertex(u32),
    /// An edge.
    Edge(u32),
    /// A face.
    Face(u32),
}

/// The first and the second feature of a pair.
pub fn parts_of(key: u64) -> [Part; 2] {
    let number = |shift: u32| (key >> shift & 0x7fff_ffff) as u32;
    let (first, second) = (number(31), number(0));
    match key >> 62 {
        0 => [Part::Vertex(first), Part::Face(second)],
        1 => [Part::Vertex(first), Part::Edge(second)],
        2 => [Part::Vertex(first), Part::Vertex(second)],
        _ => [Part::Edge(first), Part::Edge(second)],
    }
}

fn pair(
    positions: &[Point],
    (key, share): (u64, f64),
    nodes: [u32; 4],
    weights: [f64; 4],
) -> Option<Pair> {
    let offset = combine(&weights, &nodes.map(|v| positions[v as usize]));
    let distance = offset.norm();
    (distance > TOUCHING).then(|| Pair {
        key,
        nodes,
        weights,
        share,
        distance,
        normal: offset / distance,
    })
}

/// Appends the pairs of a vertex with some faces, in rising order, that are closer than `reach`; returns its distance
/// from the nearest of them.
pub fn vertex_pairs(
    (tiles, mesh): (&Tiles, &Mesh),
    positions: &[Point],
    (vertex, faces): (u32, &[u32]),
    reach: f64,
    scratch: &mut Scratch,
    found: &mut Vec<Pair>,
) -> f64 {
    let Scratch { faces: near, rims } = scratch;
    near.clear();
    rims.clear();
    let p = &positions[vertex as usize];
    let at = |v: u32| &positions[v as usize];
    let mut nearest = f64::INFINITY;
    for &f in faces {
        let corners = mesh.faces[f as usize];
        let inside = point_to_face(p, corners.map(at));
        let [a, b, c] = corners;
        let (nodes, weights) = ([vertex, a, b, c], signed(&inside));
        let square = combine(&weights, &nodes.map(|v| *at(v))).norm_squared();
        nearest = if square < nearest { square } else { nearest };
        if square >= reach * reach {
            continue;
        }
        near.push(f);
        let corner = |zero: bool| (0..3).find(|&k| (inside[k] == 0.0) == zero).unwrap_or(0);
        match inside.iter().filter(|&&w| w > 0.0).count() {
            3 => found.extend(pair(positions, (key(0, vertex, f), 1.0), nodes, weights)),
            2 => {
                let e = mesh.face_edges[f as usize][corner(true)];
                add(rims, key(1, vertex, e), 1.0, nodes, weights);
            }
            _ => add(
                rims,
                key(2, vertex, corners[corner(false)]),
                1.0,
                nodes,
                weights,
            ),
        }
    }
    for &f in near.iter() {
        let corners = mesh.faces[f as usize];
        for k in 0..3 {
            let e = mesh.face_edges[f as usize][k];
            let other = mesh.edge_faces[e as usize].into_iter().find(|&g| g != f);
            if other.is_some_and(|g| g > f && near.contains(&g)) {
                shared_edge((positions, vertex, reach), (e, corners, k), rims);
            }
        }
    }
    for n in 0..near.len() {
        let corners = mesh.faces[near[n] as usize];
        for k in 0..3 {
            let has = |f: &&u32| mesh.faces[**f as usize].contains(&corners[k]);
            let around = near.iter().filter(has).count();
            let first = near.iter().find(has) == Some(&near[n]);
            if first && around == tiles.star(corners[k]) && (p - at(corners[k])).norm() < reach {
                let [a, b, c] = corners;
                let mut inside = [0.0; 3];
                inside[k] = 1.0;
                let key = key(2, vertex, corners[k]);
                add(rims, key, 1.0, [vertex, a, b, c], signed(&inside));
            }
        }
    }
    for &(key, share, nodes, weights) in rims.iter().filter(|rim| rim.1 != 0.0) {
        found.extend(pair(positions, (key, share), nodes, weights));
    }
    nearest.sqrt()
}

/// Takes off what two faces have both found on the edge that they share.
fn shared_edge(
    (positions, vertex, reach): (&[Point], u32, f64),
    (e, corners, k): (u32, [u32; 3], usize),
    rims: &mut Vec<(u64, f64, [u32; 4], [f64; 4])>,
) {
    let p = &positions[vertex as usize];
    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
    let [a, b] = [i, j].map(|c| &positions[corners[c] as usize]);
    let t = point_to_segment(p, a, b);
    if (p - a - (b - a) * t).norm() >= reach {
        return;
    }
    let mut inside = [0.0; 3];
    inside[i] = 1.0 - t;
    inside[j] = t;
    let key = match t {
        0.0 => key(2, vertex, corners[i]),
        1.0 => key(2, vertex, corners[j]),
        _ => key(1, vertex, e),
    };
    let [a, b, c] = corners;
    add(rims, key, -1.0, [vertex, a, b, c], signed(&inside));
}

fn signed(inside: &[f64; 3]) -> [f64; 4] {
    [1.0, -inside[0], -inside[1], -inside[2]]
}

fn add(
    rims: &mut Vec<(u64, f64, [u32; 4], [f64; 4])>,
    key: u64,
    count: f64,
    nodes: [u32; 4],
    weights: [f64; 4],
) {
    match rims.iter_mut().find(|rim| rim.0 == key) {
        Some(rim) => rim.1 += count,
        None => rims.push((key, count, nodes, weights)),
    }
}

/// Distance of two edges, and the pair that they make if that is below `reach` and reached within both.
pub fn edge_pair(
    mesh: &Mesh,
    positions: &[Point],
    [first, second]: [u32; 2],
    reach: f64,
) -> (f64, Option<Pair>) {
    let nodes = super::features::nodes(mesh, true, [first, second]);
    let [a, b, c, d] = nodes.map(|v| &positions[v as usize]);
    let [s, t] = segment_to_segment(a, b, c, d);
    let distance = (a + (b - a) * s - c - (d - c) * t).norm();
    let inside = s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0;
    if distance >= reach || !inside {
        return (distance, None);
    }
    let end = |p: &Point, q: &Point, r: &Point| {
        let t = point_to_segment(p, q, r);
        (p - q - (r - q) * t).norm()
    };
    let rim = [end(a, c, d), end(b, c, d), end(c, a, b), end(d, a, b)];
    let rim = rim.into_iter().fold(f64::INFINITY, f64::min);
    let lead = ((rim - distance) / (LEAD * reach)).clamp(0.0, 1.0);
    let share = lead * lead * (3.0 - 2.0 * lead);
    if share == 0.0 {
        return (distance, None);
    }
    let key = (key(3, first, second), share);
    let weights = [1.0 - s, s, t - 1.0, -t];
    (distance, pair(positions, key, nodes, weights))
}
