//! The paper's explicit scheme (16): central differences with lumped mass, substepping at its own stable limit.
//!
//! ```text
//! (rho/dt² + mu/2dt) x_(n+1) = f_n + 2 rho/dt² x_n - (rho/dt² - mu/2dt) x_(n-1)
//! ```
//!
//! in its half-step velocity form, which gives the same positions. The limit is 2/omega_max (Courant, Friedrichs,
//! Lewy) by power iteration on the actual mesh. Slopes get a rotary inertia J just large enough that they do not
//! lower that limit, and never above a thousandth of m h², so they follow the positions.

use nalgebra::Vector3;

use super::impulse::brake;
use crate::contact::Nearby;
use crate::math::sparse::NO_SLOT;
use crate::physics::Potential;
use crate::sim::assembly::pick;
use crate::sim::kernel::{Kernel, Lanes, add, dot, lanes, scale, vector};
use crate::sim::model::Model;
use crate::sim::state::State;
use crate::sim::touch::Touch;

/// Substep over the stable limit when the user leaves it open.
pub const SAFETY: f64 = 0.95;
/// Power iterations; the limit is then good to about 1 %.
const POWER_ITERATIONS: usize = 200;
/// Slope inertia over the least that keeps the slopes' own frequency at that of the membrane.
const INERTIA_MARGIN: f64 = 4.0;
/// Largest slope inertia, over m h²: what it adds to a wave of length w is of relative size (h/w)² of this.
const MOST_INERTIA: f64 = 1e-3;
/// How far the sheet may move against an obstacle before the features near it are collected anew \[m\].
const MARGIN: f64 = 1e-3;

/// The explicit integrator: constants and work space.
pub struct Explicit {
    kernel: Kernel,
    /// 1/m and 1/J by component, zero where prescribed, shape \[nodes\].
    inverse_mass: Vec<Lanes>,
    /// mu A / m \[1/s\], shape \[nodes\]; zero on slopes.
    drag: Vec<f64>,
    /// m g \[N\], shape \[nodes\].
    weight: Vec<Lanes>,
    /// Largest stable substep \[s\].
    limit: f64,
    nearby: Vec<Nearby>,
    /// Relative motion that `nearby` still allows \[m\].
    allowance: f64,
    touch: Touch,
}

/// What flows through the ledger in a run of substeps \[J\].
#[derive(Clone, Copy, Debug, Default)]
pub struct Flow {
    /// Taken out by damping, that of contact included.
    pub damping: f64,
    /// Taken out by friction.
    pub friction: f64,
    /// Put in by moving obstacles.
    pub obstacles: f64,
}

impl Explicit {
    /// Lays out the model and finds the stable limit at `nodes` (positions, then slopes).
    pub fn new(model: &Model, nodes: &[Vector3<f64>]) -> Self {
        let kernel = Kernel::new(model);
        let vertices = model.masses.len();
        let mut inertia = model.masses.clone();
        let stiffest = largest_frequency(model, nodes, &inertia);
        inertia.extend(slope_stiffness(model).iter().enumerate().map(|(e, k)| {
            let enough = INERTIA_MARGIN * k / stiffest.powi(2);
            enough.min(MOST_INERTIA * rotary_inertia(model, e))
        }));
        let limit = 2.0 / largest_frequency(model, nodes, &inertia);
        let inverse = |(node, inertia): (usize, &f64)| {
            let index = model.dofs.index[node];
            let lane = |axis: usize| {
                if index[axis] == NO_SLOT {
                    0.0
                } else {
                    1.0 / inertia
                }
            };
            [lane(0), lane(1), lane(2), 0.0]
        };
        let mut drag = vec![0.0; nodes.len()];
        let mut weight = vec![[0.0; 4]; nodes.len()];
        for v in 0..vertices {
            drag[v] = model.damping.coefficients[v] / model.masses[v];
            weight[v] = lanes(&-model.gravity.gradient(v, &[nodes[v]])[0]);
        }
        Self {
            kernel,
            inverse_mass: inertia.iter().enumerate().map(inverse).collect(),
            drag,
            weight,
            limit,
            nearby: vec![],
            allowance: 0.0,
            touch: Touch::default(),
        }
    }

    /// Largest stable substep \[s\].
    pub fn limit(&self) -> f64 {
        self.limit
    }

    /// Takes `count` substeps of `dt` and returns the contacts at the end and what flowed.
    pub fn advance(
        &mut self,
        model: &Model,
        state: &mut State,
        dt: f64,
        count: u64,
    ) -> (Touch, Flow) {
        let vertices = model.masses.len();
        let mut flow = Flow::default();
        let mut nodes: Vec<Lanes> = state
            .positions
            .iter()
            .chain(&state.slopes)
            .map(lanes)
            .collect();
        let mut rates: Vec<Lanes> = state
            .velocities
            .iter()
            .chain(&state.slope_rates)
            .map(lanes)
            .collect();
        let past = &state.history.accelerations;
        let accelerations = past.iter().map(lanes).chain(std::iter::repeat([0.0; 4]));
        for (rate, a) in rates.iter_mut().zip(accelerations) {
            *rate = add(*rate, scale(a, 0.5 * dt));
        }
        let mut forces = vec![[0.0; 4]; nodes.len()];
        let mut before_last = vec![];
        for substep in 0..count {
            let fastest = drift(&mut nodes, &rates, dt, vertices);
            forces.copy_from_slice(&self.weight);
            self.kernel.add_forces(&nodes, &mut forces);
            if model.contact.is_some() {
                let motion = (fastest, dt);
                self.contact(model, state, &nodes, motion, &mut forces, &mut flow);
            }
            if substep + 1 == count {
                before_last.clone_from(&rates);
            }
            flow.damping += self.kick(model, &mut rates, &forces, dt);
            if let Some(law) = &model.contact {
                let masses = &self.inverse_mass;
                let taken = brake(model, law, &self.touch, masses, &nodes, &mut rates, dt);
                flow.friction += taken.friction;
                flow.damping += taken.contact;
            }
        }
        // The half-step velocities around the end give velocity and acceleration there; the next run of substeps
        // gets back the later one.
        let around = before_last.iter().zip(&rates);
        let ends = around.map(|(a, b)| (vector(a), vector(b)));
        let (velocities, accelerations): (Vec<_>, Vec<_>) =
            ends.map(|(a, b)| ((a + b) * 0.5, (b - a) / dt)).unzip();
        state.history.accelerations = accelerations;
        state.velocities.copy_from_slice(&velocities[..vertices]);
        state.slope_rates.copy_from_slice(&velocities[vertices..]);
        for (v, x) in nodes.iter().enumerate() {
            if v < vertices {
                state.positions[v] = vector(x);
            } else {
                state.slopes[v - vertices] = vector(x);
            }
        }
        state.history.dt = dt;
        (self.touch.clone(), flow)
    }

    /// Takes the rates from one half step to the next. Returns what damping took out \[J\].
    fn kick(&self, model: &Model, rates: &mut [Lanes], forces: &[Lanes], dt: f64) -> f64 {
        let half = 0.5 * dt;
        let nodes = rates
            .iter_mut()
            .zip(forces)
            .zip(self.inverse_mass.iter().zip(&self.drag));
        for ((rate, force), (inverse, drag)) in nodes {
            let push: Lanes = std::array::from_fn(|k| force[k] * inverse[k] * dt);
            let kept = scale(*rate, 1.0 - drag * half);
            *rate = scale(add(kept, push), 1.0 / (1.0 + drag * half));
        }
        let drag = &model.damping.coefficients;
        let power = |(c, v): (&f64, &Lanes)| c * dot(*v, *v);
        if model.scene.damping == 0.0 {
            0.0
        } else {
            drag.iter().zip(&*rates).map(power).sum::<f64>() * dt
        }
    }

    /// Contact at the end of the drift.
    fn contact(
        &mut self,
        model: &Model,
        state: &mut State,
        nodes: &[Lanes],
        (fastest, dt): (f64, f64),
        forces: &mut [Lanes],
        flow: &mut Flow,
    ) {
        let Some(law) = &model.contact else { return };
        let positions: Vec<Vector3<f64>> = nodes[..model.masses.len()].iter().map(vector).collect();
        let start = state.obstacles.clone();
        state.obstacles.iter_mut().for_each(|o| o.advance(dt));
        self.allowance -= (fastest + quickest(&start)) * dt;
        if self.allowance < 0.0 {
            let find = |body| Nearby::find(&model.mesh, &positions, body, law.offset + MARGIN);
            self.nearby = state.obstacles.iter().map(find).collect();
            self.allowance = MARGIN;
        }
        self.touch.obstacles.clone_from(&state.obstacles);
        self.touch.find(model, law, &positions, Some(&self.nearby));
        for (v, push) in self.touch.pushes(model, law, &positions) {
            forces[v as usize] = add(forces[v as usize], lanes(&push));
        }
        if quickest(&start) > 0.0 {
            flow.obstacles += self.touch.work_of_obstacles(model, &start, &positions);
        }
    }
}

/// Moves the nodes and returns the largest speed of a vertex \[m/s\].
fn drift(nodes: &mut [Lanes], rates: &[Lanes], dt: f64, vertices: usize) -> f64 {
    for (x, rate) in nodes.iter_mut().zip(rates) {
        *x = add(*x, scale(*rate, dt));
    }
    let mut fastest = 0.0;
    for rate in &rates[..vertices] {
        let square = dot(*rate, *rate);
        if square > fastest {
            fastest = square;
        }
    }
    fastest.sqrt()
}

/// Bound on the speed of any point of the obstacles within a metre of their origin \[m/s\].
fn quickest(obstacles: &[crate::contact::Obstacle]) -> f64 {
    let speed = |o: &crate::contact::Obstacle| o.velocity.linear.norm() + o.velocity.angular.norm();
    obstacles.iter().map(speed).fold(0.0, f64::max)
}

/// What a slope's inertia is measured by: the mass around an edge times the square of its length \[kg·m²\].
fn rotary_inertia(model: &Model, edge: usize) -> f64 {
    let mass: f64 = model.mesh.edges[edge]
        .iter()
        .map(|&v| model.masses[v as usize])
        .sum();
    0.5 * mass * model.mesh.edge_length(edge).powi(2)
}

/// Bound on the stiffness of each slope in the bending matrix \[N·m\]: the absolute row sum.
fn slope_stiffness(model: &Model) -> Vec<f64> {
    let mut sums = vec![0.0; model.mesh.edges.len()];
    for (f, edges) in model.mesh.face_edges.iter().enumerate() {
        let matrix = model.bend.matrix(f);
        for (k, &e) in edges.iter().enumerate() {
            sums[e as usize] += (3..6).map(|j| matrix[(3 + k, j)].abs()).sum::<f64>();
        }
    }
    sums
}

/// omega_max \[rad/s\] of M^-1 K at `nodes`, for as many nodes as have an inertia, with contact at every vertex if
/// the model has any.
fn largest_frequency(model: &Model, nodes: &[Vector3<f64>], inertia: &[f64]) -> f64 {
    let vertices = model.masses.len();
    let contact = model.contact.map_or(0.0, |law| law.stiffness);
    let mut mode = vec![Vector3::zeros(); nodes.len()];
    for (n, x) in mode[..inertia.len()].iter_mut().enumerate() {
        // Any vector that no mode is orthogonal to will do; this one has all wavelengths.
        let phase = (n as f64 * 0.754_877_666) % 1.0;
        *x = free(
            model,
            n,
            Vector3::new(phase - 0.5, 0.5 - phase * phase, phase * 0.7 - 0.3),
        );
    }
    let mut omega_squared = 0.0;
    for _ in 0..POWER_ITERATIONS {
        // In coordinates scaled by the root of the inertia the matrix is symmetric.
        let norm = mode
            .iter()
            .zip(inertia)
            .map(|(x, m)| m * x.norm_squared())
            .sum::<f64>()
            .sqrt();
        mode.iter_mut().for_each(|x| *x /= norm);
        let force = stiffness_times(model, nodes, &mode);
        for (n, m) in inertia.iter().enumerate() {
            let touch = if n < vertices {
                mode[n] * contact
            } else {
                Vector3::zeros()
            };
            mode[n] = free(model, n, (force[n] + touch) / *m);
        }
        omega_squared = mode
            .iter()
            .zip(inertia)
            .map(|(x, m)| m * x.norm_squared())
            .sum::<f64>()
            .sqrt();
    }
    omega_squared.sqrt()
}

/// A vector on a node with its prescribed components removed.
fn free(model: &Model, node: usize, x: Vector3<f64>) -> Vector3<f64> {
    let index = model.dofs.index[node];
    Vector3::from_fn(|axis, _| if index[axis] == NO_SLOT { 0.0 } else { x[axis] })
}

fn stiffness_times(model: &Model, at: &[Vector3<f64>], mode: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let mut force = vec![Vector3::zeros(); mode.len()];
    for f in 0..model.mesh.faces.len() {
        let stencil = model.bend.nodes(f);
        let d = pick(mode, &stencil);
        let mut sum = model.bend.gradient(f, &d);
        let hessian = model.stretch.hessian(f, &pick(at, &model.stretch.nodes(f)));
        for i in 0..3 {
            for j in 0..3 {
                sum[i] += hessian[i][j] * d[j];
            }
        }
        for (n, s) in stencil.iter().zip(sum) {
            force[*n as usize] += s;
        }
    }
    force
}
