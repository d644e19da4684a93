//! What of the sheet may come near to an obstacle before either has moved far.

use nalgebra::Vector3;

use super::minimum::{First, least_on_edge, least_on_face};
use super::obstacle::{Obstacle, Shape};
use super::surface::{self, Candidates};
use crate::sheet::Mesh;

/// How far the sheet may move where it is not [`Nearby::close`] before it is near \[m\].
pub const FAR: f64 = 1e-2;

/// A flat side of an obstacle with vertices over it that come near to nothing else of it, nor do edges and faces there.
#[derive(Clone, Debug)]
pub struct Side {
    /// Outward, in the obstacle's frame, of length 1.
    pub normal: Vector3<f64>,
    /// How far it is from the obstacle's origin that way \[m\].
    pub level: f64,
    /// In rising order.
    pub vertices: Vec<u32>,
}

/// Features of the sheet that can come closer to an obstacle than a reach, and nearer there than anywhere on their
/// rim: all that [`super::detect`] must look at.
#[derive(Clone, Debug, Default)]
pub struct Nearby {
    /// All vertices near, in rising order: over flat sides, and in the rim.
    vertices: Vec<u32>,
    pub(super) sides: Vec<Side>,
    /// Ends of the edges and corners of the faces below, and vertices that are not over one side.
    pub(super) rim: Vec<u32>,
    pub(super) edges: Vec<u32>,
    pub(super) faces: Vec<u32>,
    /// Where the ends of the edges stand in `rim`.
    pub(super) edge_slots: Vec<[u32; 2]>,
    /// Where the corners of the faces stand in `rim`.
    pub(super) face_slots: Vec<[u32; 3]>,
    close: Vec<u32>,
    /// What may come near to a triangle mesh, in place of edges and faces.
    pub(super) candidates: Candidates,
}

impl Nearby {
    /// What may come near to a triangle mesh, with the vertices of all of it.
    pub(super) fn of_surface(sheet: usize, vertices: Vec<u32>, candidates: Candidates) -> Self {
        Self {
            rim: vertices.clone(),
            close: (0..sheet as u32).collect(),
            vertices,
            candidates,
            ..Self::default()
        }
    }

    /// The vertices that may be near, and all ends of the edges and corners of the faces that may be.
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// Flat sides with the vertices over them.
    pub fn sides(&self) -> &[Side] {
        &self.sides
    }

    /// The vertices that are not over one flat side.
    pub fn rim(&self) -> &[u32] {
        &self.rim
    }

    /// The vertices that must not move by the margin against the obstacle; the others must not move by [`FAR`].
    pub fn close(&self) -> &[u32] {
        &self.close
    }

    /// Collects the features that may be closer to `body` than `reach` before anything has moved by `margin` against
    /// it; distance has Lipschitz constant 1. Over a flat side it is linear, and nearest at vertices.
    pub fn find(
        mesh: &Mesh,
        positions: &[Vector3<f64>],
        body: &Obstacle,
        reach: f64,
        margin: f64,
    ) -> Self {
        let local = body.all_to_local(positions.iter());
        if let Shape::Mesh(surface) = &body.shape {
            let deep = surface.is_closed() && body.overlap.depth > 0.0;
            let reach = reach - body.overlap.depth;
            return surface::find(mesh, &local, surface, (reach, margin, deep));
        }
        let sheet = Sheet::new(body, local, margin);
        let reach = reach + margin - body.overlap.depth;
        let edges = (0..mesh.edges.len() as u32)
            .filter(|&e| sheet.edge_is_near(mesh.edges[e as usize], reach));
        let edges: Vec<u32> = edges.collect();
        let faces = (0..mesh.faces.len() as u32)
            .filter(|&f| sheet.face_is_near(mesh.faces[f as usize], reach));
        let faces: Vec<u32> = faces.collect();
        let mut in_rim = vec![false; positions.len()];
        let ends = edges.iter().flat_map(|&e| &mesh.edges[e as usize]);
        let corners = faces.iter().flat_map(|&f| &mesh.faces[f as usize]);
        for &v in ends.chain(corners) {
            in_rim[v as usize] = true;
        }
        let all = 0..positions.len() as u32;
        let is_near = |&v: &u32| in_rim[v as usize] || sheet.firsts[v as usize].0 < reach;
        let vertices: Vec<u32> = all.clone().filter(is_near).collect();
        let over_side = |v: &u32| !in_rim[*v as usize] && sheet.straight[*v as usize];
        let (over, rim): (Vec<u32>, Vec<u32>) = vertices.iter().partition(|v| over_side(v));
        let slot = |v: u32| rim.binary_search(&v).expect("every end is listed") as u32;
        let ends = edges.iter().map(|&e| mesh.edges[e as usize].map(slot));
        let corners = faces.iter().map(|&f| mesh.faces[f as usize].map(slot));
        // An edge or face with a vertex farther than that stays out of reach until all its vertices have moved as far.
        let close = reach + FAR + sheet.longest(mesh);
        Self {
            edge_slots: ends.collect(),
            face_slots: corners.collect(),
            sides: sheet.sides(&over),
            close: all
                .filter(|&v| sheet.firsts[v as usize].0 < close)
                .collect(),
            candidates: Candidates::default(),
            vertices,
            rim,
            edges,
            faces,
        }
    }
}

/// A sheet in the frame of a convex obstacle.
struct Sheet<'a> {
    shape: &'a Shape,
    local: Vec<Vector3<f64>>,
    firsts: Vec<First>,
    /// Whether the normal cannot turn where a vertex is.
    straight: Vec<bool>,
}

impl<'a> Sheet<'a> {
    fn new(body: &'a Obstacle, local: Vec<Vector3<f64>>, margin: f64) -> Self {
        let shape = &body.shape;
        let firsts = local.iter().map(|p| shape.first_order(p)).collect();
        let straight = local.iter().map(|p| shape.straight(p) > margin).collect();
        Self {
            shape,
            local,
            firsts,
            straight,
        }
    }

    fn over_one_side(&self, nodes: &[u32]) -> bool {
        let normal = self.firsts[nodes[0] as usize].1;
        let mut nodes = nodes.iter().map(|&v| v as usize);
        nodes.all(|v| self.straight[v] && self.firsts[v].1 == normal)
    }

    /// Sorts vertices by the sides that they are over.
    fn sides(&self, vertices: &[u32]) -> Vec<Side> {
        let mut sides: Vec<Side> = vec![];
        for &v in vertices {
            let normal = self.firsts[v as usize].1;
            match sides.iter_mut().find(|side| side.normal == normal) {
                Some(side) => side.vertices.push(v),
                None => sides.push(Side {
                    normal,
                    level: self.shape.level(&normal),
                    vertices: vec![v],
                }),
            }
        }
        sides
    }

    /// Length of the longest edge \[m\].
    fn longest(&self, mesh: &Mesh) -> f64 {
        let squares = mesh.edges.iter().map(|&[a, b]| self.square(a, b));
        squares.fold(0.0, f64::max).sqrt()
    }

    fn square(&self, a: u32, b: u32) -> f64 {
        (self.local[b as usize] - self.local[a as usize]).norm_squared()
    }

    fn edge_is_near(&self, ends: [u32; 2], reach: f64) -> bool {
        let firsts = ends.map(|v| &self.firsts[v as usize]);
        // The square is cheaper than the length.
        let apart = firsts[0].0 + firsts[1].0 - 2.0 * reach;
        if apart > 0.0 && apart * apart >= self.square(ends[0], ends[1]) {
            return false;
        }
        let places = ends.map(|v| self.local[v as usize]);
        !self.over_one_side(&ends) && least_on_edge(places, firsts) < reach
    }

    fn face_is_near(&self, corners: [u32; 3], reach: f64) -> bool {
        let [a, b, c] = corners;
        let firsts = corners.map(|v| &self.firsts[v as usize]);
        let lowest = firsts[0].0.min(firsts[1].0).min(firsts[2].0);
        // No point is farther from the nearest corner than the longest side over the root of three.
        let apart = lowest - reach;
        let longest = || {
            self.square(a, b)
                .max(self.square(b, c))
                .max(self.square(c, a))
        };
        if apart > 0.0 && 3.0 * apart * apart >= longest() || self.over_one_side(&corners) {
            return false;
        }
        let places = corners.map(|v| self.local[v as usize]);
        let centre = (places[0] + places[1] + places[2]) / 3.0;
        let at_centre = self.shape.first_order(&centre);
        let tangents = places.iter().zip(firsts).chain([(&centre, &at_centre)]);
        let mut least = tangents.map(|tangent| least_on_face(&places, tangent));
        least.all(|least| least < reach)
    }
}

/// How deep the middle of the sheet is inside an obstacle that is a closed mesh \[m\], not negative; 0 for others, which see
/// the sheet wherever it is.
pub fn depth_inside(mesh: &Mesh, positions: &[Vector3<f64>], body: &Obstacle) -> f64 {
    match &body.shape {
        Shape::Mesh(surface) if surface.is_closed() => {
            let local = body.all_to_local(positions.iter());
            surface::depth_inside(mesh, &local, surface)
        }
        _ => 0.0,
    }
}
