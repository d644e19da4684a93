//! The search for the points of the sheet that are nearest to an obstacle, in the obstacle's frame.

use nalgebra::Vector3;

use super::detect::{FEATURE_BITS, Features, OBSTACLE_BITS, key, share};
use super::minimum::{First, within_edge, within_face};
use super::nearby::{Nearby, Side};
use super::obstacle::{Obstacle, Shape};
use super::surface::{self, Found, Part, Surface};
use crate::sheet::Mesh;

/// A point that was found.
pub(super) struct Place {
    pub key: u64,
    pub obstacle: u32,
    pub face: u32,
    pub weights: [f64; 3],
    pub share: f64,
    /// In the obstacle's frame \[m\].
    pub at: Vector3<f64>,
    /// Distance and normal there.
    pub first: First,
    pub part: Option<Part>,
}

/// A point of the sheet near an obstacle, as forces need it: a [`super::Proximity`] without curvature.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    /// As of the proximity.
    pub key: u64,
    /// Index of the obstacle.
    pub obstacle: u32,
    /// A face that holds the point.
    pub face: u32,
    /// Barycentric coordinates of the point in that face.
    pub weights: [f64; 3],
    /// Share of the contact stiffness, 0 to 1.
    pub share: f64,
    /// Distance from the middle surface to the obstacle \[m\].
    pub distance: f64,
    /// Out of the obstacle, of length 1, world frame.
    pub normal: Vector3<f64>,
}

/// Minimum within an edge: the edge, its slots, fraction of the way, distance and normal.
type OnEdge = (u32, [u32; 2], (f64, First));

/// Work space of searches.
#[derive(Clone, Debug, Default)]
pub struct Search {
    /// The rim in the obstacle's frame \[m\].
    local: Vec<Vector3<f64>>,
    firsts: Vec<First>,
    /// Of the edges, by edge, kept for the faces that they bound.
    minima: Vec<OnEdge>,
    found: Vec<Found>,
}

impl Search {
    /// Appends the spots of the sheet on one obstacle, over `sides` and in the rim of `nearby`.
    pub fn spots(
        &mut self,
        sheet: (&Mesh, &Features, impl Fn(u32) -> Vector3<f64>),
        obstacle: (u32, &Obstacle),
        near: (&Nearby, &[Side]),
        reach: f64,
        spots: &mut Vec<Spot>,
    ) {
        let (_, body) = obstacle;
        let turn = body.pose.rotation.to_rotation_matrix();
        self.run(sheet, obstacle, near, reach, |place| {
            spots.push(Spot {
                key: place.key,
                obstacle: place.obstacle,
                face: place.face,
                weights: place.weights,
                share: place.share,
                distance: place.first.0 + body.overlap.depth,
                normal: turn * place.first.1,
            });
        });
    }

    /// Hands on what is closer than `reach`: vertices over the sides, then of the rim, edges, faces, each by index.
    pub(super) fn run(
        &mut self,
        (mesh, features, position): (&Mesh, &Features, impl Fn(u32) -> Vector3<f64>),
        (index, body): (u32, &Obstacle),
        (nearby, sides): (&Nearby, &[Side]),
        reach: f64,
        mut add: impl FnMut(Place),
    ) {
        let reach = reach - body.overlap.depth;
        let local = body.frame();
        self.local.clear();
        let places = nearby.rim.iter().map(|&v| local(&position(v)));
        self.local.extend(places);
        let sheet = (mesh, features);
        if let Shape::Mesh(surface) = &body.shape {
            return self.near_surface(sheet, (index, surface), nearby, reach, add);
        }
        let mut add_vertex = |v: u32, at, first: First| {
            if first.0 < reach {
                let on = features.on_vertex(v as usize);
                add(Place::on(on, (index, 0, v), 1.0, at, first));
            }
        };
        for side in sides {
            for &v in &side.vertices {
                let at = local(&position(v));
                add_vertex(v, at, (side.normal.dot(&at) - side.level, side.normal));
            }
        }
        self.firsts.clear();
        let firsts = self.local.iter().map(|p| body.shape.first_order(p));
        self.firsts.extend(firsts);
        for (i, &v) in nearby.rim.iter().enumerate() {
            add_vertex(v, self.local[i], self.firsts[i]);
        }
        self.edges(sheet, (index, &body.shape), nearby, reach, &mut add);
        self.faces(mesh, (index, &body.shape), nearby, reach, &mut add);
    }

    fn edges(
        &mut self,
        (mesh, features): (&Mesh, &Features),
        (index, shape): (u32, &Shape),
        nearby: &Nearby,
        reach: f64,
        add: &mut impl FnMut(Place),
    ) {
        self.minima.clear();
        for (&e, &slots) in nearby.edges.iter().zip(&nearby.edge_slots) {
            let ends = slots.map(|i| self.local[i as usize]);
            let values = slots.map(|i| &self.firsts[i as usize]);
            let Some((t, first)) = within_edge(shape, ends, values, reach) else {
                continue;
            };
            self.minima.push((e, slots, (t, first)));
            if first.0 < reach {
                let at = ends[0] + (ends[1] - ends[0]) * t;
                let lead = values[0].0.min(values[1].0) - first.0;
                let on = features.on_edge(mesh, e as usize, t);
                add(Place::on(on, (index, 1, e), share(lead), at, first));
            }
        }
    }

    fn faces(
        &self,
        mesh: &Mesh,
        (index, shape): (u32, &Shape),
        nearby: &Nearby,
        reach: f64,
        add: &mut impl FnMut(Place),
    ) {
        for (&f, slots) in nearby.faces.iter().zip(&nearby.face_slots) {
            let corners = slots.map(|i| self.local[i as usize]);
            let values = slots.map(|i| &self.firsts[i as usize]);
            let rim = |k: usize| {
                let e = mesh.face_edges[f as usize][k];
                let known = self.minima.binary_search_by_key(&e, |m| m.0).ok()?;
                let (_, _, (t, first)) = self.minima[known];
                let forward = mesh.edges[e as usize][0] == mesh.faces[f as usize][(k + 1) % 3];
                Some((if forward { t } else { 1.0 - t }, first))
            };
            if let Some((weights, lead)) = within_face(shape, &corners, values, rim, reach) {
                let at =
                    corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
                let first = shape.first_order(&at);
                add(Place::on(
                    (f, weights),
                    (index, 2, f),
                    share(lead),
                    at,
                    first,
                ));
            }
        }
    }

    fn near_surface(
        &mut self,
        (mesh, features): (&Mesh, &Features),
        (index, surface): (u32, &Surface),
        nearby: &Nearby,
        reach: f64,
        mut add: impl FnMut(Place),
    ) {
        let sheet = (mesh, surface);
        self.found.clear();
        surface::detect(
            sheet,
            &nearby.candidates,
            &self.local,
            reach,
            &mut self.found,
        );
        for near in &self.found {
            let feature = near.feature as usize;
            let on = match near.kind {
                0 => features.on_vertex(feature),
                1 => features.on_edge(mesh, feature, near.weights[1]),
                _ => (near.feature, near.weights),
            };
            let distance = surface.distance_to(near.part, &near.at);
            let first = (distance.value, distance.normal);
            let mut place = Place::on(
                on,
                (index, near.kind, near.feature),
                near.share,
                near.at,
                first,
            );
            place.key |= u64::from(near.number) << (FEATURE_BITS + OBSTACLE_BITS);
            place.part = Some(near.part);
            add(place);
        }
    }
}

impl Place {
    fn on(
        (face, weights): (u32, [f64; 3]),
        (obstacle, kind, feature): (u32, u64, u32),
        share: f64,
        at: Vector3<f64>,
        first: First,
    ) -> Self {
        Self {
            key: key(obstacle, kind, feature),
            obstacle,
            face,
            weights,
            share,
            at,
            first,
            part: None,
        }
    }
}
