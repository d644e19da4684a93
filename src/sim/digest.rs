//! A 64-bit digest of the state: equal states have equal digests.

use nalgebra::Vector3;
use xxhash_rust::xxh3::Xxh3;

use super::air::Air;
use super::command::AirRegion;
use super::state::State;
use crate::contact::{Obstacle, Shape};

impl State {
    /// A digest of all that the next step depends on: every number, name and shape, and how many there are.
    pub fn digest(&self) -> u64 {
        let mut digest = Digest(Xxh3::new());
        let (past, count) = (&self.history, |n: usize| n as u64);
        for list in [
            &self.positions,
            &self.velocities,
            &self.slopes,
            &self.slope_rates,
            &past.positions,
            &past.velocities,
            &past.accelerations,
        ] {
            digest.whole(count(list.len()));
            list.iter().for_each(|v| digest.vector(v));
        }
        digest.whole(count(self.obstacles.len()));
        self.obstacles.iter().for_each(|o| digest.obstacle(o));
        digest.air(&self.air);
        digest.whole(count(self.bonds.len()));
        for bond in &self.bonds {
            digest.whole(bond.key);
            digest.vector(&bond.offset);
        }
        digest.whole(count(self.layer_bonds.len()));
        for bond in &self.layer_bonds {
            digest.whole(bond.key);
            digest.vector(&bond.offset);
        }
        digest.whole(self.step);
        digest.whole(self.began);
        digest.number(past.dt);
        digest.0.digest()
    }
}

struct Digest(Xxh3);

impl Digest {
    fn whole(&mut self, value: u64) {
        self.0.update(&value.to_le_bytes());
    }

    fn number(&mut self, value: f64) {
        self.0.update(&value.to_le_bytes());
    }

    fn vector(&mut self, v: &Vector3<f64>) {
        v.iter().for_each(|c| self.number(*c));
    }

    fn air(&mut self, air: &Air) {
        self.number(air.fluid_damping);
        self.vector(&air.from);
        self.vector(&air.to);
        self.whole(air.since);
        self.number(air.delay);
        self.number(air.rise);
        // No hold and no region are told apart from every number by what stands in their place.
        self.number(air.hold.unwrap_or(f64::INFINITY));
        let everywhere = AirRegion {
            min: Vector3::repeat(f64::NEG_INFINITY),
            max: Vector3::repeat(f64::INFINITY),
        };
        let region = air.region.unwrap_or(everywhere);
        self.vector(&region.min);
        self.vector(&region.max);
    }

    fn obstacle(&mut self, obstacle: &Obstacle) {
        self.whole(obstacle.name.len() as u64);
        self.0.update(obstacle.name.as_bytes());
        let (kind, sizes) = match obstacle.shape {
            Shape::Plane => (0, [0.0; 3]),
            Shape::Box { size } => (1, size),
            Shape::Sphere { radius } => (2, [radius, 0.0, 0.0]),
            Shape::Disc { radius } => (3, [radius, 0.0, 0.0]),
            Shape::Cylinder { radius, length } => (4, [radius, length, 0.0]),
            Shape::Capsule { radius, length } => (5, [radius, length, 0.0]),
            Shape::Mesh(_) => (6, [0.0; 3]),
        };
        self.whole(kind);
        if let Shape::Mesh(surface) = &obstacle.shape {
            self.whole(surface.digest());
        }
        sizes.iter().for_each(|size| self.number(*size));
        self.vector(&obstacle.pose.translation.vector);
        // All four components: the real one is not known from the others once rounding has been at them.
        obstacle
            .pose
            .rotation
            .coords
            .iter()
            .for_each(|c| self.number(*c));
        self.vector(&obstacle.velocity.linear);
        self.vector(&obstacle.velocity.angular);
        self.number(obstacle.friction);
        self.whole(u64::from(obstacle.scripted));
        self.number(obstacle.overlap.depth);
        self.number(obstacle.overlap.speed);
    }
}
