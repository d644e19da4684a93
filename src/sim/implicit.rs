//! One implicit step as a nonlinear system for Newton.

use nalgebra::Vector3;

use super::air::Breeze;
use super::assembly::{Assembly, pick};
use super::carry::Prescribed;
use super::constant::Constant;
use super::integrate::{Map, Rule};
use super::model::Model;
use super::state::State;
use super::touch::{Before, Touch};
use crate::math::cholesky::Cholesky;
use crate::math::newton::{Limits, Outcome, Problem, Scratch, newton};
use crate::math::quasi_newton::quasi_newton;
use crate::physics::drag::Drag;
use crate::physics::{Load, Potential};
use crate::scene::Solver;

/// Solver of implicit steps: all that is reused from step to step and is not state.
pub struct Implicit {
    assembly: Assembly,
    algebra: Algebra,
    scratch: Scratch,
    z: Vec<f64>,
    nodes: Vec<Vector3<f64>>,
    forces: Vec<Vector3<f64>>,
    stresses: Vec<Vector3<f64>>,
}

/// What stands for the tangent.
enum Algebra {
    Newton(Cholesky),
    QuasiNewton(Constant),
}

/// A solved step, not yet taken.
pub struct Solved {
    /// The scheme's map.
    pub map: Map,
    /// Nodes at the map's fraction.
    pub nodes: Vec<Vector3<f64>>,
    /// Contacts there.
    pub touch: Touch,
    /// What Newton did.
    pub outcome: Outcome,
    /// Vertex with the largest residual force.
    pub worst: usize,
    /// Work of moving supports to the end of the step, but for the inertia of what they hold \[J\].
    pub support_work: f64,
}

impl Implicit {
    /// Analyses the model's tangent once.
    pub fn new(model: &Model, threads: usize) -> Self {
        let assembly = Assembly::new(model, threads);
        Self {
            algebra: match model.scene.method.solver {
                Solver::QuasiNewton => Algebra::QuasiNewton(Constant::new(model)),
                _ => Algebra::Newton(Cholesky::new(assembly.pattern().clone())),
            },
            assembly,
            scratch: Scratch::default(),
            z: vec![0.0; model.dofs.size],
            nodes: vec![],
            forces: vec![],
            stresses: vec![],
        }
    }

    /// Forgets the steps before: a step depends on the state alone, whatever led to it.
    pub fn forget(&mut self) {
        self.scratch.forget();
        self.stresses.clear();
        if let Algebra::QuasiNewton(constant) = &mut self.algebra {
            constant.forget();
        }
    }

    /// The Cholesky factor of the tangent.
    ///
    /// # Panics
    /// With another solver than Newton.
    fn cholesky(&mut self) -> &mut Cholesky {
        match &mut self.algebra {
            Algebra::Newton(cholesky) => cholesky,
            Algebra::QuasiNewton(_) => panic!("only newton has a tangent"),
        }
    }

    /// Factorises the exact second derivative of the energy at a state, plus `shift` times the mass \[1/s²\]; says
    /// whether the sum is positive definite.
    pub fn factorise_exact(
        &mut self,
        model: &Model,
        state: &State,
        touch: &Touch,
        shift: f64,
    ) -> bool {
        let nodes = state.nodes();
        let stress = |f: usize| {
            let x = pick(&nodes, &model.stretch.nodes(f));
            model.stretch.linearised_stress(f, &x, &x)
        };
        let stresses: Vec<_> = (0..model.stretch.count()).map(stress).collect();
        let mut values = vec![0.0; self.assembly.pattern().entries()];
        self.assembly
            .tangent(model, &nodes, &stresses, (shift, 0.0), 0.0, &mut values);
        if let Some(law) = &model.contact {
            touch.tangent(model, law, &nodes, 0.0, &self.assembly, &mut values);
        }
        self.cholesky().factorise(&values).is_ok()
    }

    /// Solves in place with the last matrix that was factorised.
    pub fn back_substitute(&mut self, rhs: &mut [f64]) {
        self.cholesky().solve(rhs, 1);
    }

    /// Solves the equations of a part of a step from `state`: it starts `within` the step and takes `dt`.
    pub fn solve(
        &mut self,
        model: &Model,
        state: &State,
        rule: Rule,
        (within, dt): (f64, f64),
        limits: &Limits,
    ) -> Solved {
        let map = rule.map(state, dt);
        let moment = match rule {
            // The length of a flow step is no time.
            Rule::GradientFlow => within,
            _ => within + map.fraction * dt,
        };
        let mut touch = Touch {
            obstacles: state.obstacles.clone(),
            ..Touch::default()
        };
        let time = model.script_time(state, moment);
        model.move_obstacles(&mut touch.obstacles, time, map.fraction * dt);
        self.nodes = predict(model, state, rule, map.fraction * dt);
        if rule != Rule::GradientFlow {
            model.place_supports(&mut self.nodes, time);
        }
        self.forces.resize(self.nodes.len(), Vector3::zeros());
        model.dofs.gather(&self.nodes, &mut self.z);
        let start = state.nodes();
        // A flow goes on with the stress of its last step.
        let stressed = matches!(self.algebra, Algebra::Newton(_));
        if stressed && (rule != Rule::GradientFlow || self.stresses.is_empty()) {
            self.stresses.clear();
            self.stresses.extend((0..model.stretch.count()).map(|f| {
                let x = pick(&start, &model.stretch.nodes(f));
                model.stretch.linearised_stress(f, &x, &x)
            }));
        }
        let mut problem = StepProblem {
            stresses: &mut self.stresses,
            iterate: self.nodes.clone(),
            model,
            before: Before {
                positions: &state.positions,
                obstacles: &state.obstacles,
                bonds: &state.bonds,
            },
            map: &map,
            assembly: &mut self.assembly,
            velocities: vec![Vector3::zeros(); model.masses.len()],
            drag: Breeze::of(model, state).map(|breeze| breeze.at(moment)),
            touch,
            nodes: &mut self.nodes,
            forces: &mut self.forces,
        };
        let (z, scratch) = (&mut self.z, &mut self.scratch);
        let mut outcome = match &mut self.algebra {
            Algebra::Newton(cholesky) => newton(&mut problem, cholesky, z, limits, scratch),
            Algebra::QuasiNewton(constant) => {
                let made = constant.prepare(model, (map.alpha_a, map.alpha_v));
                let inverse = |z: &mut [f64]| constant.solve(model, z);
                let outcome = quasi_newton(&mut problem, inverse, z, limits, scratch);
                Outcome {
                    factorisations: u64::from(made),
                    constant: u64::from(made),
                    ..outcome
                }
            }
        };
        let after_a_rejected_trial = outcome.iterations > 0 && !outcome.moved;
        if after_a_rejected_trial {
            problem.residual(&self.z, &mut vec![0.0; model.dofs.size]);
            outcome.evaluations += 1;
        }
        let worst = problem.worst();
        let end = model.script_time(state, within + dt);
        let support_work = problem.work_of_supports(&start, end);
        let touch = problem.touch;
        Solved {
            nodes: self.nodes.clone(),
            map,
            touch,
            outcome,
            worst,
            support_work,
        }
    }
}

/// First guess: the velocity kept. Adding the acceleration makes Newton's start worse: it carries the vibration
/// of the membrane, which the step does not resolve.
fn predict(model: &Model, state: &State, rule: Rule, dt: f64) -> Vec<Vector3<f64>> {
    let mut nodes = state.nodes();
    if rule == Rule::GradientFlow {
        return nodes;
    }
    for (v, velocity) in state.velocities.iter().enumerate() {
        nodes[v] += model.dofs.free(v, velocity * dt);
    }
    nodes
}

struct StepProblem<'a> {
    model: &'a Model,
    before: Before<'a>,
    map: &'a Map,
    assembly: &'a mut Assembly,
    touch: Touch,
    drag: Option<Drag<'a>>,
    velocities: Vec<Vector3<f64>>,
    nodes: &'a mut Vec<Vector3<f64>>,
    forces: &'a mut Vec<Vector3<f64>>,
    /// Stress of each face for the geometric part of the tangent.
    stresses: &'a mut Vec<Vector3<f64>>,
    /// Nodes of the iterate before.
    iterate: Vec<Vector3<f64>>,
}

impl StepProblem<'_> {
    /// Fills `forces` with M a + mu A v + dW/dx at the current nodes.
    fn evaluate(&mut self) {
        self.forces.fill(Vector3::zeros());
        self.assembly.internal(self.model, self.nodes, self.forces);
        let (map, model) = (self.map, self.model);
        for v in 0..model.masses.len() {
            let x = self.nodes[v];
            let acceleration = x * map.alpha_a + map.b_a[v];
            let velocity = x * map.alpha_v + map.b_v[v];
            self.forces[v] += acceleration * model.masses[v]
                - model.damping.force(v, &[x], &[velocity])[0]
                + model.gravity.gradient(v, &[x])[0];
            self.velocities[v] = velocity;
        }
        if let Some(drag) = &self.drag {
            let pushes = drag.forces(self.nodes, &self.velocities);
            for (force, push) in self.forces.iter_mut().zip(pushes) {
                *force -= push;
            }
        }
        if let Some(law) = &model.contact {
            let positions = &self.nodes[..model.masses.len()];
            self.touch.find(model, law, positions, None);
            self.touch.bind(model, law, &self.before);
            for (v, push) in self.touch.pushes(model, law, self.nodes) {
                self.forces[v as usize] -= push;
            }
        }
    }

    /// Work of moving supports from the nodes at the start of the step to its end, at a time since the start of the
    /// run, but for the inertia of what they hold \[J\].
    fn work_of_supports(&self, start: &[Vector3<f64>], end: f64) -> f64 {
        let carried = self.model.carried.iter();
        let work = |held: Prescribed| -> f64 {
            let n = held.node;
            let mut force = self.forces[n];
            if let Some(mass) = self.model.masses.get(n) {
                force -= (self.nodes[n] * self.map.alpha_a + self.map.b_a[n]) * *mass;
            }
            let along = (0..3).filter(|&axis| held.axes[axis]);
            along
                .map(|axis| force[axis] * (held.value[axis] - start[n][axis]))
                .sum()
        };
        carried.flat_map(|carried| carried.at(end)).map(work).sum()
    }

    /// Residual force of a node on its free components \[N\].
    fn free(&self, node: usize) -> Vector3<f64> {
        self.model.dofs.free(node, self.forces[node])
    }

    fn worst(&self) -> usize {
        (0..self.model.masses.len())
            .max_by(|&a, &b| {
                self.free(a)
                    .norm_squared()
                    .total_cmp(&self.free(b).norm_squared())
            })
            .unwrap_or(0)
    }

    /// Sum of the residual forces over the weight; the moments on slopes count over their edge's length.
    fn norm(&self) -> f64 {
        let vertices = self.model.masses.len();
        let forces: f64 = (0..vertices).map(|v| self.free(v).norm()).sum();
        let moments: f64 = (vertices..self.nodes.len())
            .map(|n| self.free(n).norm() / self.model.mesh.edge_length(n - vertices))
            .sum();
        (forces + moments) / self.model.weight
    }
}

impl Problem for StepProblem<'_> {
    fn residual(&mut self, z: &[f64], r: &mut [f64]) -> f64 {
        self.model.dofs.scatter(z, self.nodes);
        self.evaluate();
        self.model.dofs.gather(self.forces, r);
        self.norm()
    }

    fn accept(&mut self) {
        for (f, stress) in self.stresses.iter_mut().enumerate() {
            let stencil = self.model.stretch.nodes(f);
            let [from, to] = [&self.iterate, &*self.nodes].map(|nodes| pick(nodes, &stencil));
            *stress = self.model.stretch.linearised_stress(f, &from, &to);
        }
        self.iterate.copy_from_slice(self.nodes);
    }

    fn tangent(&mut self, projection: f64, values: &mut [f64]) {
        let weights = (self.map.alpha_a, self.map.alpha_v);
        self.assembly.tangent(
            self.model,
            self.nodes,
            self.stresses,
            weights,
            projection,
            values,
        );
        if let Some(drag) = &self.drag {
            // The derivative by position is not symmetric and stays out: the residual alone decides the solution.
            for s in 0..drag.count() {
                let stencil = drag.nodes(s);
                let x = pick(self.nodes, &stencil);
                let v = pick(&self.velocities, &stencil);
                let matrix = drag.by_velocity(s, &x, &v);
                let scaled = matrix.map(|row| row.map(|block| block * -self.map.alpha_v));
                self.assembly.add_face(s as u32, &scaled, values);
            }
        }
        if let Some(law) = &self.model.contact {
            self.touch.tangent(
                self.model,
                law,
                self.nodes,
                projection,
                self.assembly,
                values,
            );
        }
    }
}
