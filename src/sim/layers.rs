//! The sheet against itself in a given configuration: what touches, with what forces; and what a scene that leaves it out
//! should know.

use nalgebra::Vector3;

use super::assembly::pick;
use super::measure::total;
use super::model::Model;
use super::report::StepReport;
use super::simulation::Simulation;
use super::state::{Memory, State};
use crate::contact::layers::{Candidates, Pair, crossings};
use crate::physics::layers::{LayerBond, LayerFriction, LayerLaw, Layers};
use crate::physics::{Hessian, Potential};
use crate::scene::Term;

/// Layers that touch.
#[derive(Clone, Debug, Default)]
pub struct LayerTouch {
    /// Where.
    pub pairs: Vec<Pair>,
    /// Bonds of the pairs, in their order, if layers have friction.
    pub bonds: Vec<LayerBond>,
}

impl LayerTouch {
    /// Ties the pairs to where a step started, with the memory of its bonds, sorted by key.
    pub fn bind(&mut self, law: &LayerLaw, start: &[Vector3<f64>], memory: &[Memory]) {
        self.bonds.clear();
        if law.friction == 0.0 {
            return;
        }
        let bond = |pair: &Pair| {
            let remembered = match memory.binary_search_by_key(&pair.key, |m| m.key) {
                Ok(i) => memory[i].offset,
                Err(_) => Vector3::zeros(),
            };
            LayerBond {
                nodes: pair.nodes,
                weights: pair.weights,
                normal: pair.normal,
                slack: offset(pair, start) - remembered,
                limit: law.friction * law.normal_force(pair).max(0.0),
                stiffness: law.grip() * pair.share.max(1e-3),
            }
        };
        self.bonds.extend(self.pairs.iter().map(bond));
    }

    /// Forces on vertices \[N\].
    pub fn pushes(&self, law: &LayerLaw, nodes: &[Vector3<f64>]) -> Vec<(u32, Vector3<f64>)> {
        let mut pushes = Vec::with_capacity(4 * (self.pairs.len() + self.bonds.len()));
        pushes.extend(Self::presses(law, &self.pairs));
        let friction = LayerFriction { bonds: &self.bonds };
        for s in 0..friction.count() {
            let stencil = friction.nodes(s);
            let gradient = friction.gradient(s, &pick(nodes, &stencil));
            pushes.extend(stencil.into_iter().zip(gradient.map(|g| -g)));
        }
        pushes
    }

    /// Forces of compression on vertices \[N\].
    pub fn presses(law: &LayerLaw, pairs: &[Pair]) -> impl Iterator<Item = (u32, Vector3<f64>)> {
        pairs.iter().flat_map(|pair| {
            let force = pair.normal * law.normal_force(pair);
            let loaded = pair.nodes.into_iter().zip(pair.weights);
            let loaded = loaded.filter(|(_, w)| *w != 0.0);
            loaded.map(move |(v, w)| (v, force * w))
        })
    }

    /// Second derivatives of contact and friction, pair by pair.
    pub fn tangent(
        &self,
        law: &LayerLaw,
        nodes: &[Vector3<f64>],
        projection: f64,
        mut add: impl FnMut(&[u32; 4], &Hessian<4>),
    ) {
        let layers = self.layers(law);
        for s in 0..layers.count() {
            let stencil = layers.nodes(s);
            let x = pick(nodes, &stencil);
            let hessian = match projection > 0.0 {
                true => layers.hessian_projected(s, &x),
                false => layers.hessian(s, &x),
            };
            add(&stencil, &hessian);
        }
        let friction = LayerFriction { bonds: &self.bonds };
        for s in 0..friction.count() {
            let stencil = friction.nodes(s);
            add(&stencil, &friction.hessian(s, &pick(nodes, &stencil)));
        }
    }

    /// Energy stored in compressed layers and in elastic bonds \[J\].
    pub fn energy(&self, law: &LayerLaw, nodes: &[Vector3<f64>]) -> f64 {
        let elastic = |bond: &LayerBond| {
            let (offset, _) = bond.settle(&pick(nodes, &bond.nodes));
            0.5 * bond.stiffness * offset.norm_squared()
        };
        total(&self.layers(law), nodes) + self.bonds.iter().map(elastic).sum::<f64>()
    }

    /// What the bonds remember after the step, and the energy that slip took out \[J\].
    pub fn settle(&self, nodes: &[Vector3<f64>]) -> (Vec<Memory>, f64) {
        let mut dissipated = 0.0;
        let mut memory: Vec<Memory> = vec![];
        for (bond, pair) in self.bonds.iter().zip(&self.pairs) {
            let (offset, slip) = bond.settle(&pick(nodes, &bond.nodes));
            dissipated += bond.limit * slip;
            if bond.limit > 0.0 {
                memory.push(Memory {
                    key: pair.key,
                    offset,
                });
            }
        }
        memory.sort_unstable_by_key(|m| m.key);
        (memory, dissipated)
    }

    /// Layers that touch in a state, with the bonds that it remembers.
    pub fn of(model: &Model, state: &State) -> Self {
        let mut touch = Self::default();
        if let Some(law) = &model.layers {
            let mut candidates = Candidates::default();
            candidates.collect(&model.tiles, &model.mesh, &state.positions, 0.0);
            let (tiles, mesh) = (&model.tiles, &model.mesh);
            candidates.pairs(tiles, mesh, &state.positions, &mut touch.pairs);
            touch.bind(law, &state.positions, &state.layer_bonds);
        }
        touch
    }

    fn layers<'a>(&'a self, law: &LayerLaw) -> Layers<'a> {
        Layers {
            law: *law,
            pairs: &self.pairs,
        }
    }
}

/// Where the second feature of a pair was from the first, at its weights.
fn offset(pair: &Pair, positions: &[Vector3<f64>]) -> Vector3<f64> {
    let terms = pair.nodes.iter().zip(pair.weights);
    terms.map(|(&v, w)| positions[v as usize] * w).sum()
}

/// A place where two layers touch: a vertex and a face, or two edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerPoint {
    /// Vertices of the first feature, then of the second.
    pub vertices: [u32; 4],
    /// Weights of their positions in the offset from the second to the first; they sum to zero.
    pub weights: [f64; 4],
    /// Distance of the middle surfaces \[m\].
    pub distance: f64,
    /// Force of the compression law on the first feature, its opposite on the second \[N\].
    pub force: Vector3<f64>,
}

impl Simulation {
    /// Layers that touch in the present state, if its report knows of any.
    pub(super) fn layer_touch(&self) -> LayerTouch {
        match self.report.layer_contacts {
            0 => LayerTouch::default(),
            _ => LayerTouch::of(&self.model, &self.state),
        }
    }

    /// Where layers touch in the present state. Looks at all of it anew.
    pub fn layers(&self) -> Vec<LayerPoint> {
        let Some(law) = &self.model.layers else {
            return vec![];
        };
        let touch = self.layer_touch();
        let point = |pair: &Pair| LayerPoint {
            vertices: pair.nodes,
            weights: pair.weights,
            distance: pair.distance,
            force: pair.normal * law.normal_force(pair),
        };
        touch.pairs.iter().map(point).collect()
    }
}

/// What two layers are apart, besides their thickness and over it, to count as near. The flat sheet must not: what is there
/// nearer than half a turn of the tightest fold, 1.57 thicknesses, is never looked at.
const NEAR: f64 = 0.5;

/// Looks at the whole sheet once: how near it comes to itself, whether it crosses itself, and, where a scene leaves
/// that out, whether it may. Returns the energy of layers \[J\].
pub fn inspect(model: &Model, state: &State, report: &mut StepReport) -> f64 {
    let (tiles, mesh) = (&model.tiles, &model.mesh);
    let mut candidates = Candidates::default();
    candidates.collect(tiles, mesh, &state.positions, NEAR * tiles.thickness());
    report.layers_near = !candidates.is_empty();
    report.work.layer_searches += 1;
    report.work.layer_pairs += candidates.len() as u64;
    let mut touch = LayerTouch::default();
    candidates.pairs(tiles, mesh, &state.positions, &mut touch.pairs);
    let mut near = vec![];
    candidates.near_faces((tiles, mesh), &mut near);
    let crossed = crossings(mesh, &state.positions, near.into_iter()).len() as u64;
    report.crossings = crossed;
    report.layer_contacts = touch.pairs.len() as u64;
    report.layer_gap = candidates.nearest();
    let Some(law) = &model.layers else {
        if crossed > 0 || candidates.nearest() < tiles.thickness() {
            report.neglected.push(Term::Layers.name());
        }
        return 0.0;
    };
    touch.bind(law, &state.positions, &state.layer_bonds);
    touch.energy(law, &state.positions)
}
