//! Contact and friction of the sheet in a given configuration.

use nalgebra::Vector3;

use super::assembly::{Assembly, pick};
use super::measure::total;
use super::model::Model;
use super::state::{Memory, State};
use crate::contact::{Nearby, Obstacle, Proximity, detect};
use crate::physics::Potential;
use crate::physics::contact::{Contact, ContactLaw, weighted};
use crate::physics::friction::{Bond, Friction};

/// Speed of slip at the start of a step below which friction is static \[m/s\].
pub const SLOW: f64 = 1e-3;

/// Where a step starts, for friction.
pub struct Before<'a> {
    /// Positions at the start of the step \[m\].
    pub positions: &'a [Vector3<f64>],
    /// Velocities then \[m/s\].
    pub velocities: &'a [Vector3<f64>],
    /// Obstacles at the start of the step.
    pub obstacles: &'a [Obstacle],
    /// Bonds at the start of the step, sorted by key.
    pub bonds: &'a [Memory],
}

/// Contacts found in a configuration, with the obstacles at that time.
#[derive(Clone, Debug, Default)]
pub struct Touch {
    /// Obstacles where the configuration meets them.
    pub obstacles: Vec<Obstacle>,
    /// Proximities with a gap below zero.
    pub proximities: Vec<Proximity>,
    /// Bonds of the proximities with friction.
    pub bonds: Vec<Bond>,
    /// Keys of the bonds.
    pub keys: Vec<u64>,
}

impl Touch {
    /// Finds the contacts of a configuration, without bonds. `nearby` lists, for each obstacle, what may touch it;
    /// `None` looks at the whole sheet.
    pub fn find(
        &mut self,
        model: &Model,
        law: &ContactLaw,
        positions: &[Vector3<f64>],
        nearby: Option<&[Nearby]>,
    ) {
        self.proximities.clear();
        self.bonds.clear();
        self.keys.clear();
        for (i, body) in self.obstacles.iter().enumerate() {
            let whole;
            let near = match nearby {
                Some(nearby) => &nearby[i],
                None => {
                    whole = Nearby::find(&model.mesh, positions, body, law.offset, 0.0);
                    &whole
                }
            };
            let body = (i as u32, body);
            let found = &mut self.proximities;
            detect(
                &model.mesh,
                &model.features,
                positions,
                body,
                near,
                law.offset,
                found,
            );
        }
    }

    /// Ties the contacts that have friction to the start of the step.
    pub fn bind(&mut self, model: &Model, law: &ContactLaw, before: &Before) {
        self.bonds.clear();
        self.keys.clear();
        for near in &self.proximities {
            let obstacle = &self.obstacles[near.obstacle as usize];
            if model.sticking(obstacle) > 0.0 {
                let start = &before.obstacles[near.obstacle as usize];
                self.bonds
                    .push(bond(model, law, near, [start, obstacle], before));
                self.keys.push(near.key);
            }
        }
    }

    /// Contacts of the state as it stands; with `only`, those with one obstacle.
    pub fn of(model: &Model, state: &State, only: Option<usize>) -> Self {
        let mut touch = Self {
            obstacles: state.obstacles.clone(),
            ..Self::default()
        };
        let Some(law) = &model.contact else {
            return touch;
        };
        let before = Before {
            positions: &state.positions,
            velocities: &state.velocities,
            obstacles: &state.obstacles,
            bonds: &state.bonds,
        };
        let nearby = only.map(|at| {
            let mut nearby = vec![Nearby::default(); state.obstacles.len()];
            let body = &state.obstacles[at];
            nearby[at] = Nearby::find(&model.mesh, &state.positions, body, law.offset, 0.0);
            nearby
        });
        touch.find(model, law, &state.positions, nearby.as_deref());
        touch.bind(model, law, &before);
        touch
    }

    /// Energy of contact and of friction, what slip would take included \[J\].
    pub fn potential(&self, model: &Model, law: &ContactLaw, nodes: &[Vector3<f64>]) -> f64 {
        let (contact, friction) = (self.contact(model, law), Friction { bonds: &self.bonds });
        total(&contact, nodes) + total(&friction, nodes)
    }

    /// Contact and friction forces on vertices \[N\], in the order of the proximities, then of the bonds.
    pub fn pushes(
        &self,
        model: &Model,
        law: &ContactLaw,
        positions: &[Vector3<f64>],
    ) -> Vec<(u32, Vector3<f64>)> {
        let mut pushes = Vec::with_capacity(3 * (self.proximities.len() + self.bonds.len()));
        // The proximities were found in this very configuration, so their distances are current.
        for near in &self.proximities {
            let force = near.distance.normal * law.normal_force(near);
            let face = model.mesh.faces[near.face as usize];
            let loaded = face.iter().zip(near.weights).filter(|(_, w)| *w > 0.0);
            pushes.extend(loaded.map(|(&v, w)| (v, force * w)));
        }
        let friction = Friction { bonds: &self.bonds };
        for s in 0..friction.count() {
            let stencil = friction.nodes(s);
            let gradient = friction.gradient(s, &pick(positions, &stencil));
            pushes.extend(stencil.into_iter().zip(gradient.map(|g| -g)));
        }
        pushes
    }

    /// Adds contact and friction to the tangent.
    pub fn tangent(
        &self,
        model: &Model,
        law: &ContactLaw,
        nodes: &[Vector3<f64>],
        projection: f64,
        assembly: &Assembly,
        values: &mut [f64],
    ) {
        let contact = self.contact(model, law);
        for (s, near) in self.proximities.iter().enumerate() {
            let x = pick(nodes, &contact.nodes(s));
            let hessian = if projection > 0.0 {
                contact.hessian_projected(s, &x)
            } else {
                contact.hessian(s, &x)
            };
            assembly.add_face(near.face, &hessian, values);
        }
        let with_friction = self
            .proximities
            .iter()
            .filter(|near| self.has_friction(model, near));
        let friction = Friction { bonds: &self.bonds };
        for (s, near) in with_friction.enumerate() {
            let x = pick(nodes, &friction.nodes(s));
            assembly.add_face(near.face, &friction.hessian(s, &x), values);
        }
    }

    /// Energy stored in contact and in elastic bonds \[J\].
    pub fn energy(&self, model: &Model, law: &ContactLaw, nodes: &[Vector3<f64>]) -> f64 {
        let normal = total(&self.contact(model, law), nodes);
        let elastic = |bond: &Bond| {
            let (offset, _) = bond.settle(&weighted(&bond.weights, &pick(nodes, &bond.vertices)));
            0.5 * bond.stiffness * offset.norm_squared()
        };
        normal + self.bonds.iter().map(elastic).sum::<f64>()
    }

    /// What the bonds remember after the step, and the energy that slip took out \[J\].
    pub fn settle(&self, nodes: &[Vector3<f64>]) -> (Vec<Memory>, f64) {
        let mut dissipated = 0.0;
        let mut memory: Vec<Memory> = vec![];
        for (bond, &key) in self.bonds.iter().zip(&self.keys) {
            let (offset, slip) =
                bond.settle(&weighted(&bond.weights, &pick(nodes, &bond.vertices)));
            dissipated += bond.limit * slip;
            if bond.limit > 0.0 {
                memory.push(Memory { key, offset });
            }
        }
        memory.sort_unstable_by_key(|m| m.key);
        (memory, dissipated)
    }

    /// Work that moving obstacles do on the sheet while they go from `start` to where they are \[J\].
    pub fn work_of_obstacles(
        &self,
        model: &Model,
        start: &[Obstacle],
        nodes: &[Vector3<f64>],
    ) -> f64 {
        let Some(law) = &model.contact else {
            return 0.0;
        };
        let moved = |near: &Proximity, y: &Vector3<f64>| {
            let (from, to) = (
                &start[near.obstacle as usize],
                &self.obstacles[near.obstacle as usize],
            );
            y - (from.pose * to.pose.inverse_transform_point(&(*y).into())).coords
        };
        let drawn_out = |near: &Proximity| {
            let [before, now] =
                [start, &self.obstacles].map(|list| list[near.obstacle as usize].overlap.depth);
            before - now
        };
        let at = |near: &Proximity| {
            weighted(
                &near.weights,
                &pick(nodes, &model.mesh.faces[near.face as usize]),
            )
        };
        let normal: f64 = self
            .proximities
            .iter()
            .map(|near| {
                let load = law.normal_force(near);
                let force = near.distance.normal * load;
                force.dot(&moved(near, &at(near))) + load * drawn_out(near)
            })
            .sum();
        let friction = Friction { bonds: &self.bonds };
        let with_friction = self
            .proximities
            .iter()
            .filter(|near| self.has_friction(model, near));
        // The explicit scheme has no bonds: it takes the work of its impulses into account itself.
        let tangential: f64 = with_friction
            .take(friction.count())
            .enumerate()
            .map(|(s, near)| {
                let pull: Vector3<f64> = friction
                    .gradient(s, &pick(nodes, &friction.nodes(s)))
                    .iter()
                    .sum();
                -pull.dot(&moved(near, &at(near)))
            })
            .sum();
        normal + tangential
    }

    /// Deepest point of the cloth's surface inside an obstacle, as its surface acts now \[m\], not negative.
    pub fn deepest(&self, law: &ContactLaw) -> f64 {
        self.proximities
            .iter()
            .map(|near| law.offset - near.distance.value)
            .fold(0.0, f64::max)
    }

    fn contact<'a>(&'a self, model: &'a Model, law: &ContactLaw) -> Contact<'a> {
        Contact {
            law: *law,
            mesh: &model.mesh,
            obstacles: &self.obstacles,
            proximities: &self.proximities,
        }
    }

    fn has_friction(&self, model: &Model, near: &Proximity) -> bool {
        model.sticking(&self.obstacles[near.obstacle as usize]) > 0.0
    }
}

/// The bond of a proximity: its anchor is where the contact point was at the start of the step, less what the
/// bond remembers, carried along by the obstacle.
fn bond(
    model: &Model,
    law: &ContactLaw,
    near: &Proximity,
    motion: [&Obstacle; 2],
    before: &Before,
) -> Bond {
    let vertices = model.mesh.faces[near.face as usize];
    let start = weighted(&near.weights, &pick(before.positions, &vertices));
    let remembered = match before.bonds.binary_search_by_key(&near.key, |m| m.key) {
        Ok(i) => before.bonds[i].offset,
        Err(_) => Vector3::zeros(),
    };
    let [from, to] = motion;
    let local = from
        .pose
        .inverse_transform_point(&(start - remembered).into());
    let slow = || {
        let velocity = weighted(&near.weights, &pick(before.velocities, &vertices));
        let slip = velocity - from.velocity_at(&start);
        let normal = near.distance.normal;
        (slip - normal * normal.dot(&slip)).norm() < SLOW
    };
    let friction = match model.sticking(to) {
        sticking if sticking > to.friction && slow() => sticking,
        _ => to.friction,
    };
    Bond {
        vertices,
        weights: near.weights,
        normal: near.distance.normal,
        anchor: to.pose.transform_point(&local).coords,
        limit: friction * law.normal_force(near),
        stiffness: law.grip * near.share.max(1e-3),
    }
}
