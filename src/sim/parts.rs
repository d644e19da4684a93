//! The parts of a step, each as one unit of work to be timed by whoever has a clock.
//!
//! The core has none. What a part cost in a run is the time of one unit, measured at a state of that run, times the
//! number of units, which is counted ([`Work`]).

use std::hint::black_box;

use nalgebra::Vector3;

use super::air::Breeze;
use super::assembly::{Assembly, pick};
use super::constant::Constant;
use super::kernel::Kernel;
use super::lanes::{ZERO, lanes};
use super::layers::inspect;
use super::model::Model;
use super::report::{StepReport, Work};
use super::simulation::{Engine, Simulation};
use super::touch::{Before, Touch};
use crate::math::cholesky::Cholesky;
use crate::physics::contact::ContactLaw;
use crate::physics::{Load, Potential};
use crate::scene::{Solver, Term};

use super::integrate::explicit::meet_once;
use super::integrate::xpbd::{SUBSTEPS, Xpbd};

/// One part of a step.
pub struct Part<'a> {
    /// What it is, after the name of its term if it has one.
    pub name: &'static str,
    /// Its term.
    pub term: Option<Term>,
    /// How often the run did it.
    pub count: u64,
    /// Does it once more, to no effect.
    pub once: Box<dyn FnMut() + 'a>,
}

fn part<'a>(
    term: impl Into<Option<Term>>,
    name: &'static str,
    count: u64,
    once: impl FnMut() + 'a,
) -> Part<'a> {
    Part {
        name,
        term: term.into(),
        count,
        once: Box::new(once),
    }
}

impl Simulation {
    /// The parts of its steps at the present state, for a run that took this work. What is not among them (advancing,
    /// the ledger, copies) is the rest.
    pub fn parts(&self, work: &Work) -> Vec<Part<'_>> {
        let mut parts = match self.engine {
            Engine::Implicit(..) if self.model.scene.method.solver == Solver::QuasiNewton => {
                self.constant_parts(work)
            }
            Engine::Implicit(..) => self.implicit_parts(work),
            Engine::Explicit(..) => vec![self.kernel_part(work)],
            Engine::Positions(..) => vec![self.sweep_part(work)],
        };
        if !matches!(self.engine, Engine::Positions(..)) {
            parts.extend(self.drag_part(work));
            parts.extend(self.contact_part(work));
        }
        parts.push(self.search_part(work));
        parts.retain(|part| part.count > 0);
        parts
    }

    fn kernel_part(&self, work: &Work) -> Part<'_> {
        let kernel = Kernel::new(&self.model);
        let nodes: Vec<_> = self.state.nodes().iter().map(lanes).collect();
        let mut forces = vec![ZERO; nodes.len()];
        part(
            Term::Stretch,
            "and bend, forces in one pass",
            work.evaluations,
            move || kernel.add_forces(black_box(&nodes), &mut forces),
        )
    }

    fn constant_parts(&self, work: &Work) -> Vec<Part<'_>> {
        let model = &self.model;
        let weights = (1.0 / model.scene.method.dt.powi(2), 0.0);
        let (nodes, mut rhs) = (self.state.nodes(), vec![1.0; model.dofs.size]);
        let mut made = Constant::new(model);
        let mut solver = Constant::new(model);
        solver.prepare(model, weights);
        let bent = nodes.clone();
        vec![
            part(Term::Stretch, "forces", work.evaluations, move || {
                gradients(&model.stretch, &nodes);
            }),
            part(Term::Bend, "forces", work.evaluations, move || {
                gradients(&model.bend, &bent);
            }),
            part(None, "constant factorisation", work.constant, move || {
                made.forget();
                made.prepare(model, weights);
            }),
            part(None, "solve", work.solves, move || {
                solver.solve(model, &mut rhs)
            }),
        ]
    }

    /// Contact included.
    fn sweep_part(&self, work: &Work) -> Part<'_> {
        let mut xpbd = Xpbd::new(&self.model);
        let dt = self.model.scene.method.dt / SUBSTEPS;
        let mut state = self.state.clone();
        part(
            Term::Stretch,
            "and bend, a sweep",
            work.iterations,
            move || {
                xpbd.advance(&self.model, &mut state, dt, 1);
            },
        )
    }

    fn implicit_parts(&self, work: &Work) -> Vec<Part<'_>> {
        let model = &self.model;
        let nodes = self.state.nodes();
        let mut assembly = Assembly::new(model, 1);
        let weights = (1.0 / model.scene.method.dt.powi(2), 0.0);
        let stresses = vec![Vector3::zeros(); model.stretch.count()];
        let mut values = vec![0.0; assembly.pattern().entries()];
        assembly.tangent(model, &nodes, &stresses, weights, 0.0, &mut values);
        let mut cholesky = Cholesky::new(assembly.pattern().clone());
        let mut solver = Cholesky::new(assembly.pattern().clone());
        // With no stress and some mass the tangent is positive definite.
        let _ = solver.factorise(&values);
        let mut rhs = vec![1.0; model.dofs.size];
        let factorised = values.clone();
        let (stretched, bent, at) = (nodes.clone(), nodes.clone(), nodes);
        vec![
            part(Term::Stretch, "forces", work.evaluations, move || {
                gradients(&model.stretch, &stretched);
            }),
            part(Term::Bend, "forces", work.evaluations, move || {
                gradients(&model.bend, &bent);
            }),
            part(Term::Stretch, "tangent", work.factorisations, move || {
                assembly.tangent(model, &at, &stresses, weights, 0.0, &mut values);
            }),
            part(None, "factorisation", work.factorisations, move || {
                let _ = cholesky.factorise(black_box(&factorised));
            }),
            part(None, "solve", work.solves, move || {
                solver.solve(&mut rhs, 1)
            }),
        ]
    }

    /// A look at the whole sheet, as each report takes one, whether the scene has layers or not.
    fn search_part(&self, work: &Work) -> Part<'_> {
        let once = move || {
            let mut report = StepReport::default();
            black_box(inspect(&self.model, &self.state, &mut report));
        };
        part(Term::Layers, "searches", work.layer_searches, once)
    }

    fn drag_part(&self, work: &Work) -> Option<Part<'_>> {
        let drag = Breeze::of(&self.model, &self.state)?.at(0.0);
        let state = &self.state;
        let once = move || {
            black_box(drag.forces(&state.positions, &state.velocities));
            black_box(drag.count());
        };
        Some(part(Term::Drag, "forces", work.evaluations, once))
    }

    fn contact_part(&self, work: &Work) -> Option<Part<'_>> {
        let law = self.model.contact.as_ref()?;
        let once: Box<dyn FnMut()> = match self.engine {
            Engine::Explicit(_, substep) => Box::new(meet_once(&self.model, &self.state, substep)),
            Engine::Implicit(..) | Engine::Positions(..) => self.touch_once(law),
        };
        Some(Part {
            name: "and friction, forces",
            term: Some(Term::Contact),
            count: work.evaluations,
            once,
        })
    }

    fn touch_once<'a>(&'a self, law: &'a ContactLaw) -> Box<dyn FnMut() + 'a> {
        let (model, state) = (&self.model, &self.state);
        let mut touch = Touch {
            obstacles: state.obstacles.clone(),
            ..Touch::default()
        };
        Box::new(move || {
            let before = Before {
                positions: &state.positions,
                velocities: &state.velocities,
                obstacles: &state.obstacles,
                bonds: &state.bonds,
            };
            touch.find(model, law, &state.positions, None);
            touch.bind(model, law, &before);
            black_box(touch.pushes(model, law, &state.positions));
        })
    }
}

fn gradients<const N: usize>(term: &impl Potential<N>, nodes: &[Vector3<f64>]) {
    for s in 0..term.count() {
        black_box(term.gradient(s, &pick(nodes, &term.nodes(s))));
    }
}

/// Largest stable step of the explicit scheme on a model at its start, where it touches nothing: 2 over its largest angular
/// frequency \[s\].
pub fn stable_limit(model: &Model) -> f64 {
    super::integrate::explicit::Explicit::new(model, &model.start(), 1).limit()
}
