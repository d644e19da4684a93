//! What of the sheet may come near to an obstacle before either has moved far.

use nalgebra::Vector3;

use super::minimum::{First, least_from_sides, least_on_edge, least_on_face, within_edge};
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
    /// Where the rim stands in `vertices`.
    rim_slots: Vec<u32>,
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
        let firsts = local.iter().map(|p| body.shape.first_order(p)).collect();
        let sheet = Sheet {
            shape: &body.shape,
            local: &local,
            firsts,
            margin,
        };
        let reach = reach + margin - body.overlap.depth;
        let edges = (0..mesh.edges.len() as u32).map(|e| (e, mesh.edges[e as usize]));
        let faces = (0..mesh.faces.len() as u32).map(|f| (f, mesh.faces[f as usize]));
        let all = 0..positions.len() as u32;
        // An edge or face with a vertex farther than that stays out of reach until all its vertices have moved as far.
        let close = reach + FAR + sheet.longest(mesh);
        let is_close = |&v: &u32| sheet.firsts[v as usize].0 < close;
        Self {
            close: all.clone().filter(is_close).collect(),
            ..sheet.select(&Vec::from_iter(all), edges, faces, reach)
        }
    }

    /// Of what is near a convex obstacle, what may be closer than `reach` before anything has moved by a smaller `margin`.
    /// `None` for a triangle mesh.
    pub fn narrow(
        &self,
        position: impl Fn(u32) -> Vector3<f64>,
        body: &Obstacle,
        reach: f64,
        margin: f64,
    ) -> Option<Self> {
        if let Shape::Mesh(_) = &body.shape {
            return None;
        }
        let frame = body.frame();
        let local: Vec<_> = self.vertices.iter().map(|&v| frame(&position(v))).collect();
        let sheet = Sheet {
            shape: &body.shape,
            firsts: local.iter().map(|p| body.shape.first_order(p)).collect(),
            local: &local,
            margin,
        };
        let reach = reach + margin - body.overlap.depth;
        let slot = |i: u32| self.rim_slots[i as usize];
        let edges = self.edges.iter().zip(&self.edge_slots);
        let edges = edges.map(|(&e, ends)| (e, ends.map(slot)));
        let faces = self.faces.iter().zip(&self.face_slots);
        let faces = faces.map(|(&f, corners)| (f, corners.map(slot)));
        Some(sheet.select(&self.vertices, edges, faces, reach))
    }
}

/// Vertices of the sheet in the frame of a convex obstacle.
struct Sheet<'a> {
    shape: &'a Shape,
    local: &'a [Vector3<f64>],
    firsts: Vec<First>,
    /// How far they may move \[m\].
    margin: f64,
}

impl Sheet<'_> {
    /// Selects from edges and faces with the places of their ends and corners in the list, whose names are `vertices`, in
    /// rising order.
    fn select(
        &self,
        vertices: &[u32],
        edges: impl Iterator<Item = (u32, [u32; 2])>,
        faces: impl Iterator<Item = (u32, [u32; 3])>,
        reach: f64,
    ) -> Nearby {
        let (edges, ends): (Vec<u32>, Vec<[u32; 2]>) = edges
            .filter(|(_, ends)| self.edge_is_near(*ends, reach))
            .unzip();
        let (faces, corners): (Vec<u32>, Vec<[u32; 3]>) = faces
            .filter(|(_, corners)| self.face_is_near(*corners, reach))
            .unzip();
        let mut in_rim = vec![false; vertices.len()];
        for &i in ends.iter().flatten().chain(corners.iter().flatten()) {
            in_rim[i as usize] = true;
        }
        let mut near = Nearby {
            edges,
            faces,
            ..Nearby::default()
        };
        // Where the vertices stand in the rim.
        let mut slots = vec![0; vertices.len()];
        for (i, &v) in vertices.iter().enumerate() {
            let (value, normal) = self.firsts[i];
            if !in_rim[i] && value >= reach {
                continue;
            }
            if in_rim[i] || !self.is_straight(i) {
                slots[i] = near.rim.len() as u32;
                near.rim.push(v);
                near.rim_slots.push(near.vertices.len() as u32);
            } else {
                self.put_over_side(&mut near.sides, v, normal);
            }
            near.vertices.push(v);
        }
        near.edge_slots = ends
            .iter()
            .map(|ends| ends.map(|i| slots[i as usize]))
            .collect();
        near.face_slots = corners
            .iter()
            .map(|three| three.map(|i| slots[i as usize]))
            .collect();
        near
    }

    fn put_over_side(&self, sides: &mut Vec<Side>, vertex: u32, normal: Vector3<f64>) {
        match sides.iter_mut().find(|side| side.normal == normal) {
            Some(side) => side.vertices.push(vertex),
            None => sides.push(Side {
                normal,
                level: self.shape.level(&normal),
                vertices: vec![vertex],
            }),
        }
    }

    /// Whether the normal cannot turn at a vertex.
    fn is_straight(&self, i: usize) -> bool {
        self.shape.straight(&self.local[i]) > self.margin
    }

    fn over_one_side(&self, nodes: &[u32]) -> bool {
        let normal = self.firsts[nodes[0] as usize].1;
        let mut nodes = nodes.iter().map(|&i| i as usize);
        nodes.all(|i| self.firsts[i].1 == normal && self.is_straight(i))
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
        let firsts = ends.map(|i| &self.firsts[i as usize]);
        // The square is cheaper than the length.
        let apart = firsts[0].0 + firsts[1].0 - 2.0 * reach;
        if apart > 0.0 && apart * apart >= self.square(ends[0], ends[1]) {
            return false;
        }
        let places = ends.map(|i| self.local[i as usize]);
        !self.over_one_side(&ends)
            && least_on_edge(places, firsts) < reach
            && within_edge(self.shape, places, firsts, reach).is_none_or(|(_, at)| at.0 < reach)
    }

    fn face_is_near(&self, corners: [u32; 3], reach: f64) -> bool {
        let [a, b, c] = corners;
        let firsts = corners.map(|i| &self.firsts[i as usize]);
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
        let places = corners.map(|i| self.local[i as usize]);
        let centre = (places[0] + places[1] + places[2]) / 3.0;
        let at_centre = self.shape.first_order(&centre);
        let mut tangents = places.iter().zip(firsts).chain([(&centre, &at_centre)]);
        let out_of_reach = |tangent| least_on_face(&places, tangent) >= reach;
        if tangents.any(out_of_reach) {
            return false;
        }
        let least = least_from_sides(self.shape, &places, firsts);
        least < reach && !(least > self.margin && self.has_no_corner_at(&places, &centre, reach))
    }

    /// Whether no corner of a box is as near to a face: then the face, if it is outside, is nearest to it on its rim.
    fn has_no_corner_at(
        &self,
        places: &[Vector3<f64>; 3],
        centre: &Vector3<f64>,
        reach: f64,
    ) -> bool {
        let Shape::Box { size } = self.shape else {
            return false;
        };
        let tip = Vector3::from(*size).zip_map(centre, |size, c| (0.5 * size).copysign(c));
        let radii = places.map(|place| (place - centre).norm());
        (tip - centre).norm() - radii[0].max(radii[1]).max(radii[2]) >= reach
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
