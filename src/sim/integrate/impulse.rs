//! What contact does to velocities in the explicit scheme, as impulses on the half-step velocities: cloth does not
//! bounce, and Coulomb friction (Moreau 1988; the projected Gauss-Seidel sweep is that of Jean, 1999,
//! doi:10.1016/S0045-7825(98)00383-1).
//!
//! A contact deeper than half way to the middle surface goes no deeper: its approach is stopped whole.
//!
//! Normal to the obstacle a contact is critically damped; compressed fabric gives back little of the work done on
//! it, and with elastic contact a sheet at rest would rattle for ever. It never pulls. Along the obstacle a contact
//! with normal force N stops the velocity of its point, or brakes it by an impulse of mu N dt. Nothing is
//! remembered: a contact that opens and closes many times in a millisecond grips whenever it bears load, where an
//! elastic bond would first have to be drawn out again each time.

use nalgebra::Vector3;

use crate::physics::contact::{ContactLaw, weighted};
use crate::sim::lanes::{Lanes, add, lanes, vector};
use crate::sim::model::Model;
use crate::sim::state::Ledger;
use crate::sim::touch::{SLOW, Touch};

/// Sweeps of friction over all contacts; one settles contacts that share no vertex.
const SWEEPS: usize = 3;

/// Energy exchanged in a substep \[J\].
#[derive(Clone, Copy, Debug, Default)]
pub struct Taken {
    /// Taken out by contact that does not bounce.
    pub contact: f64,
    /// Taken out by friction.
    pub friction: f64,
    /// Put in by obstacles that move, against both \[J\].
    pub work: f64,
}

impl Taken {
    /// Enters it in a ledger.
    pub fn book(self, ledger: &mut Ledger) {
        ledger.friction += self.friction;
        ledger.damping += self.contact;
        ledger.supports += self.work;
    }
}

/// A contact as the sweep needs it.
struct Grip {
    /// Identity of the proximity.
    key: u64,
    vertices: [u32; 3],
    weights: [f64; 3],
    normal: Vector3<f64>,
    /// Velocity of the obstacle there \[m/s\].
    ground: Vector3<f64>,
    /// Inverse of the mass that the point feels \[1/kg\].
    lightness: f64,
    /// Coefficient of friction, sliding and not sliding \[-\].
    friction: f64,
    sticking: f64,
    /// N dt \[N·s\].
    load: f64,
    /// Critical damping times dt \[kg\].
    damping: f64,
    /// Whether it is so deep that it must not go deeper.
    deep: bool,
    /// Of that damping \[N·s\].
    braked: f64,
    /// Of friction \[N·s\].
    impulse: Vector3<f64>,
    /// Place of the proximity in its list.
    at: usize,
}

/// Velocities of the touching points \[m/s\], in the order of the proximities.
pub fn motions(model: &Model, touch: &Touch, rates: &[Lanes], motions: &mut Vec<Vector3<f64>>) {
    motions.clear();
    motions.extend(touch.proximities.iter().map(|near| {
        let face = &model.mesh.faces[near.face as usize];
        weighted(&near.weights, &face.map(|v| vector(&rates[v as usize])))
    }));
}

/// Brakes `rates` in contact over a substep of `dt`; `before` has the [`motions`] of the half step before.
///
/// An impulse works on the mean of the half-step velocities before and after all impulses of the substep, those of
/// the elastic forces too. With the velocity after them, weight would do work on friction where nothing moves.
pub fn brake(
    model: &Model,
    law: &ContactLaw,
    (touch, before): (&Touch, &[Vector3<f64>]),
    inverse_mass: &[Lanes],
    nodes: &[Lanes],
    rates: &mut [Lanes],
    dt: f64,
) -> Taken {
    let mut grips = grips(model, law, touch, inverse_mass, nodes, dt);
    settle(&mut grips, inverse_mass, rates);
    let mut taken = Taken::default();
    for grip in &grips {
        let mean = (before[grip.at] - grip.ground + grip.motion(rates)) * 0.5;
        taken.contact -= grip.braked * grip.normal.dot(&mean);
        taken.friction -= grip.impulse.dot(&mean);
        taken.work += grip.ground.dot(&(grip.impulse + grip.normal * grip.braked));
    }
    taken
}

/// Normal force and friction \[N\] of each contact that has them in such a substep.
pub fn loads(
    model: &Model,
    law: &ContactLaw,
    touch: &Touch,
    inverse_mass: &[Lanes],
    nodes: &[Lanes],
    rates: &mut [Lanes],
    dt: f64,
) -> Vec<(u64, f64, Vector3<f64>)> {
    let mut grips = grips(model, law, touch, inverse_mass, nodes, dt);
    settle(&mut grips, inverse_mass, rates);
    let loads = grips.iter();
    loads
        .map(|grip| (grip.key, grip.load / dt, grip.impulse / dt))
        .collect()
}

fn settle(grips: &mut [Grip], inverse_mass: &[Lanes], rates: &mut [Lanes]) {
    for grip in &mut *grips {
        grip.soften(inverse_mass, rates);
    }
    for _ in 0..SWEEPS {
        for grip in grips.iter_mut().filter(|grip| grip.deep) {
            grip.stop(inverse_mass, rates);
        }
    }
    for grip in grips
        .iter_mut()
        .filter(|grip| grip.sticking > grip.friction)
    {
        if grip.slip(rates).norm() < SLOW {
            grip.friction = grip.sticking;
        }
    }
    for _ in 0..SWEEPS {
        for grip in grips.iter_mut().filter(|grip| grip.friction > 0.0) {
            grip.tighten(inverse_mass, rates);
        }
    }
}

fn grips(
    model: &Model,
    law: &ContactLaw,
    touch: &Touch,
    inverse_mass: &[Lanes],
    nodes: &[Lanes],
    dt: f64,
) -> Vec<Grip> {
    let mut grips = Vec::with_capacity(touch.proximities.len());
    for (n, near) in touch.proximities.iter().enumerate() {
        let obstacle = &touch.obstacles[near.obstacle as usize];
        let vertices = model.mesh.faces[near.face as usize];
        let at: Vector3<f64> = (0..3)
            .map(|k| vector(&nodes[vertices[k] as usize]) * near.weights[k])
            .sum();
        let lightness: f64 = (0..3)
            .map(|k| {
                near.weights[k] * near.weights[k] * largest(&inverse_mass[vertices[k] as usize])
            })
            .sum();
        if lightness == 0.0 {
            continue;
        }
        let stiffness = near.share * law.psi(near.distance.value - law.offset)[2];
        grips.push(Grip {
            key: near.key,
            vertices,
            weights: near.weights,
            normal: near.distance.normal,
            ground: obstacle.surface_velocity(&at, &near.distance.normal),
            lightness,
            friction: obstacle.friction,
            sticking: model.sticking(obstacle),
            load: law.normal_force(near) * dt,
            damping: 2.0 * (stiffness / lightness).sqrt() * dt,
            deep: law.offset - near.distance.value > law.limit(),
            braked: 0.0,
            impulse: Vector3::zeros(),
            at: n,
        });
    }
    grips
}

fn largest(lanes: &Lanes) -> f64 {
    lanes[0].max(lanes[1]).max(lanes[2])
}

impl Grip {
    /// Velocity of the point over the obstacle \[m/s\].
    fn motion(&self, rates: &[Lanes]) -> Vector3<f64> {
        let moving: Vector3<f64> = (0..3)
            .map(|k| vector(&rates[self.vertices[k] as usize]) * self.weights[k])
            .sum();
        moving - self.ground
    }

    /// Its tangential part \[m/s\].
    fn slip(&self, rates: &[Lanes]) -> Vector3<f64> {
        let motion = self.motion(rates);
        motion - self.normal * self.normal.dot(&motion)
    }

    fn push(&self, impulse: &Vector3<f64>, inverse_mass: &[Lanes], rates: &mut [Lanes]) {
        let push = lanes(impulse);
        for k in 0..3 {
            let v = self.vertices[k] as usize;
            let kick = std::array::from_fn(|i| push[i] * inverse_mass[v][i] * self.weights[k]);
            rates[v] = add(rates[v], kick);
        }
    }

    /// Damps the normal velocity, implicitly, without pulling; the load changes with it.
    fn soften(&mut self, inverse_mass: &[Lanes], rates: &mut [Lanes]) {
        let speed = self.normal.dot(&self.motion(rates));
        let wanted = -self.damping * speed / (1.0 + self.damping * self.lightness);
        let impulse = wanted.max(-self.load);
        self.load += impulse;
        self.braked = impulse;
        self.push(&(self.normal * impulse), inverse_mass, rates);
    }

    /// Keeps a deep contact from going deeper.
    fn stop(&mut self, inverse_mass: &[Lanes], rates: &mut [Lanes]) {
        let speed = self.normal.dot(&self.motion(rates));
        if speed >= 0.0 {
            return;
        }
        let impulse = -speed / self.lightness;
        self.load += impulse;
        self.braked += impulse;
        self.push(&(self.normal * impulse), inverse_mass, rates);
    }

    /// Changes the impulse towards no slip within the cone, and the velocities with it.
    fn tighten(&mut self, inverse_mass: &[Lanes], rates: &mut [Lanes]) {
        let slip = self.slip(rates);
        let limit = self.friction * self.load;
        let mut impulse = self.impulse - slip / self.lightness;
        let size = impulse.norm();
        if size > limit {
            impulse *= limit / size;
        }
        let change = impulse - self.impulse;
        self.impulse = impulse;
        self.push(&change, inverse_mass, rates);
    }
}
