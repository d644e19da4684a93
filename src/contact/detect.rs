//! Where the sheet is nearest to an obstacle: at vertices, within edges, within faces.
//!
//! Distance to a convex obstacle is a convex function, so over a face it has one minimum. It lies at a
//! vertex, within an edge, or inside; looking at all three covers the whole surface, not only its vertices. A triangle
//! mesh is not convex: [`super::surface`] looks for all minima.

use nalgebra::Vector3;

use super::distance::Distance;
use super::layers;
use super::nearby::Nearby;
use super::obstacle::{Obstacle, Shape};
use super::search::{Place, Search, Spot};
use super::surface::Part;
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
    /// What forces need of it.
    pub fn spot(&self) -> Spot {
        Spot {
            key: self.key,
            obstacle: self.obstacle,
            face: self.face,
            weights: self.weights,
            share: self.share,
            distance: self.distance.value,
            normal: self.distance.normal,
        }
    }

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
pub(super) const FEATURE_BITS: u32 = 40;
/// Bits of the obstacle, above which stands the number of a contact among those of one feature.
pub(super) const OBSTACLE_BITS: u32 = 16;
const OBSTACLE_MASK: u64 = ((1 << OBSTACLE_BITS) - 1) << FEATURE_BITS;

pub(super) fn key(obstacle: u32, kind: u64, feature: u32) -> u64 {
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
    pub(super) fn on_vertex(&self, vertex: usize) -> (u32, [f64; 3]) {
        let (face, corner) = self.vertex[vertex];
        let mut weights = [0.0; 3];
        weights[corner as usize] = 1.0;
        (face, weights)
    }

    /// A face of an edge, with the weights in it of a point at a fraction of the way along the edge.
    pub(super) fn on_edge(&self, mesh: &Mesh, edge: usize, t: f64) -> (u32, [f64; 3]) {
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
    let (_, body) = obstacle;
    let position = |v: u32| positions[v as usize];
    let first = found.len();
    let add = |place: Place| {
        let distance = match (&body.shape, place.part) {
            (Shape::Mesh(surface), Some(part)) => surface.distance_to(part, &place.at),
            (shape, _) => shape.distance(&place.at),
        };
        found.push(Proximity {
            key: place.key,
            obstacle: place.obstacle,
            face: place.face,
            weights: place.weights,
            share: place.share,
            distance: body.to_world(&distance),
            part: place.part,
        });
    };
    let mut search = Search::default();
    search.run(
        (mesh, features, position),
        obstacle,
        (nearby, &nearby.sides),
        reach,
        add,
    );
    if !nearby.sides.is_empty() {
        let vertices = found[first..].iter().take_while(|near| near.freedom() == 0);
        let end = first + vertices.count();
        found[first..end].sort_unstable_by_key(|near| near.key);
    }
}

/// Share of a point that lies nearer than the rim by `lead` \[m\].
pub(super) fn share(lead: f64) -> f64 {
    let s = (lead / LEAD).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}
