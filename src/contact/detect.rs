//! Where the sheet is nearest to an obstacle: at vertices, within edges, within faces.
//!
//! Distance to a convex obstacle is a convex function, so over a face it has one minimum. It lies at a
//! vertex, within an edge, or inside; looking at all three covers the whole surface, not only its vertices. A triangle
//! mesh is not convex: [`super::surface`] looks for all minima.

use nalgebra::Vector3;

use super::distance::Distance;
use super::layers;
use super::minimum::{First, within_edge, within_face};
use super::nearby::Nearby;
use super::obstacle::{Obstacle, Shape};
use super::surface::{self, Found, Part, Surface};
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
    /// Share of the contact stiffness, 0 to 1: how much nearer the point is than the nearest one on the ends of
    /// its edge or the rim of its face, which are proximities of their own. So the force has no jump where the
    /// point runs into the rim, nor where a flat edge or face makes it leap.
    pub share: f64,
    /// Distance from the middle surface to the obstacle there.
    pub distance: Distance,
    /// What of a triangle mesh it is near to; `None` near other shapes.
    pub part: Option<Part>,
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

/// Bits of a key below the obstacle.
const FEATURE_BITS: u32 = 40;
/// Bits of the obstacle, above which stands the number of a contact among those of one feature.
const OBSTACLE_BITS: u32 = 16;
const OBSTACLE_MASK: u64 = ((1 << OBSTACLE_BITS) - 1) << FEATURE_BITS;

fn key(obstacle: u32, kind: u64, feature: u32) -> u64 {
    (u64::from(obstacle) << FEATURE_BITS) | (kind << 36) | u64::from(feature)
}

/// Index of the obstacle in a proximity's key.
pub fn obstacle_of(key: u64) -> u32 {
    ((key & OBSTACLE_MASK) >> FEATURE_BITS) as u32
}

/// The key of the same feature near the obstacle that has another index now.
pub fn with_obstacle(key: u64, obstacle: u32) -> u64 {
    key & !OBSTACLE_MASK | (u64::from(obstacle) << FEATURE_BITS)
}

/// Lead over the rim at which a point within an edge or face has its full share \[m\].
pub(super) const LEAD: f64 = 2e-5;

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

    /// A face that holds a part of the sheet.
    pub fn face_of(&self, part: layers::Part) -> u32 {
        match part {
            layers::Part::Vertex(v) => self.vertex[v as usize].0,
            layers::Part::Edge(e) => self.edge[e as usize].0,
            layers::Part::Face(f) => f,
        }
    }

    /// A face of a vertex, with the weights of the vertex in it.
    fn on_vertex(&self, vertex: usize) -> (u32, [f64; 3]) {
        let (face, corner) = self.vertex[vertex];
        let mut weights = [0.0; 3];
        weights[corner as usize] = 1.0;
        (face, weights)
    }

    /// A face of an edge, with the weights in it of a point at a fraction of the way along the edge.
    fn on_edge(&self, mesh: &Mesh, edge: usize, t: f64) -> (u32, [f64; 3]) {
        let (face, corner) = self.edge[edge];
        let mut weights = [0.0; 3];
        for k in (0..3).filter(|&k| k != corner as usize) {
            let at_a = mesh.faces[face as usize][k] == mesh.edges[edge][0];
            weights[k] = if at_a { 1.0 - t } else { t };
        }
        (face, weights)
    }
}

/// Appends every point of the sheet that is nearest to `obstacle` on its feature and closer than `reach`, among
/// the features `nearby`. Order: vertices, edges, faces, each by index.
pub fn detect(
    mesh: &Mesh,
    features: &Features,
    positions: &[Vector3<f64>],
    obstacle: (u32, &Obstacle),
    nearby: &Nearby,
    reach: f64,
    found: &mut Vec<Proximity>,
) {
    let (index, body) = obstacle;
    let reach = reach - body.overlap.depth;
    let local = body.all_to_local(nearby.vertices.iter().map(|&v| &positions[v as usize]));
    if let Shape::Mesh(surface) = &body.shape {
        let mut near = vec![];
        surface::detect(
            (mesh, surface),
            &nearby.candidates,
            &local,
            reach,
            &mut near,
        );
        let proximities = near
            .iter()
            .map(|near| near_surface((mesh, features), obstacle, surface, near));
        found.extend(proximities);
        return;
    }
    let values: Vec<First> = local.iter().map(|p| body.shape.first_order(p)).collect();
    let key = |kind: u64, feature: u32| key(index, kind, feature);
    let mut add = |key, face, weights, share, at: &Vector3<f64>| {
        let distance = body.to_world(&body.shape.distance(at));
        found.push(Proximity {
            key,
            obstacle: index,
            face,
            weights,
            share,
            distance,
            part: None,
        });
    };
    for (i, &v) in nearby.vertices.iter().enumerate() {
        if values[i].0 < reach {
            let (face, weights) = features.on_vertex(v as usize);
            add(key(0, v), face, weights, 1.0, &local[i]);
        }
    }
    // Minima of the edges, by edge, kept for the faces that they bound.
    let edges = nearby.edges.iter().zip(&nearby.edge_slots);
    let within = |(&e, slots): (&u32, &[u32; 2])| {
        let [a, b] = slots.map(|i| i as usize);
        let (ends, values) = ([local[a], local[b]], [&values[a], &values[b]]);
        let minimum = within_edge(&body.shape, ends, values, reach)?;
        Some((e, *slots, minimum))
    };
    let minima: Vec<(u32, [u32; 2], (f64, First))> = edges.filter_map(within).collect();
    for &(e, slots, (t, first)) in &minima {
        if first.0 >= reach {
            continue;
        }
        let ends = slots.map(|i| local[i as usize]);
        let (face, weights) = features.on_edge(mesh, e as usize, t);
        let at = ends[0] + (ends[1] - ends[0]) * t;
        let rim = slots.map(|i| values[i as usize].0);
        add(
            key(1, e),
            face,
            weights,
            share(rim[0].min(rim[1]) - first.0),
            &at,
        );
    }
    for (&f, slots) in nearby.faces.iter().zip(&nearby.face_slots) {
        let corners = slots.map(|i| local[i as usize]);
        let values = slots.map(|i| &values[i as usize]);
        let rim = |k: usize| {
            let e = mesh.face_edges[f as usize][k];
            let (_, _, (t, first)) = minima[minima.binary_search_by_key(&e, |m| m.0).ok()?];
            let forward = mesh.edges[e as usize][0] == mesh.faces[f as usize][(k + 1) % 3];
            Some((if forward { t } else { 1.0 - t }, first))
        };
        if let Some((weights, lead)) = within_face(&body.shape, &corners, values, rim, reach) {
            let at = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
            add(key(2, f), f, weights, share(lead), &at);
        }
    }
}

/// A point near a triangle mesh, in the world.
fn near_surface(
    (mesh, features): (&Mesh, &Features),
    (index, body): (u32, &Obstacle),
    surface: &Surface,
    near: &Found,
) -> Proximity {
    let feature = near.feature as usize;
    let (face, weights) = match near.kind {
        0 => features.on_vertex(feature),
        1 => features.on_edge(mesh, feature, near.weights[1]),
        _ => (near.feature, near.weights),
    };
    Proximity {
        key: key(index, near.kind, near.feature)
            | u64::from(near.number) << (FEATURE_BITS + OBSTACLE_BITS),
        obstacle: index,
        face,
        weights,
        share: near.share,
        distance: body.to_world(&surface.distance_to(near.part, &near.at)),
        part: Some(near.part),
    }
}

/// Share of a point that lies nearer than the rim by `lead` \[m\].
pub(super) fn share(lead: f64) -> f64 {
    let s = (lead / LEAD).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}
