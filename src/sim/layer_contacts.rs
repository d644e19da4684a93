//! Where layers touch, with what forces, as contacts: for whoever asks.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::assembly::pick;
use super::contacts::ContactPoint;
use super::layers::LayerTouch;
use super::simulation::Simulation;
use super::touch::Touch;
use crate::contact::layers::{Pair, parts_of};
use crate::physics::Potential;
use crate::physics::layers::{LayerFriction, LayerLaw};

/// What the sheet is called among obstacles, with the triangle of the other layer after it: no obstacle has a `/` in its
/// name.
pub const SHEET: &str = "sheet/";

impl Simulation {
    /// Where the sheet touches itself in the present state: all that a vertex meets on one side is a contact, and every
    /// two edges are. Forces are those on the layer that `face` is of; `obstacle` says `sheet/` and a triangle of the
    /// other. Looks at all of it anew.
    pub fn layer_contacts(&self) -> Vec<ContactPoint> {
        let model = &self.model;
        let Some(law) = &model.layers else {
            return vec![];
        };
        let touch = self.layer_touch();
        if touch.pairs.is_empty() {
            return vec![];
        }
        let normals = self.vertex_normals();
        let loads = self.layer_loads(law, &touch);
        let mut contacts: BTreeMap<u64, (ContactPoint, f64)> = BTreeMap::new();
        for (i, pair) in touch.pairs.iter().enumerate() {
            let key = self.identity(pair, &normals);
            let (load, rub) = loads[i];
            let push = pair.normal * load;
            let (contact, distance) = contacts
                .entry(key)
                .or_insert_with(|| (self.contact_of(key, pair), f64::INFINITY));
            contact.friction_force += rub;
            // The sum of the forces, until its direction is taken.
            let sum = contact.normal * contact.normal_force + push;
            contact.normal_force = sum.norm();
            contact.normal = sum.try_normalize(0.0).unwrap_or(pair.normal);
            if pair.distance < *distance {
                *distance = pair.distance;
                contact.obstacle = format!("{SHEET}{}", self.faces_of(pair)[1]);
                contact.slip_velocity = self.motion(pair);
            }
        }
        let pressed = contacts.into_values().map(|(mut contact, _)| {
            let away = contact.normal * contact.normal.dot(&contact.slip_velocity);
            contact.slip_velocity -= away;
            contact
        });
        pressed
            .filter(|contact| contact.normal_force > 0.0)
            .collect()
    }

    /// Normal force and friction on the first feature of each pair \[N\].
    fn layer_loads(&self, law: &LayerLaw, layers: &LayerTouch) -> Vec<(f64, Vector3<f64>)> {
        let (model, state) = (&self.model, &self.state);
        if let Some((explicit, dt)) = self.last_substep() {
            let touch = Touch::of(model, state, None);
            return explicit
                .loads(model, state, (&touch, &layers.pairs), dt)
                .layers;
        }
        let friction = LayerFriction {
            bonds: &layers.bonds,
        };
        let rub = |i: usize, pair: &Pair| match i < friction.count() {
            true => {
                let nodes = pick(&state.positions, &pair.nodes);
                -on_first(pair, friction.gradient(i, &nodes))
            }
            false => Vector3::zeros(),
        };
        let pairs = layers.pairs.iter().enumerate();
        pairs
            .map(|(i, pair)| (law.normal_force(pair), rub(i, pair)))
            .collect()
    }

    /// Two edges by their key; a vertex by its number and the side of the sheet on which it is touched.
    fn identity(&self, pair: &Pair, normals: &[Vector3<f64>]) -> u64 {
        if pair.of_edges() {
            return pair.key;
        }
        let vertex = pair.nodes[0];
        let above = normals[vertex as usize].dot(&pair.normal) > 0.0;
        u64::from(vertex) << 1 | u64::from(above)
    }

    fn contact_of(&self, key: u64, pair: &Pair) -> ContactPoint {
        let first = pair
            .nodes
            .iter()
            .zip(pair.weights)
            .filter(|(_, w)| *w > 0.0);
        let terms = first.map(|(&v, w)| self.state.positions[v as usize] * w);
        ContactPoint {
            obstacle: String::new(),
            key,
            face: self.faces_of(pair)[0],
            point: terms.sum(),
            normal: pair.normal,
            normal_force: 0.0,
            friction_force: Vector3::zeros(),
            slip_velocity: Vector3::zeros(),
            overlap: false,
        }
    }

    /// A face of the first feature and one of the second.
    fn faces_of(&self, pair: &Pair) -> [u32; 2] {
        parts_of(pair.key).map(|part| self.model.features.face_of(part))
    }

    /// Velocity of the first feature over the second \[m/s\].
    fn motion(&self, pair: &Pair) -> Vector3<f64> {
        let terms = pair.nodes.iter().zip(pair.weights);
        terms
            .map(|(&v, w)| self.state.velocities[v as usize] * w)
            .sum()
    }

    /// Normals of the sheet at its vertices, not of length 1.
    fn vertex_normals(&self) -> Vec<Vector3<f64>> {
        let positions = &self.state.positions;
        let mut normals = vec![Vector3::zeros(); positions.len()];
        for corners in &self.model.mesh.faces {
            let [a, b, c] = corners.map(|v| positions[v as usize]);
            let normal = (b - a).cross(&(c - a));
            corners.iter().for_each(|&v| normals[v as usize] += normal);
        }
        normals
    }
}

/// Sum of vectors at the nodes of the first feature.
fn on_first(pair: &Pair, vectors: [Vector3<f64>; 4]) -> Vector3<f64> {
    let first = vectors.iter().zip(pair.weights).filter(|(_, w)| *w > 0.0);
    first.map(|(vector, _)| *vector).sum()
}
