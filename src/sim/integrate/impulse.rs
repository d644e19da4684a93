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

mod bite;

use nalgebra::Vector3;

pub use bite::Bite;

use crate::contact::{Obstacle, Spot};
use crate::physics::contact::{ContactLaw, weighted};
use crate::sim::lanes::{Lanes, add, lanes, largest, vector};
use crate::sim::model::Model;
use crate::sim::state::Ledger;

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
    /// Adds what another contact exchanged.
    pub fn add(&mut self, other: Self) {
        self.contact += other.contact;
        self.friction += other.friction;
        self.work += other.work;
    }

    /// Enters it in a ledger.
    pub fn book(self, ledger: &mut Ledger) {
        ledger.friction += self.friction;
        ledger.damping += self.contact;
        ledger.supports += self.work;
    }
}

/// A contact and what it touches.
pub struct Grip {
    bite: Bite,
    /// Vertices that bear it, as many as `count`, with their weights.
    vertices: [u32; 3],
    weights: [f64; 3],
    count: usize,
    /// Place of the spot in its list.
    at: usize,
}

/// Velocities of the touching points \[m/s\], in the order of the spots.
pub fn motions(model: &Model, spots: &[Spot], rates: &[Lanes], motions: &mut Vec<Vector3<f64>>) {
    motions.clear();
    motions.extend(spots.iter().map(|spot| {
        let face = &model.mesh.faces[spot.face as usize];
        weighted(&spot.weights, &face.map(|v| vector(&rates[v as usize])))
    }));
}

/// Brakes `rates` in contact over a substep of `dt`; `before` has the [`motions`] of the half step before, `grips` is work
/// space.
///
/// An impulse works on the mean of the half-step velocities before and after all impulses of the substep, those of
/// the elastic forces too. With the velocity after them, weight would do work on friction where nothing moves.
pub fn brake(
    model: &Model,
    law: &ContactLaw,
    (obstacles, spots, before): (&[Obstacle], &[Spot], &[Vector3<f64>]),
    (inverse_mass, nodes): (&[Lanes], &[Lanes]),
    rates: &mut [Lanes],
    dt: f64,
    grips: &mut Vec<Grip>,
) -> Taken {
    let sheet = (inverse_mass, nodes);
    collect(model, law, (obstacles, spots), sheet, dt, grips);
    settle(grips, inverse_mass, rates);
    let mut taken = Taken::default();
    for grip in &*grips {
        let before = before[grip.at] - grip.bite.ground;
        taken.add(grip.bite.taken(&before, &grip.motion(rates)));
    }
    taken
}

/// Normal force and friction \[N\] of each contact that has them in such a substep.
pub fn loads(
    model: &Model,
    law: &ContactLaw,
    touching: (&[Obstacle], &[Spot]),
    (inverse_mass, nodes): (&[Lanes], &[Lanes]),
    rates: &mut [Lanes],
    dt: f64,
) -> Vec<(u64, f64, Vector3<f64>)> {
    let mut grips = vec![];
    collect(model, law, touching, (inverse_mass, nodes), dt, &mut grips);
    settle(&mut grips, inverse_mass, rates);
    let load = |grip: &Grip| {
        let bite = &grip.bite;
        (touching.1[grip.at].key, bite.load / dt, bite.impulse / dt)
    };
    grips.iter().map(load).collect()
}

fn settle(grips: &mut [Grip], inverse_mass: &[Lanes], rates: &mut [Lanes]) {
    for grip in &mut *grips {
        let impulse = grip.bite.soften(&grip.motion(rates));
        grip.push(&impulse, inverse_mass, rates);
    }
    for _ in 0..SWEEPS {
        for grip in grips.iter_mut().filter(|grip| grip.bite.deep) {
            let impulse = grip.bite.stop(&grip.motion(rates));
            grip.push(&impulse, inverse_mass, rates);
        }
    }
    for grip in &mut *grips {
        if grip.bite.may_stick() {
            grip.bite.stick(&grip.motion(rates));
        }
    }
    for _ in 0..SWEEPS {
        for grip in grips.iter_mut().filter(|grip| grip.bite.friction > 0.0) {
            let impulse = grip.bite.tighten(&grip.motion(rates));
            grip.push(&impulse, inverse_mass, rates);
        }
    }
}

fn collect(
    model: &Model,
    law: &ContactLaw,
    (obstacles, spots): (&[Obstacle], &[Spot]),
    (inverse_mass, nodes): (&[Lanes], &[Lanes]),
    dt: f64,
    grips: &mut Vec<Grip>,
) {
    grips.clear();
    for (at, spot) in spots.iter().enumerate() {
        let obstacle = &obstacles[spot.obstacle as usize];
        let face = model.mesh.faces[spot.face as usize];
        let (mut vertices, mut weights, mut count) = ([0; 3], [0.0; 3], 0);
        let (mut point, mut lightness) = (Vector3::zeros(), 0.0);
        for (v, w) in face.into_iter().zip(spot.weights) {
            if w > 0.0 {
                (vertices[count], weights[count]) = (v, w);
                count += 1;
                point += vector(&nodes[v as usize]) * w;
                lightness += w * w * largest(&inverse_mass[v as usize]);
            }
        }
        if lightness == 0.0 {
            continue;
        }
        let ground = obstacle.surface_velocity(&point, &spot.normal);
        let frictions = [obstacle.friction, model.sticking(obstacle)];
        grips.push(Grip {
            bite: Bite::new(
                law,
                (spot.share, spot.distance),
                spot.normal,
                (ground, lightness),
                frictions,
                dt,
            ),
            vertices,
            weights,
            count,
            at,
        });
    }
}

impl Grip {
    /// Velocity of the point over the obstacle \[m/s\].
    #[inline]
    fn motion(&self, rates: &[Lanes]) -> Vector3<f64> {
        let mut moving = Vector3::zeros();
        for k in 0..self.count {
            moving += vector(&rates[self.vertices[k] as usize]) * self.weights[k];
        }
        moving - self.bite.ground
    }

    #[inline]
    fn push(&self, impulse: &Vector3<f64>, inverse_mass: &[Lanes], rates: &mut [Lanes]) {
        let push = lanes(impulse);
        for k in 0..self.count {
            let v = self.vertices[k] as usize;
            let kick = Lanes(std::array::from_fn(|i| {
                push[i] * inverse_mass[v][i] * self.weights[k]
            }));
            rates[v] = add(rates[v], kick);
        }
    }
}
