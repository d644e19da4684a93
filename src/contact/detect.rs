//! Where the sheet is nearest to an obstacle: at vertices, within edges, within faces.
//!
//! Distance to a convex obstacle is a convex function, so over a face it has one minimum. It lies at a
//! vertex, within an edge, or inside; looking at all three covers the whole surface, not only its vertices.

use nalgebra::Vector3;

use super::distance::Distance;
use super::obstacle::Obstacle;
use crate::sheet::Mesh;

/// A point of the sheet near an obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proximity {
    /// Stable identity: obstacle, kind of feature, index of the feature.
    pub key: u64,
    /// Index of the obstacle.
    pub obstacle: u32,
    /// A face that holds the point.
    pub face: u32,
    /// Barycentric coordinates of the point in that face.
    pub weights: [f64; 3],
    /// Share of the contact stiffness, 0 to 1: fades out where an edge's or face's nearest point runs into
    /// a corner, which is a proximity of its own, so that the force has no jump.
    pub share: f64,
    /// Distance from the middle surface to the obstacle there.
    pub distance: Distance,
}

impl Proximity {
    /// In how many ways the point can slide on its feature: 0 at a vertex, 1 in an edge, 2 in a face.
    pub fn freedom(&self) -> usize {
        self.weights.iter().filter(|&&w| w > 0.0).count() - 1
    }

    /// Changes of the weights that slide the point: one along an edge, two in a face (unused ones are zero).
    pub fn slides(&self) -> [[f64; 3]; 2] {
        let corners: Vec<usize> = (0..3).filter(|&k| self.weights[k] > 0.0).collect();
        let mut slides = [[0.0; 3]; 2];
        for (slide, &corner) in slides.iter_mut().zip(&corners[1..]) {
            slide[corners[0]] = -1.0;
            slide[corner] = 1.0;
        }
        slides
    }
}

/// Fraction of an edge (or of a face's height) over which the share fades to zero.
const FADE: f64 = 0.2;
/// Bisections of an edge: 1e-9 of its length.
const BISECTIONS: usize = 30;

/// Precomputed incidence for [`detect`].
#[derive(Clone, Debug)]
pub struct Features {
    /// A face of each vertex and the vertex's corner in it.
    vertex: Vec<(u32, u8)>,
    /// A face of each edge and the corner opposite to the edge in it.
    edge: Vec<(u32, u8)>,
}

impl Features {
    /// Collects incidence from a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let mut vertex = vec![(0, 0); mesh.material.len()];
        let mut edge = vec![(0, 0); mesh.edges.len()];
        for f in (0..mesh.faces.len()).rev() {
            for k in 0..3 {
                vertex[mesh.faces[f][k] as usize] = (f as u32, k as u8);
                edge[mesh.face_edges[f][k] as usize] = (f as u32, k as u8);
            }
        }
        Self { vertex, edge }
    }
}

/// Appends every point of the sheet that is nearest to `obstacle` on its feature and closer than `reach`.
/// Order: vertices, edges, faces, each by index.
pub fn detect(
    mesh: &Mesh,
    features: &Features,
    positions: &[Vector3<f64>],
    obstacle: (u32, &Obstacle),
    reach: f64,
    found: &mut Vec<Proximity>,
) {
    let (index, body) = obstacle;
    let values: Vec<Distance> = positions.iter().map(|x| body.distance(x)).collect();
    let key = |kind: u64, feature: usize| (u64::from(index) << 40) | (kind << 36) | feature as u64;
    for (v, distance) in values.iter().enumerate().filter(|(_, d)| d.value < reach) {
        let (face, corner) = features.vertex[v];
        let mut weights = [0.0; 3];
        weights[corner as usize] = 1.0;
        found.push(Proximity {
            key: key(0, v),
            obstacle: index,
            face,
            weights,
            share: 1.0,
            distance: *distance,
        });
    }
    for (e, ends) in mesh.edges.iter().enumerate() {
        let [a, b] = ends.map(|v| v as usize);
        let Some((t, distance)) = within_edge(
            body,
            [positions[a], positions[b]],
            [&values[a], &values[b]],
            reach,
        ) else {
            continue;
        };
        let (face, corner) = features.edge[e];
        let mut weights = [0.0; 3];
        for k in 0..3 {
            if k != corner as usize {
                let at_a = mesh.faces[face as usize][k] as usize == a;
                weights[k] = if at_a { 1.0 - t } else { t };
            }
        }
        found.push(Proximity {
            key: key(1, e),
            obstacle: index,
            face,
            weights,
            share: fade(t.min(1.0 - t)),
            distance,
        });
    }
    for (f, face) in mesh.faces.iter().enumerate() {
        let corners = face.map(|v| positions[v as usize]);
        let ends = face.map(|v| &values[v as usize]);
        if let Some((weights, distance)) = within_face(body, &corners, ends, reach) {
            let nearest_side = weights.iter().fold(1.0, |m: f64, &w| m.min(w));
            found.push(Proximity {
                key: key(2, f),
                obstacle: index,
                face: f as u32,
                weights,
                share: fade(nearest_side),
                distance,
            });
        }
    }
}

fn fade(fraction: f64) -> f64 {
    let s = (fraction / FADE).min(1.0);
    s * s * (3.0 - 2.0 * s)
}

/// Minimum of the distance strictly inside an edge, if it is below `reach`.
fn within_edge(
    body: &Obstacle,
    ends: [Vector3<f64>; 2],
    values: [&Distance; 2],
    reach: f64,
) -> Option<(f64, Distance)> {
    let along = ends[1] - ends[0];
    // Distance has Lipschitz constant 1: far edges need no search.
    if 0.5 * (values[0].value + values[1].value - along.norm()) > reach {
        return None;
    }
    if values[0].normal.dot(&along) >= 0.0 || values[1].normal.dot(&along) <= 0.0 {
        return None;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        let slope = body
            .distance(&(ends[0] + along * middle))
            .normal
            .dot(&along);
        if slope < 0.0 {
            low = middle
        } else {
            high = middle
        }
    }
    let t = 0.5 * (low + high);
    let distance = body.distance(&(ends[0] + along * t));
    (distance.value < reach).then_some((t, distance))
}

/// Minimum of the distance strictly inside a face, if it is below `reach`.
fn within_face(
    body: &Obstacle,
    corners: &[Vector3<f64>; 3],
    values: [&Distance; 3],
    reach: f64,
) -> Option<([f64; 3], Distance)> {
    let [a, b, c] = *corners;
    let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
    let lowest = values[0].value.min(values[1].value).min(values[2].value);
    if lowest - longest > reach {
        return None;
    }
    // Inside, the normal must turn: on one flat side of the obstacle it does not.
    let turns = values[0].normal.dot(&values[1].normal) < 1.0 - 1e-12
        || values[0].normal.dot(&values[2].normal) < 1.0 - 1e-12;
    if !turns {
        return None;
    }
    // Minimise over lines from side ab to c: the envelope is convex again.
    let inner = |s: f64| {
        let foot = a + (b - a) * s;
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            let slope = body
                .distance(&(foot + (c - foot) * middle))
                .normal
                .dot(&(c - foot));
            if slope < 0.0 {
                low = middle
            } else {
                high = middle
            }
        }
        let t = 0.5 * (low + high);
        let distance = body.distance(&(foot + (c - foot) * t));
        (t, distance)
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        let (t, distance) = inner(middle);
        let slope = distance.normal.dot(&(b - a)) * (1.0 - t);
        if slope < 0.0 {
            low = middle
        } else {
            high = middle
        }
    }
    let s = 0.5 * (low + high);
    let (t, distance) = inner(s);
    let weights = [(1.0 - s) * (1.0 - t), s * (1.0 - t), t];
    let inside = weights.iter().all(|&w| w > 1e-6);
    (inside && distance.value < reach).then_some((weights, distance))
}
