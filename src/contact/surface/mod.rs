//! Obstacles that are triangle meshes: a solid inside a closed one, a plate without thickness where it is open.

mod build;
mod detect;
mod near;
mod read;
#[cfg(test)]
pub(crate) mod test;

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::Bvh;
use serde::{Deserialize, Serialize};

use super::distance::Distance;
use super::layers::point_to_face;

pub(super) use detect::{Found, detect};
pub(super) use near::{Candidates, depth_inside, find};

type Point = Vector3<f64>;

/// Most triangles of a surface.
pub const MOST_TRIANGLES: usize = 200_000;
/// Largest coordinate of a surface \[m\].
pub const FARTHEST: f64 = 1e3;

/// Why triangles are not a surface.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SurfaceError {
    /// Nothing there.
    #[error("has no triangles: must have 1 to {MOST_TRIANGLES}")]
    Empty,
    /// Too much of it.
    #[error("has {found} triangles: must have 1 to {MOST_TRIANGLES}")]
    TooMany {
        /// How many there are.
        found: usize,
    },
    /// A vertex that is nowhere, or far away.
    #[error(
        "vertex {vertex} has a coordinate of {value} m: must be from -{FARTHEST} to {FARTHEST} m"
    )]
    Place {
        /// Which vertex, from 0.
        vertex: usize,
        /// The coordinate \[m\].
        value: f64,
    },
    /// A triangle of vertices that are not there.
    #[error("triangle {triangle} has vertex {index}: must be from 0 to {last}")]
    Index {
        /// Which triangle, from 0.
        triangle: usize,
        /// The index.
        index: u32,
        /// The last that there is.
        last: usize,
    },
    /// A triangle without a normal.
    #[error("triangle {triangle} has no area: must be none of its corners in line or in one place")]
    Degenerate {
        /// Which triangle, from 0.
        triangle: usize,
    },
    /// Bytes that are no file of a known kind.
    #[error("cannot be read as {format}: {reason}")]
    Format {
        /// The kind of file.
        format: &'static str,
        /// What its reader says.
        reason: String,
    },
}

/// What of a surface is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// The inside of a triangle.
    Face(u32),
    /// The inside of an edge.
    Edge(u32),
    /// A vertex.
    Vertex(u32),
}

/// Triangles as they are written in a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Triangles {
    /// Corners \[m\].
    pub vertices: Vec<[f64; 3]>,
    /// Three vertices each, from 0.
    pub triangles: Vec<[u32; 3]>,
}

/// A triangle mesh, ready for queries. Copies share it.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "Triangles", into = "Triangles")]
pub struct Surface(Arc<Body>);

struct Body {
    given: Triangles,
    vertices: Vec<Point>,
    edges: Vec<[u32; 2]>,
    /// Edges of each triangle, each opposite to its corner.
    sides: Vec<[u32; 3]>,
    /// Normals of triangles, out of a closed surface.
    normals: Vec<Point>,
    /// Normals of edges and vertices that tell inside from outside (Baerentzen and Aanaes 2005).
    edge_normals: Vec<Point>,
    vertex_normals: Vec<Point>,
    /// How many triangles there are around each edge and each vertex.
    edge_faces: Vec<u32>,
    vertex_faces: Vec<u32>,
    /// Angle by which the surface turns up at each edge, seen from the side of the normals \[rad\]; where it does not
    /// have two triangles, minus infinity.
    folds: Vec<f64>,
    /// Directions from each edge into its triangles, and from each vertex along its edges.
    around_edges: Vec<Vec<Point>>,
    around_vertices: Vec<Vec<Point>>,
    /// A number of the smooth part of the surface that holds each triangle.
    patches: Vec<u32>,
    /// Two triangles at each edge, one at each vertex.
    edge_face: Vec<[u32; 2]>,
    vertex_face: Vec<u32>,
    closed: bool,
    tree: Bvh,
    digest: u64,
}

impl std::fmt::Debug for Body {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (vertices, triangles) = (self.vertices.len(), self.sides.len());
        write!(f, "{vertices} vertices, {triangles} triangles")
    }
}

impl PartialEq for Surface {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0.given == other.0.given
    }
}

impl From<Surface> for Triangles {
    fn from(surface: Surface) -> Self {
        surface.0.given.clone()
    }
}

/// A point as the tree takes it.
fn tree_point(p: &Point) -> Vector {
    Vector::new(p.x, p.y, p.z)
}

/// The box around points, wider by `reach` on all sides.
fn box_around<'a>(points: impl IntoIterator<Item = &'a Point>, reach: f64) -> Aabb {
    let mut low = Point::repeat(f64::INFINITY);
    let mut high = -low;
    for p in points {
        (low, high) = (low.inf(p), high.sup(p));
    }
    let wide = Point::repeat(reach);
    Aabb::new(tree_point(&(low - wide)), tree_point(&(high + wide)))
}

impl Surface {
    /// Vertices \[m\], in the frame of the obstacle.
    pub fn vertices(&self) -> &[Point] {
        &self.0.vertices
    }

    /// Vertices of each triangle.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.0.given.triangles
    }

    /// Vertices of each triangle, in the order in which they turn about its normal, whichever way they are written.
    pub fn outward(&self) -> impl Iterator<Item = [u32; 3]> {
        let turned = |(t, &[a, b, c]): (usize, &[u32; 3])| {
            let [p, q, r] = [a, b, c].map(|v| self.0.vertices[v as usize]);
            match (q - p).cross(&(r - p)).dot(&self.0.normals[t]) < 0.0 {
                true => [a, c, b],
                false => [a, b, c],
            }
        };
        self.triangles().iter().enumerate().map(turned)
    }

    /// Whether it encloses a solid: every edge has two triangles, and they can be turned to face out.
    pub fn is_closed(&self) -> bool {
        self.0.closed
    }

    /// A hash of vertices and triangles.
    pub fn digest(&self) -> u64 {
        self.0.digest
    }

    /// Normal of a triangle, out of a closed surface.
    pub fn normal(&self, triangle: usize) -> Point {
        self.0.normals[triangle]
    }

    /// Edges of the surface that are not inside a smooth part of it, as their ends \[m\].
    pub fn ridges(&self) -> impl Iterator<Item = [Point; 2]> {
        let body = &*self.0;
        let patch = |t: usize| body.patches[t];
        let mut joined = vec![None; body.edges.len()];
        let mut ridge = vec![false; body.edges.len()];
        for (t, sides) in body.sides.iter().enumerate() {
            for &e in sides {
                let e = e as usize;
                ridge[e] |= joined[e].is_some_and(|other| other != patch(t));
                joined[e] = Some(patch(t));
            }
        }
        let of_one = |e: usize| body.edge_faces[e] != 2;
        let drawn = (0..body.edges.len()).filter(move |&e| ridge[e] || of_one(e));
        drawn.map(|e| body.edges[e].map(|v| body.vertices[v as usize]))
    }

    fn corners(&self, triangle: u32) -> [&Point; 3] {
        let body = &*self.0;
        body.given.triangles[triangle as usize].map(|v| &body.vertices[v as usize])
    }

    /// The nearest part of a triangle, and the point there.
    fn nearest_of(&self, triangle: u32, p: &Point) -> (Part, Point) {
        let corners = self.corners(triangle);
        let weights = point_to_face(p, corners);
        let at = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
        let positive = weights.iter().filter(|w| **w > 0.0).count();
        let corner = |zero: bool| (0..3).find(|&k| (weights[k] == 0.0) == zero).unwrap_or(0);
        let part = match positive {
            3 => Part::Face(triangle),
            2 => Part::Edge(self.0.sides[triangle as usize][corner(true)]),
            _ => Part::Vertex(self.0.given.triangles[triangle as usize][corner(false)]),
        };
        (part, at)
    }

    /// The nearest part of all, within a distance \[m\].
    fn nearest(&self, p: &Point, within: f64) -> Option<Part> {
        let at = tree_point(p);
        let best = self.0.tree.find_best(
            within,
            |node, _| {
                parry3d_f64::query::PointQuery::distance_to_local_point(&node.aabb(), at, true)
            },
            |t, _| {
                let (part, foot) = self.nearest_of(t, p);
                Some(((p - foot).norm(), part))
            },
        );
        best.map(|(_, (_, part))| part)
    }

    /// Distance from all of it, negative inside of a closed one.
    pub(super) fn distance(&self, p: &Point) -> Distance {
        // A closed surface is nearest where it can be seen, so the sign of the nearest part holds.
        let part = self.nearest(p, f64::MAX).unwrap_or(Part::Face(0));
        self.distance_to(part, p)
    }

    /// Distance from one part of it, prolonged to its plane or line; negative behind a closed one.
    pub(super) fn distance_to(&self, part: Part, p: &Point) -> Distance {
        let body = &*self.0;
        match part {
            Part::Face(t) => {
                let normal = body.normals[t as usize];
                let value = normal.dot(&(p - self.corners(t)[0]));
                let back = value < 0.0 && !body.closed;
                Distance {
                    value: if back { -value } else { value },
                    normal: if back { -normal } else { normal },
                    curvature: Matrix3::zeros(),
                }
            }
            Part::Edge(e) => {
                let [a, b] = body.edges[e as usize].map(|v| body.vertices[v as usize]);
                let along = (b - a).normalize();
                let off = p - a;
                let free = Matrix3::identity() - along * along.transpose();
                let offset = off - along * along.dot(&off);
                self.round(&offset, &body.edge_normals[e as usize], &free)
            }
            Part::Vertex(v) => {
                let offset = p - body.vertices[v as usize];
                let outward = &body.vertex_normals[v as usize];
                self.round(&offset, outward, &Matrix3::identity())
            }
        }
    }

    /// Distance from a line or point at an offset, where `free` projects on the directions in which that changes.
    fn round(&self, offset: &Point, outward: &Point, free: &Matrix3<f64>) -> Distance {
        let length = offset.norm();
        let inside = self.0.closed && offset.dot(outward) < 0.0;
        let sign = if inside { -1.0 } else { 1.0 };
        let normal = match length > TINY {
            true => offset * (sign / length),
            false => *outward,
        };
        let curvature = free - normal * normal.transpose();
        Distance {
            value: sign * length,
            normal,
            curvature: curvature * (sign / length.max(TINY)),
        }
    }
}

/// Lengths below this count as zero when a direction is wanted \[m\].
const TINY: f64 = 1e-12;
