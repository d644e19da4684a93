//! One implicit step as a nonlinear system for Newton.

use nalgebra::Vector3;

use super::air::Breeze;
use super::assembly::{Assembly, pick};
use super::constant::Constant;
use super::integrate::{Map, Rule, extrapolate};
use super::layers::LayerTouch;
use super::model::Model;
use super::near::Near;
use super::problem::StepProblem;
use super::state::State;
use super::touch::{Before, Touch};
use crate::math::cholesky::Cholesky;
use crate::math::newton::{Limits, Outcome, Problem, Scratch, newton};
use crate::math::quasi_newton::quasi_newton;
use crate::physics::Potential;
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
    near: Near,
    /// Whether layers are watched while a step is solved, or looked at when it is.
    watching: bool,
    /// Whether the tangent has to make room for the layers of the present step.
    fresh: bool,
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
    /// Layers that touch there.
    pub layers: LayerTouch,
    /// What Newton did.
    pub outcome: Outcome,
    /// Vertex with the largest residual force.
    pub worst: usize,
    /// Work of moving supports to the end of the step, but for the inertia of what they hold \[J\].
    pub support_work: f64,
}

/// Part of the way to where layers nearly meet that a guess goes.
const HELD_BACK: f64 = 0.9;

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
            near: Near::default(),
            watching: false,
            fresh: true,
        }
    }

    /// Forgets the steps before: a step depends on the state alone, whatever led to it.
    pub fn forget(&mut self) {
        self.scratch.forget();
        self.stresses.clear();
        self.near.forget();
        self.fresh = true;
        if let Algebra::QuasiNewton(constant) = &mut self.algebra {
            constant.forget();
        }
    }

    /// Says whether layers are near where a step starts. If not, they are looked at when it is solved.
    pub fn expect_layers(&mut self, near: bool) {
        self.watching = near;
        self.fresh = true;
        self.near.looks = 0;
    }

    /// Whether layers met on the way to a solved part of a step while nothing watched them. That part is void then, and they
    /// are watched in the rest of the step.
    pub fn missed_layers(&mut self, model: &Model, start: &State, solved: &Solved) -> bool {
        if model.layers.is_none() || self.watching {
            return false;
        }
        let inside = &solved.nodes[..start.positions.len()];
        let end = extrapolate(&start.positions, inside, solved.map.fraction);
        let missed = self.near.meet(model, &start.positions, &end);
        if missed {
            (self.watching, self.fresh) = (true, true);
            self.scratch.forget();
        }
        missed
    }

    /// Searches for layers in the step so far.
    pub fn layer_searches(&self) -> u64 {
        self.near.looks
    }

    /// Makes room in the tangent for layers near each other in a state, which begins a step, and takes back what the steps
    /// before needed.
    fn make_room(&mut self, model: &Model, positions: &[Vector3<f64>]) {
        if model.layers.is_none() || !std::mem::take(&mut self.fresh) {
            return;
        }
        let changed = match self.watching {
            true => self.near.fit(model, positions, &mut self.assembly),
            false => self.assembly.couple(model, &[]),
        };
        if changed {
            self.analyse();
        }
    }

    fn analyse(&mut self) {
        let pattern = self.assembly.pattern().clone();
        *self.cholesky() = match self.assembly.couples().is_empty() {
            true => Cholesky::new(pattern),
            false => Cholesky::reordered(pattern),
        };
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
        let law = model.layers.filter(|_| self.watching);
        let layers = law.map(|_| LayerTouch::of(model, state));
        if let Some(law) = &law {
            let start = (&state.positions[..], &state.layer_bonds[..]);
            let mut touch = LayerTouch::default();
            self.near
                .find(model, law, &state.positions, start, &mut touch);
            if self.near.widen(model, &touch, &mut self.assembly) {
                self.analyse();
            }
        }
        let mut values = vec![0.0; self.assembly.pattern().entries()];
        self.assembly
            .tangent(model, &nodes, &stresses, (shift, 0.0), 0.0, &mut values);
        if let Some(law) = &model.contact {
            touch.tangent(model, law, &nodes, 0.0, &self.assembly, &mut values);
        }
        if let (Some(law), Some(layers)) = (&law, &layers) {
            let assembly = &self.assembly;
            layers.tangent(law, &nodes, 0.0, |stencil, hessian| {
                assembly.add_pair(&model.dofs, stencil, hessian, &mut values);
            });
        }
        self.cholesky().factorise(&values).is_ok()
    }

    /// Solves in place with the last matrix that was factorised.
    pub fn back_substitute(&mut self, rhs: &mut [f64]) {
        self.cholesky().solve(rhs, 1);
    }

    /// Draws the guess back towards where the step starts until no layers meet on the way; what is held keeps its place.
    /// False if that alone makes them meet.
    fn hold_back(&mut self, model: &Model, start: &[Vector3<f64>]) -> bool {
        let guess = self.nodes[..start.len()].to_vec();
        let mut share = self.near.safe(model, start, &guess);
        if share == 1.0 {
            return true;
        }
        share *= HELD_BACK;
        loop {
            for (v, (from, to)) in start.iter().zip(&guess).enumerate() {
                let back = model.dofs.free(v, (to - from) * (1.0 - share));
                self.nodes[v] = to - back;
            }
            if self.near.safe(model, start, &self.nodes[..start.len()]) == 1.0 {
                return true;
            }
            if share == 0.0 {
                return false;
            }
            share = 0.0;
        }
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
        self.make_room(model, &state.positions);
        self.nodes = predict(model, state, rule, map.fraction * dt);
        if rule != Rule::GradientFlow {
            model.place_supports(&mut self.nodes, time);
        }
        let law = model.layers.filter(|_| self.watching);
        let clear = law.is_none() || self.hold_back(model, &state.positions);
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
                velocities: &state.velocities,
                obstacles: &state.obstacles,
                bonds: &state.bonds,
            },
            timeless: rule == Rule::GradientFlow,
            law,
            layer_bonds: &state.layer_bonds,
            layers: LayerTouch::default(),
            near: &mut self.near,
            trial: vec![],
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
        let (touch, layers) = (problem.touch, problem.layers);
        outcome.converged &= clear;
        if law.is_some() && map.fraction < 1.0 {
            // The way from where the forces are taken to the end of the step.
            let end = extrapolate(&start, &self.nodes, map.fraction);
            let vertices = model.masses.len();
            let way = (&self.nodes[..vertices], &end[..vertices]);
            outcome.converged &= self.near.safe(model, way.0, way.1) == 1.0;
        }
        Solved {
            nodes: self.nodes.clone(),
            map,
            touch,
            layers,
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
