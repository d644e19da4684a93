//! The sheet against itself in the explicit scheme: pairs are collected anew only when enough has moved, forces come from
//! the compression law, and impulses on the half-step velocities take out bouncing and slip, as in `impulse`.
//!
//! A substep holds only if nothing can have passed through: no two features may come nearer in it than they were apart,
//! and the law must not be stiffer there than the substep bears. Otherwise the whole step is taken again with shorter
//! ones.

use nalgebra::Vector3;

use super::impulse::Taken;
use crate::contact::layers::{Candidates, Pair};
use crate::physics::layers::LayerLaw;
use crate::sim::lanes::{Lanes, ZERO, add, dot, lanes, largest, scale, sub, vector};
use crate::sim::model::Model;
use crate::sim::report::Work;

/// Sweeps of friction over all pairs.
const SWEEPS: usize = 3;
/// Substeps that a collection should last.
const LASTING: f64 = 100.0;
/// Part of the sheet's own limit that a substep takes where layers are near, and how much stiffer they may become.
const ROOM: f64 = 0.85;
const GROWTH: f64 = 2.0;
/// Share of a bound on motion below which it is worth a pass over the sheet.
const TOGETHER: f64 = 0.7;
/// Least margin of a collection over the thickness, and the most over the span that tiles can tell apart.
const LEAST_MARGIN: f64 = 0.5;
const MOST_REACH: f64 = 0.65;

/// Contact of layers over a run of substeps.
#[derive(Default)]
pub struct Folds {
    candidates: Candidates,
    collected: bool,
    /// Whether the collection was made where the run of substeps begins.
    fresh: bool,
    /// Whether the sheet moves together so much that its mean motion is worth taking off.
    together: bool,
    pairs: Vec<Pair>,
    /// How fast each pair's offset changed in the half step before \[m/s\].
    motions: Vec<Vector3<f64>>,
    positions: Vec<Vector3<f64>>,
    /// Bound on the stiffness at each vertex, doubled \[N/m\].
    stiffness: Vec<f64>,
    /// Largest stiffness over mass that the substep bears \[1/s²\].
    bearable: f64,
    tripped: bool,
    work: Work,
}

impl Folds {
    /// A substep that layers will bear, likely: no longer than `wanted` for a sheet whose own limit is given \[s\].
    pub fn substep(
        &mut self,
        model: &Model,
        law: &LayerLaw,
        (positions, velocities): (&[Vector3<f64>], &[Vector3<f64>]),
        inverse_mass: &[Lanes],
        (wanted, limit): (f64, f64),
    ) -> f64 {
        let nodes: Vec<Lanes> = positions.iter().map(lanes).collect();
        let rates: Vec<Lanes> = velocities.iter().map(lanes).collect();
        self.collected = false;
        self.work = Work::default();
        self.stiffness.resize(model.masses.len(), 0.0);
        self.find(model, &nodes, approach(&rates, nodes.len(), wanted));
        self.fresh = true;
        if self.candidates.is_empty() {
            return wanted;
        }
        let rate = self.stiffest(law, inverse_mass);
        // Layers that do not touch change nothing, not a bit.
        if rate == 0.0 {
            return wanted;
        }
        let own = (2.0 / limit).powi(2);
        wanted.min(2.0 / (own / ROOM.powi(2) + GROWTH * rate).sqrt())
    }

    /// Bound on stiffness over mass by the pairs found last \[1/s²\].
    fn stiffest(&mut self, law: &LayerLaw, inverse_mass: &[Lanes]) -> f64 {
        for pair in &self.pairs {
            // Gershgorin's bound: the weights of a pair add up to two.
            let stiffness = 2.0 * pair.share.abs() * law.psi(pair.distance)[2];
            for (&v, w) in pair.nodes.iter().zip(pair.weights) {
                self.stiffness[v as usize] += stiffness * w.abs();
            }
        }
        let mut most = 0.0f64;
        for v in self.pairs.iter().flat_map(|pair| pair.nodes) {
            let stiffness = std::mem::take(&mut self.stiffness[v as usize]);
            most = most.max(stiffness * largest(&inverse_mass[v as usize]));
        }
        most
    }

    /// Starts a run of substeps of `dt` from `nodes`, with the limit of the substep without layers \[s\].
    pub fn begin(
        &mut self,
        model: &Model,
        (nodes, rates): (&[Lanes], &[Lanes]),
        dt: f64,
        limit: f64,
    ) {
        self.bearable = (2.0 / dt).powi(2) - (2.0 / limit).powi(2);
        self.tripped = false;
        self.collected = std::mem::take(&mut self.fresh);
        self.stiffness.resize(model.masses.len(), 0.0);
        let vertices = model.masses.len();
        let approach = approach(rates, vertices, dt);
        self.together = approach < TOGETHER * bound(fastest(&rates[..vertices]), dt);
        if !self.collected {
            self.work = Work::default();
            self.find(model, nodes, approach);
        }
    }

    /// Whether a substep was too long; what it led to must not be kept.
    pub fn tripped(&self) -> bool {
        self.tripped
    }

    /// What was looked at in the run.
    pub fn work(&self) -> Work {
        self.work
    }

    /// Adds the forces of layers after a drift of `dt` by `rates`.
    pub fn push(
        &mut self,
        model: &Model,
        law: &LayerLaw,
        (nodes, rates): (&[Lanes], &[Lanes]),
        (dt, fastest): (f64, f64),
        inverse_mass: &[Lanes],
        forces: &mut [Lanes],
    ) {
        let mut approach = bound(fastest, dt);
        if self.together || approach >= self.candidates.nearest() {
            approach = self::approach(rates, model.masses.len(), dt);
        }
        // Not finite: it is lost, and nothing can be found.
        self.tripped |= approach.is_nan() || approach >= self.candidates.nearest();
        if self.tripped {
            return;
        }
        self.find(model, nodes, approach);
        self.motions.clear();
        self.motions
            .extend(self.pairs.iter().map(|pair| motion(pair, rates)));
        for pair in &self.pairs {
            let psi = law.psi(pair.distance);
            let force = pair.normal * (-pair.share * psi[1]);
            for (&v, w) in pair.nodes.iter().zip(pair.weights) {
                let v = v as usize;
                forces[v] = add(forces[v], scale(lanes(&force), w));
            }
        }
        self.tripped |= self.stiffest(law, inverse_mass) > self.bearable;
    }

    fn find(&mut self, model: &Model, nodes: &[Lanes], approach: f64) {
        let (tiles, mesh) = (&model.tiles, &model.mesh);
        let holds = self.candidates.move_by(approach) && self.collected;
        self.pairs.clear();
        if holds && self.candidates.is_empty() {
            return;
        }
        self.positions.clear();
        self.positions
            .extend(nodes[..model.masses.len()].iter().map(vector));
        if !holds {
            let thickness = tiles.thickness();
            let most = MOST_REACH * tiles.span() - thickness;
            let margin = (LASTING * approach).clamp(LEAST_MARGIN * thickness, most);
            self.collect(model, margin);
        }
        let positions = &self.positions;
        self.candidates
            .pairs(tiles, mesh, positions, &mut self.pairs);
    }

    fn collect(&mut self, model: &Model, margin: f64) {
        let (tiles, mesh, positions) = (&model.tiles, &model.mesh, &self.positions);
        let found = match self.collected {
            true => self.candidates.renew(tiles, mesh, positions, margin),
            false => {
                self.candidates.collect(tiles, mesh, positions, margin);
                Some(self.candidates.len())
            }
        };
        self.collected = true;
        self.work.layer_searches += u64::from(found.is_some());
        self.work.layer_pairs += found.unwrap_or_default() as u64;
    }

    /// Takes bouncing and slip out of `rates` over a substep of `dt`.
    pub fn rub(
        &self,
        law: &LayerLaw,
        inverse_mass: &[Lanes],
        rates: &mut [Lanes],
        dt: f64,
    ) -> Taken {
        let mut grips = grips(law, &self.pairs, (inverse_mass, dt));
        settle(&mut grips, law.friction, inverse_mass, rates);
        // An impulse works on the mean of the half-step velocities before and after all impulses of the substep.
        let mut taken = Taken::default();
        for grip in &grips {
            let mean = (self.motions[grip.at] + motion(grip.pair, rates)) * 0.5;
            taken.contact -= grip.braked * grip.pair.normal.dot(&mean);
            taken.friction -= grip.impulse.dot(&mean);
        }
        taken
    }
}

/// Normal force and friction on the first feature \[N\] of each pair in such a substep.
pub fn loads(
    law: &LayerLaw,
    pairs: &[Pair],
    inverse_mass: &[Lanes],
    rates: &mut [Lanes],
    dt: f64,
) -> Vec<(f64, Vector3<f64>)> {
    let mut grips = grips(law, pairs, (inverse_mass, dt));
    settle(&mut grips, law.friction, inverse_mass, rates);
    let pressed = |pair: &Pair| (law.normal_force(pair), Vector3::zeros());
    let mut loads: Vec<_> = pairs.iter().map(pressed).collect();
    for grip in &grips {
        loads[grip.at] = (grip.load / dt, grip.impulse / dt);
    }
    loads
}

fn grips<'a>(law: &LayerLaw, pairs: &'a [Pair], substep: (&[Lanes], f64)) -> Vec<Grip<'a>> {
    let pairs = pairs.iter().enumerate();
    pairs
        .filter_map(|(at, pair)| Grip::new(law, (at, pair), substep))
        .collect()
}

fn settle(grips: &mut [Grip], friction: f64, inverse_mass: &[Lanes], rates: &mut [Lanes]) {
    for grip in &mut *grips {
        grip.soften(inverse_mass, rates);
    }
    if friction > 0.0 {
        for _ in 0..SWEEPS {
            for grip in &mut *grips {
                grip.tighten(friction, inverse_mass, rates);
            }
        }
    }
}

/// Largest of some speeds \[m/s\].
fn fastest(rates: &[Lanes]) -> f64 {
    let squares = rates.iter().map(|rate| dot(*rate, *rate));
    squares.fold(0.0, f64::max).sqrt()
}

/// Bound on how much nearer two vertices come in a substep at such speeds \[m\].
fn bound(fastest: f64, dt: f64) -> f64 {
    2.0 * fastest * dt
}

/// The same, with what all have in common taken off.
fn approach(rates: &[Lanes], vertices: usize, dt: f64) -> f64 {
    let rates = &rates[..vertices];
    let sum = rates.iter().fold(ZERO, |sum, rate| add(sum, *rate));
    let mean = scale(sum, 1.0 / vertices as f64);
    let mut fastest = 0.0;
    for rate in rates {
        let off = sub(*rate, mean);
        let square = dot(off, off);
        fastest = if square > fastest { square } else { fastest };
    }
    bound(fastest.sqrt(), dt)
}

/// A pair as the sweep needs it.
struct Grip<'a> {
    pair: &'a Pair,
    /// Inverse of the mass that the pair feels \[1/kg\].
    lightness: f64,
    /// N dt \[N·s\].
    load: f64,
    /// Critical damping times dt \[kg\].
    damping: f64,
    /// Of that damping \[N·s\].
    braked: f64,
    /// Of friction \[N·s\].
    impulse: Vector3<f64>,
    /// Place of the pair in its list.
    at: usize,
}

/// How fast a pair's offset changes \[m/s\].
fn motion(pair: &Pair, rates: &[Lanes]) -> Vector3<f64> {
    let ends = pair.nodes.iter().zip(pair.weights);
    ends.map(|(&v, w)| vector(&rates[v as usize]) * w).sum()
}

impl<'a> Grip<'a> {
    fn new(
        law: &LayerLaw,
        (at, pair): (usize, &'a Pair),
        (inverse_mass, dt): (&[Lanes], f64),
    ) -> Option<Self> {
        let ends = pair.nodes.iter().zip(pair.weights);
        let lightness: f64 = ends
            .map(|(&v, w)| w * w * largest(&inverse_mass[v as usize]))
            .sum();
        let psi = law.psi(pair.distance);
        (lightness > 0.0 && pair.share > 0.0).then(|| Self {
            pair,
            lightness,
            load: -pair.share * psi[1] * dt,
            damping: 2.0 * (pair.share * psi[2] / lightness).sqrt() * dt,
            braked: 0.0,
            impulse: Vector3::zeros(),
            at,
        })
    }

    fn slip(&self, rates: &[Lanes]) -> Vector3<f64> {
        let (motion, normal) = (motion(self.pair, rates), self.pair.normal);
        motion - normal * normal.dot(&motion)
    }

    fn push(&self, impulse: &Vector3<f64>, inverse_mass: &[Lanes], rates: &mut [Lanes]) {
        let push = lanes(impulse);
        for (&v, w) in self.pair.nodes.iter().zip(self.pair.weights) {
            let v = v as usize;
            let kick = Lanes(std::array::from_fn(|i| push[i] * inverse_mass[v][i] * w));
            rates[v] = add(rates[v], kick);
        }
    }

    /// Damps the normal velocity without pulling; the load changes with it.
    fn soften(&mut self, inverse_mass: &[Lanes], rates: &mut [Lanes]) {
        let speed = self.pair.normal.dot(&motion(self.pair, rates));
        let wanted = -self.damping * speed / (1.0 + self.damping * self.lightness);
        let impulse = wanted.max(-self.load);
        self.load += impulse;
        self.braked = impulse;
        self.push(&(self.pair.normal * impulse), inverse_mass, rates);
    }

    /// Changes the impulse towards no slip within the cone.
    fn tighten(&mut self, friction: f64, inverse_mass: &[Lanes], rates: &mut [Lanes]) {
        let slip = self.slip(rates);
        let limit = friction * self.load;
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
