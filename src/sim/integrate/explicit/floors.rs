//! Vertices over flat sides of obstacles that share their mass with no other contact: each is settled by itself.

use nalgebra::Vector3;

use super::super::impulse::{Bite, Taken};
use crate::contact::{Nearby, Obstacle, Side};
use crate::physics::contact::ContactLaw;
use crate::sim::lanes::{Lanes, add, dot, lanes, scale, sub, vector};
use crate::sim::model::Model;

/// A side of an obstacle, with the vertices over it alone.
struct Floor {
    obstacle: usize,
    side: Side,
    /// The side's normal in the world.
    normal: Vector3<f64>,
}

/// A vertex that touches.
struct Rest {
    floor: u32,
    vertex: u32,
    /// To the obstacle \[m\].
    distance: f64,
    /// Its velocity in the half step before \[m/s\].
    before: Vector3<f64>,
}

/// All floors, and what rests on them now.
#[derive(Default)]
pub struct Floors {
    floors: Vec<Floor>,
    rests: Vec<Rest>,
}

impl Floors {
    /// Takes the vertices near obstacles that only one contact can touch and that are free to move in all directions, or
    /// in none. Returns the others over flat sides, by obstacle.
    pub fn sort(&mut self, nearby: &[&Nearby], inverse_mass: &[Lanes]) -> Vec<Vec<Side>> {
        self.floors.clear();
        let mut counts = vec![0; inverse_mass.len()];
        for &v in nearby.iter().flat_map(|near| near.vertices()) {
            counts[v as usize] += 1;
        }
        let is_alone = |&v: &u32| {
            let [x, y, z, _] = inverse_mass[v as usize].0;
            counts[v as usize] == 1 && x == y && y == z
        };
        let mut shared = vec![vec![]; nearby.len()];
        for (obstacle, near) in nearby.iter().enumerate() {
            for side in near.sides() {
                let (alone, others) = side.vertices.iter().partition(|v| is_alone(v));
                let with = |vertices| Side { vertices, ..*side };
                self.floors.push(Floor {
                    obstacle,
                    side: with(alone),
                    normal: side.normal,
                });
                shared[obstacle].push(with(others));
            }
        }
        shared
    }

    /// Finds what touches.
    pub fn find(
        &mut self,
        law: &ContactLaw,
        obstacles: &[Obstacle],
        (nodes, rates): (&[Lanes], &[Lanes]),
    ) {
        self.rests.clear();
        for (f, floor) in self.floors.iter_mut().enumerate() {
            let body = &obstacles[floor.obstacle];
            floor.normal = body.pose.rotation.to_rotation_matrix() * floor.side.normal;
            let (normal, origin) = (lanes(&floor.normal), lanes(&body.pose.translation.vector));
            let reach = law.offset - body.overlap.depth;
            for &vertex in &floor.side.vertices {
                let (x, rate) = (&nodes[vertex as usize], &rates[vertex as usize]);
                let value = dot(normal, sub(*x, origin)) - floor.side.level;
                if value < reach {
                    let distance = value + body.overlap.depth;
                    self.rests.push(Rest {
                        floor: f as u32,
                        vertex,
                        distance,
                        before: vector(rate),
                    });
                }
            }
        }
    }

    /// Adds the forces of contact.
    pub fn push(&self, law: &ContactLaw, forces: &mut [Lanes]) {
        for rest in &self.rests {
            let normal = lanes(&self.floors[rest.floor as usize].normal);
            let force = &mut forces[rest.vertex as usize];
            *force = add(*force, scale(normal, law.force(1.0, rest.distance)));
        }
    }

    /// Brakes `rates` of what rests over a substep of `dt`.
    pub fn brake(
        &self,
        model: &Model,
        law: &ContactLaw,
        obstacles: &[Obstacle],
        (inverse_mass, nodes): (&[Lanes], &[Lanes]),
        rates: &mut [Lanes],
        dt: f64,
    ) -> Taken {
        let mut taken = Taken::default();
        let friction = |floor: &Floor| {
            let body = &obstacles[floor.obstacle];
            [body.friction, model.sticking(body)]
        };
        let frictions: Vec<[f64; 2]> = self.floors.iter().map(friction).collect();
        for rest in &self.rests {
            let v = rest.vertex as usize;
            let lightness = inverse_mass[v][0];
            if lightness == 0.0 {
                continue;
            }
            let floor = &self.floors[rest.floor as usize];
            let body = &obstacles[floor.obstacle];
            let ground = match body.is_still() {
                true => Vector3::zeros(),
                false => body.surface_velocity(&vector(&nodes[v]), &floor.normal),
            };
            let frictions = frictions[rest.floor as usize];
            let depth = (1.0, rest.distance);
            let mut bite = Bite::new(law, depth, floor.normal, (ground, lightness), frictions, dt);
            let after = bite.settle(&(vector(&rates[v]) - ground));
            rates[v] = add(rates[v], lanes(&bite.kick()));
            taken.add(bite.taken(&(rest.before - ground), &after));
        }
        taken
    }

    /// What rests: the obstacle, the place \[m\], the direction of the force and the force \[N\].
    pub fn loads(
        &self,
        law: &ContactLaw,
        nodes: &[Lanes],
    ) -> impl Iterator<Item = (usize, Vector3<f64>, Vector3<f64>, f64)> {
        self.rests.iter().map(|rest| {
            let floor = &self.floors[rest.floor as usize];
            let place = vector(&nodes[rest.vertex as usize]);
            (
                floor.obstacle,
                place,
                floor.normal,
                law.force(1.0, rest.distance),
            )
        })
    }
}
