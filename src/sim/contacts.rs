//! Where the sheet touches, with what forces: read off a state, for whoever asks.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::assembly::pick;
use super::integrate::explicit::Explicit;
use super::simulation::{Engine, Simulation};
use super::touch::Touch;
use crate::contact::{Proximity, with_obstacle};
use crate::physics::Potential;
use crate::physics::contact::{ContactLaw, weighted};
use crate::physics::friction::Friction;

/// A point where the sheet touches an obstacle. World axes.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactPoint {
    /// Name of the obstacle.
    pub obstacle: String,
    /// Identity of the contact with this obstacle for as long as it lasts: the vertex, edge or face that touches.
    pub key: u64,
    /// A face that holds the point.
    pub face: u32,
    /// The point, on the middle surface of the cloth \[m\].
    pub point: Vector3<f64>,
    /// Out of the obstacle, of length 1.
    pub normal: Vector3<f64>,
    /// Force along the normal on the cloth, not negative \[N\].
    pub normal_force: f64,
    /// Friction on the cloth \[N\].
    pub friction_force: Vector3<f64>,
    /// Tangential velocity of the cloth over the obstacle \[m/s\].
    pub slip_velocity: Vector3<f64>,
    /// Whether the obstacle was put into the cloth and is pushing it out.
    pub overlap: bool,
}

impl ContactPoint {
    /// What the obstacle does to the cloth here \[N\].
    pub fn force(&self) -> Vector3<f64> {
        self.normal * self.normal_force + self.friction_force
    }
}

impl Simulation {
    /// Where the sheet touches in the present state. Looks at all of it anew, so ask only when it is needed.
    pub fn contacts(&self) -> Vec<ContactPoint> {
        let Some(law) = &self.model.contact else {
            return vec![];
        };
        let touch = Touch::of(&self.model, &self.state, None);
        let loads = self.loads(law, &touch);
        let at = |near: &Proximity, list: &[Vector3<f64>]| {
            let face = &self.model.mesh.faces[near.face as usize];
            weighted(&near.weights, &pick(list, face))
        };
        let contact = |near: &Proximity| {
            let obstacle = &touch.obstacles[near.obstacle as usize];
            let (point, normal) = (at(near, &self.state.positions), near.distance.normal);
            let motion = at(near, &self.state.velocities) - obstacle.velocity_at(&point);
            let (normal_force, friction_force) = loads
                .get(&near.key)
                .copied()
                .unwrap_or_else(|| (law.normal_force(near), Vector3::zeros()));
            ContactPoint {
                obstacle: obstacle.name.clone(),
                key: with_obstacle(near.key, 0),
                face: near.face,
                point,
                normal,
                normal_force,
                friction_force,
                slip_velocity: motion - normal * normal.dot(&motion),
                overlap: obstacle.overlap.depth > 0.0,
            }
        };
        touch.proximities.iter().map(contact).collect()
    }

    /// The explicit scheme, if that is the method, with the length of its last substep \[s\].
    pub(super) fn last_substep(&self) -> Option<(&Explicit, f64)> {
        let Engine::Explicit(explicit, substep) = &self.engine else {
            return None;
        };
        let last = self.state.history.dt;
        Some((explicit, if last > 0.0 { last } else { *substep }))
    }

    /// Normal force and friction by key where they are not the contact law's alone \[N\].
    fn loads(&self, law: &ContactLaw, touch: &Touch) -> BTreeMap<u64, (f64, Vector3<f64>)> {
        let (model, state) = (&self.model, &self.state);
        if let Some((explicit, dt)) = self.last_substep() {
            let pairs = self.layer_touch().pairs;
            let loads = explicit.loads(model, state, (touch, &pairs), dt);
            let loads = loads.obstacles.into_iter();
            return loads.map(|(key, n, f)| (key, (n, f))).collect();
        }
        let friction = Friction {
            bonds: &touch.bonds,
        };
        let pull = |s: usize| -> Vector3<f64> {
            let nodes = pick(&state.positions, &friction.nodes(s));
            -friction.gradient(s, &nodes).iter().sum::<Vector3<f64>>()
        };
        let by_key: BTreeMap<_, _> = touch
            .keys
            .iter()
            .enumerate()
            .map(|(s, k)| (*k, s))
            .collect();
        let with_friction = touch.proximities.iter().filter_map(|near| {
            let s = by_key.get(&near.key)?;
            Some((near.key, (law.normal_force(near), pull(*s))))
        });
        with_friction.collect()
    }
}
