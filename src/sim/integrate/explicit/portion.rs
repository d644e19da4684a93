//! A portion of the sheet with its motion in substeps: the whole of it, or what one thread moves.

use std::ops::Range;

use nalgebra::Vector3;

use super::super::{held, leap};
use crate::math::sparse::NO_SLOT;
use crate::physics::Potential;
use crate::sim::carry::{Carried, Prescribed};
use crate::sim::kernel::{Kernel, along, order};
use crate::sim::lanes::{Lanes, ZERO, dot, lanes, scale};
use crate::sim::model::Model;

/// The nodes that one thread moves, and copies of those of others that its faces reach.
///
/// Nodes stand as own vertices, copied vertices, own slopes, copied slopes, each in rising order.
#[derive(Default)]
pub struct Portion {
    pub kernel: Kernel,
    /// 1/m by component, zero where prescribed \[1/kg\], shape \[vertices\].
    pub inverse_mass: Vec<Lanes>,
    /// 1/J, zero where prescribed \[1/(kg·m²)\], shape \[own slopes\].
    pub inverse_inertia: Vec<f64>,
    /// mu A / m \[1/s\], shape \[own vertices\].
    pub drag: Vec<f64>,
    /// m g \[N\], shape \[own vertices\].
    pub weight: Vec<Lanes>,
    /// Numbers of the nodes in the whole sheet.
    pub names: Vec<u32>,
    /// Own vertices and own slopes.
    pub vertices: Range<usize>,
    pub slopes: Range<usize>,
    /// Own nodes of which others have copies.
    pub lent: Vec<u32>,
    /// Copied nodes: which, of which portion, and where among what that one lends.
    pub copies: Vec<(u32, u32, u32)>,
    /// Positions \[m\] and slopes, and their rates in the half step before: those of the slopes only where a run of
    /// substeps begins and ends.
    pub nodes: Vec<Lanes>,
    pub rates: Vec<Lanes>,
    /// On own vertices since they moved last \[N\]; the impulses of own slopes over the substep, to which moments are
    /// added \[N·m\]. What stands at copies means nothing.
    pub forces: Vec<Lanes>,
    /// Rates in the half step before the last.
    pub before_last: Vec<Lanes>,
    /// What damping took out of each own vertex over its mass and the substep \[m²/s³\]: in the run, and in the last kick.
    pub spent: Vec<f64>,
    pub spends: Vec<f64>,
}

impl Portion {
    /// The whole sheet at `nodes` (positions, then slopes), with the inertia of the slopes \[kg·m²\].
    pub fn whole(model: &Model, nodes: &[Vector3<f64>], inertia: &[f64]) -> Self {
        let vertices = model.masses.len();
        let drag = model.damping.coefficients.iter().zip(&model.masses);
        let weight = |v: usize| lanes(&-model.gravity.gradient(v, &[nodes[v]])[0]);
        Self {
            kernel: Kernel::new(model),
            inverse_mass: inverse_masses(model),
            inverse_inertia: inverse_inertia(model, inertia),
            drag: drag.map(|(c, m)| c / m).collect(),
            weight: (0..vertices).map(weight).collect(),
            names: (0..nodes.len() as u32).collect(),
            vertices: 0..vertices,
            slopes: vertices..nodes.len(),
            ..Self::default()
        }
    }

    /// Clears what a run of substeps of `dt` before has left, once nodes and rates are set.
    pub fn begin(&mut self, dt: f64) {
        self.forces.clear();
        self.forces.resize(self.nodes.len(), ZERO);
        for (n, inverse) in self.slopes.clone().zip(&self.inverse_inertia) {
            if *inverse > 0.0 {
                self.forces[n] = scale(self.rates[n], 1.0 / (inverse * dt));
            }
        }
        for spent in [&mut self.spent, &mut self.spends] {
            spent.clear();
            spent.resize(self.vertices.len(), 0.0);
        }
    }

    /// Moves the slopes on.
    pub fn swing(&mut self, dt: f64) {
        let own = self.slopes.clone();
        let (slopes, impulses) = (&mut self.nodes[own.clone()], &self.forces[own]);
        leap::swing(slopes, impulses, &self.inverse_inertia, dt);
    }

    /// Moves the vertices on, and what moving supports hold of the portion; their largest speed \[m/s\].
    pub fn drift(&mut self, supports: &[Prescribed], dt: f64) -> f64 {
        held::send(supports, &self.nodes, &mut self.rates, dt);
        let own = self.vertices.clone();
        let (nodes, rates) = (&mut self.nodes[own.clone()], &self.rates[own.clone()]);
        let fastest = leap::drift(nodes, rates, &self.weight, &mut self.forces[own], dt);
        self.place(supports);
        fastest
    }

    /// Puts what moving supports hold of the portion where it is.
    pub fn place(&mut self, supports: &[Prescribed]) {
        let vertices = self.slopes.start;
        held::place(supports, vertices, &mut self.nodes, &mut self.forces);
    }

    /// Adds the elastic forces where the nodes are.
    pub fn pull(&mut self) {
        self.kernel.add_forces(&self.nodes, &mut self.forces);
    }

    /// Says how fast slopes are by their impulses over a substep of `dt`.
    pub fn read_slope_rates(&mut self, dt: f64) {
        for (n, inverse) in self.slopes.clone().zip(&self.inverse_inertia) {
            self.rates[n] = scale(self.forces[n], inverse * dt);
        }
    }

    /// Keeps the rates as they are before the last kick.
    pub fn keep_rates(&mut self) {
        self.before_last.clone_from(&self.rates);
    }

    /// Takes the rates of the vertices to the next half step.
    pub fn kick(&mut self, dt: f64, damped: bool) {
        let own = self.vertices.clone();
        let rates = &mut self.rates[own.clone()];
        let (forces, inverse) = (&self.forces[own.clone()], &self.inverse_mass[own]);
        if !damped {
            return leap::kick(rates, forces, inverse, dt);
        }
        leap::slow(rates, forces, inverse, &self.drag, dt);
        for ((spends, rate), drag) in self.spends.iter_mut().zip(rates).zip(&self.drag) {
            *spends = drag * dot(*rate, *rate);
        }
    }

    /// Enters what damping took out in the last kick.
    pub fn spend(&mut self) {
        let both = self.spent.iter_mut().zip(&self.spends);
        both.for_each(|(spent, spends)| *spent += spends);
    }

    /// Cuts the whole sheet across into portions of about such shares of its nodes.
    pub fn cut(&self, model: &Model, shares: &[f64]) -> Vec<Self> {
        let owners = owners(model, shares);
        let order = order(model);
        let mut portions: Vec<Self> = (0..shares.len())
            .map(|p| self.portion(model, &order, &owners, p as u32))
            .collect();
        lend(&mut portions, &owners);
        portions
    }

    fn portion(&self, model: &Model, order: &[usize], owners: &[u32], p: u32) -> Self {
        let mine = |node: &u32| owners[*node as usize] == p;
        let nodes = |f: &usize| model.bend.nodes(*f);
        let faces = order.iter().copied().filter(|f| nodes(f).iter().any(mine));
        let faces: Vec<usize> = faces.collect();
        let mut reached = vec![false; owners.len()];
        for node in faces.iter().flat_map(nodes) {
            reached[node as usize] = true;
        }
        let all = owners.len() as u32;
        let vertices = model.masses.len() as u32;
        let own = |within: Range<u32>| within.filter(mine);
        let copied = |within: Range<u32>| within.filter(|n| !mine(n) && reached[*n as usize]);
        let mut names: Vec<u32> = own(0..vertices).collect();
        let own_vertices = 0..names.len();
        names.extend(copied(0..vertices));
        let first = names.len();
        names.extend(own(vertices..all));
        let own_slopes = first..names.len();
        names.extend(copied(vertices..all));
        let mut local = vec![u32::MAX; owners.len()];
        for (at, &name) in names.iter().enumerate() {
            local[name as usize] = at as u32;
        }
        let of_vertices = || names[own_vertices.clone()].iter().map(|&v| v as usize);
        Self {
            kernel: Kernel::of(model, &faces, |node| local[node as usize]),
            inverse_mass: names[..first]
                .iter()
                .map(|&v| self.inverse_mass[v as usize])
                .collect(),
            inverse_inertia: names[own_slopes.clone()]
                .iter()
                .map(|&n| self.inverse_inertia[(n - vertices) as usize])
                .collect(),
            drag: of_vertices().map(|v| self.drag[v]).collect(),
            weight: of_vertices().map(|v| self.weight[v]).collect(),
            vertices: own_vertices,
            slopes: own_slopes,
            names,
            ..Self::default()
        }
    }
}

/// 1/m by component, zero where prescribed, shape \[vertices\].
fn inverse_masses(model: &Model) -> Vec<Lanes> {
    let inverse = |(index, mass): (&[u32; 3], &f64)| {
        let [x, y, z] = index.map(|slot| if slot == NO_SLOT { 0.0 } else { 1.0 / mass });
        Lanes([x, y, z, 0.0])
    };
    model
        .dofs
        .index
        .iter()
        .zip(&model.masses)
        .map(inverse)
        .collect()
}

/// 1/J, zero where prescribed, which a slope is whole or not at all, shape \[slopes\].
fn inverse_inertia(model: &Model, inertia: &[f64]) -> Vec<f64> {
    let slopes = &model.dofs.index[model.masses.len()..];
    let inverse = |(index, inertia): (&[u32; 3], &f64)| match index[0] {
        NO_SLOT => 0.0,
        _ => 1.0 / inertia,
    };
    slopes.iter().zip(inertia).map(inverse).collect()
}

/// Whose each node is: portions follow each other along the sheet, but the first has what moving supports hold.
fn owners(model: &Model, shares: &[f64]) -> Vec<u32> {
    let along = along(model);
    let mut sorted = along.clone();
    sorted.sort_by(f64::total_cmp);
    let mut sum = 0.0;
    let cuts: Vec<f64> = shares[1..]
        .iter()
        .zip(shares)
        .map(|(_, share)| {
            sum += share;
            sorted[(sum * sorted.len() as f64) as usize]
        })
        .collect();
    let owner = |x: &f64| cuts.partition_point(|cut| cut <= x) as u32;
    let mut owners: Vec<u32> = along.iter().map(owner).collect();
    for (node, _) in model.carried.iter().flat_map(Carried::held) {
        owners[node] = 0;
    }
    owners
}

/// Says of each portion what it lends to others, and where its copies come from.
fn lend(portions: &mut [Portion], owners: &[u32]) {
    let is_own = |portion: &Portion, at: usize| {
        portion.vertices.contains(&at) || portion.slopes.contains(&at)
    };
    let mut wanted = vec![false; owners.len()];
    for portion in &*portions {
        for (at, &name) in portion.names.iter().enumerate() {
            wanted[name as usize] |= !is_own(portion, at);
        }
    }
    let mut places = vec![0; owners.len()];
    for portion in &mut *portions {
        for (at, &name) in portion.names.iter().enumerate() {
            if is_own(portion, at) && wanted[name as usize] {
                places[name as usize] = portion.lent.len() as u32;
                portion.lent.push(at as u32);
            }
        }
    }
    for portion in &mut *portions {
        let copies = portion.names.iter().enumerate();
        let copies = copies.filter(|(at, _)| !is_own(portion, *at));
        let from = |(at, &name): (usize, &u32)| {
            let name = name as usize;
            (at as u32, owners[name], places[name])
        };
        portion.copies = copies.map(from).collect();
    }
}
