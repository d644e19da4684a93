//! A model with its state, and the step (DESIGN section 6).

use nalgebra::Vector3;

use super::implicit::{Implicit, Solved};
use super::integrate::Rule;
use super::integrate::explicit::{Explicit, SAFETY};
use super::kernel::{Kernel, Lanes, add, lanes, vector};
use super::measure;
use super::model::Model;
use super::report::StepReport;
use super::slopes::SlopeSolver;
use super::state::{History, State};
use super::touch::{Before, Touch};
use crate::math::newton::Limits;
use crate::math::sparse::NO_SLOT;
use crate::physics::Potential;
use crate::scene::{FabricError, Scene};

/// Why a simulation could not be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refused {
    /// The explicit scheme was asked for more than its stable step.
    #[error(
        "method.substep = {asked:.3e} s is over the stable limit of central-difference on this mesh, \
         {limit:.3e} s; leave it out to substep at the limit"
    )]
    Unstable {
        /// Substep asked for \[s\].
        asked: f64,
        /// Stable limit \[s\].
        limit: f64,
    },
    /// The fabric cannot be one.
    #[error(transparent)]
    Fabric(#[from] FabricError),
}

/// A step that could not be taken.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "step {step} from {time:.4} s failed even at {dt:.1e} s: residual {residual:.1e} of the weight, largest at \
     vertex {vertex} near ({:.4}, {:.4}, {:.4}) m; {advice}", at[0], at[1], at[2]
)]
pub struct Diverged {
    /// The step that failed.
    pub step: u64,
    /// Its start \[s\].
    pub time: f64,
    /// The smallest step tried \[s\].
    pub dt: f64,
    /// Residual over the weight \[-\].
    pub residual: f64,
    /// Vertex with the largest residual force.
    pub vertex: usize,
    /// Where that vertex was at the start of the step \[m\].
    pub at: [f64; 3],
    /// What to try.
    pub advice: String,
}

/// Flow steps after which `settle` gives up.
const MOST_FLOW_STEPS: u64 = 400;
/// Flow step below which `settle` gives up \[s\].
const LEAST_FLOW_STEP: f64 = 1e-6;
/// Flow step at which inertia no longer counts \[s\].
const STIFFEST_FLOW_STEP: f64 = 100.0;
/// Distance from the origin beyond which a vertex counts as lost \[m\].
const FAR: f64 = 1e6;
/// Smallest part of a step that is tried: 1/64.
const TICKS: u32 = 64;

enum Engine {
    Implicit(Rule, Box<Implicit>),
    Explicit(Box<Explicit>, f64),
}

/// A model with its state.
pub struct Simulation {
    pub(super) model: Model,
    pub(super) state: State,
    pub(super) report: StepReport,
    engine: Engine,
}

impl Simulation {
    /// Builds model and start state from a checked scene; results do not depend on `threads`.
    pub fn new(scene: &Scene, threads: usize) -> Result<Self, Refused> {
        let fabric = scene.fabric.resolve()?;
        let model = Model::new(scene, fabric);
        let (state, touch) = start(&model);
        let engine = match Rule::of(&scene.method) {
            Some(rule) => Engine::Implicit(rule, Box::new(Implicit::new(&model, threads))),
            None => {
                let explicit = Box::new(Explicit::new(&model, &state.nodes()));
                let substep = substep(&model, explicit.limit())?;
                Engine::Explicit(explicit, substep)
            }
        };
        let mut report = StepReport {
            converged: true,
            ..StepReport::default()
        };
        measure::measure(&model, &state, &touch, &mut report);
        Ok(Self {
            model,
            state,
            report,
            engine,
        })
    }

    /// The constant part.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The state.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Report of the last step (of the start, before the first).
    pub fn report(&self) -> &StepReport {
        &self.report
    }

    /// Substep of the explicit scheme \[s\], if that is the method.
    pub fn substep(&self) -> Option<f64> {
        match self.engine {
            Engine::Explicit(_, substep) => Some(substep),
            Engine::Implicit(..) => None,
        }
    }

    /// Takes one step, or leaves the state as it was and says why.
    pub fn step(&mut self) -> Result<&StepReport, Diverged> {
        let mut next = self.state.clone();
        let mut report = StepReport {
            energies: self.report.energies,
            dt: self.model.scene.method.dt,
            converged: true,
            ..StepReport::default()
        };
        let touch = match &mut self.engine {
            Engine::Implicit(rule, solver) => {
                implicit_step(&self.model, *rule, solver, &mut next, &mut report)?
            }
            Engine::Explicit(explicit, substep) => {
                explicit_step(&self.model, explicit, *substep, &mut next, &mut report)?
            }
        };
        next.step += 1;
        measure::measure(&self.model, &next, &touch, &mut report);
        self.state = next;
        self.report = report;
        Ok(&self.report)
    }
}

impl Simulation {
    /// Finds an equilibrium from the present state by implicit gradient flow with a growing step, to a residual
    /// of `tolerance` of the weight. The state comes to rest there; friction keeps its bonds. Returns the number
    /// of flow steps.
    pub fn settle(&mut self, tolerance: f64) -> Result<u64, Diverged> {
        let Engine::Implicit(_, solver) = &mut self.engine else {
            panic!("settle() needs an implicit scheme");
        };
        let rule = Rule::GradientFlow;
        let (model, mut tau) = (&self.model, self.model.scene.method.dt);
        let limits = Limits {
            tolerance,
            iterations: model.scene.method.max_iterations,
        };
        let mut report = self.report.clone();
        for count in 1..=MOST_FLOW_STEPS {
            let solved = solver.solve(model, &self.state, rule, tau, &limits);
            if !solved.outcome.converged {
                tau *= 0.25;
                if tau < LEAST_FLOW_STEP {
                    return Err(diverged(model, &self.state, &solved, tau));
                }
                continue;
            }
            take(&mut self.state, rule, &solved, tau);
            tau *= 2.0;
            // When one Newton solve of the bare equations changes nothing more, this is the equilibrium.
            if tau > STIFFEST_FLOW_STEP && solved.outcome.iterations <= 1 {
                self.state.history.dt = 0.0;
                measure::measure(model, &self.state, &solved.touch, &mut report);
                self.report = report;
                return Ok(count);
            }
        }
        let solved = solver.solve(model, &self.state, rule, tau, &limits);
        Err(diverged(model, &self.state, &solved, tau))
    }
}

/// Start state at rest, slopes relaxed, with its contacts and accelerations.
fn start(model: &Model) -> (State, Touch) {
    let mut nodes = model.start();
    SlopeSolver::new(model).relax(model, &mut nodes);
    let vertices = model.masses.len();
    let mut state = State {
        step: 0,
        positions: nodes[..vertices].to_vec(),
        velocities: vec![Vector3::zeros(); vertices],
        slopes: nodes[vertices..].to_vec(),
        slope_rates: vec![Vector3::zeros(); nodes.len() - vertices],
        obstacles: model.obstacles(),
        history: History::default(),
        bonds: vec![],
    };
    let mut touch = Touch {
        obstacles: state.obstacles.clone(),
        ..Touch::default()
    };
    let mut forces = vec![[0.0; 4]; nodes.len()];
    let in_lanes: Vec<Lanes> = nodes.iter().map(lanes).collect();
    Kernel::new(model).add_forces(&in_lanes, &mut forces);
    if let Some(law) = &model.contact {
        let before = Before {
            positions: &state.positions,
            obstacles: &state.obstacles,
            bonds: &[],
        };
        touch.find(model, law, &state.positions, None);
        touch.bind(model, law, &before);
        for (v, push) in touch.pushes(model, law, &state.positions) {
            forces[v as usize] = add(forces[v as usize], lanes(&push));
        }
    }
    state.history.accelerations = (0..vertices)
        .map(|v| {
            let pull = vector(&forces[v]) - model.gravity.gradient(v, &[nodes[v]])[0];
            let held = model.dofs.index[v].map(|i| i == NO_SLOT);
            Vector3::from_fn(|axis, _| {
                if held[axis] {
                    0.0
                } else {
                    pull[axis] / model.masses[v]
                }
            })
        })
        .collect();
    (state, touch)
}

fn substep(model: &Model, limit: f64) -> Result<f64, Refused> {
    match model.scene.method.substep {
        Some(asked) if asked > limit => Err(Refused::Unstable { asked, limit }),
        Some(asked) => Ok(asked),
        None => Ok(SAFETY * limit),
    }
}

/// One outer step in as many parts as it needs: a part that fails is halved, one that succeeds may double.
fn implicit_step(
    model: &Model,
    rule: Rule,
    solver: &mut Implicit,
    state: &mut State,
    report: &mut StepReport,
) -> Result<Touch, Diverged> {
    let method = &model.scene.method;
    let limits = Limits {
        tolerance: method.tolerance,
        iterations: method.max_iterations,
    };
    let (mut done, mut size) = (0, TICKS);
    let mut touch = Touch::default();
    while done < TICKS {
        let dt = method.dt * f64::from(size) / f64::from(TICKS);
        let solved = solver.solve(model, state, rule, dt, &limits);
        count(&solved, report);
        if !solved.outcome.converged {
            if size == 1 {
                return Err(diverged(model, state, &solved, dt));
            }
            report.work.rejected += 1;
            size /= 2;
            continue;
        }
        measure::account(model, state, &solved, rule, dt, report);
        take(state, rule, &solved, dt);
        touch = solved.touch;
        done += size;
        if size < TICKS && done % (2 * size) == 0 {
            size *= 2;
        }
    }
    Ok(touch)
}

fn count(solved: &Solved, report: &mut StepReport) {
    let outcome = &solved.outcome;
    report.work.substeps += u64::from(outcome.converged);
    report.work.iterations += outcome.iterations;
    report.work.factorisations += outcome.factorisations;
    report.work.solves += outcome.iterations;
    report.work.halvings += outcome.halvings;
    if outcome.converged {
        report.residual = report.residual.max(outcome.norm);
    }
}

fn take(state: &mut State, rule: Rule, solved: &Solved, dt: f64) {
    let (bonds, _) = solved.touch.settle(&solved.nodes);
    rule.advance(state, &solved.map, &solved.nodes, dt);
    state.bonds = bonds;
    state.obstacles.iter_mut().for_each(|o| o.advance(dt));
}

fn diverged(model: &Model, state: &State, solved: &Solved, dt: f64) -> Diverged {
    let method = &model.scene.method;
    Diverged {
        step: state.step + 1,
        time: state.step as f64 * method.dt,
        dt,
        residual: solved.outcome.norm,
        vertex: solved.worst,
        at: state.positions[solved.worst].into(),
        advice: format!(
            "try a smaller method.dt (now {:.1e} s), a finer mesh there, or more method.max_iterations (now {})",
            method.dt, method.max_iterations
        ),
    }
}

fn explicit_step(
    model: &Model,
    explicit: &mut Explicit,
    substep: f64,
    state: &mut State,
    report: &mut StepReport,
) -> Result<Touch, Diverged> {
    let parts = (report.dt / substep).ceil().max(1.0) as u64;
    let dt = report.dt / parts as f64;
    let before = state.step;
    let (touch, flow) = explicit.advance(model, state, dt, parts);
    let energies = &mut report.energies;
    energies.damping += flow.damping;
    energies.friction += flow.friction;
    energies.supports += flow.obstacles;
    report.work.substeps = parts;
    let lost = state
        .positions
        .iter()
        .position(|x| !x.iter().all(|c| c.is_finite() && c.abs() < FAR));
    match lost {
        None => Ok(touch),
        Some(vertex) => Err(Diverged {
            step: before + 1,
            time: before as f64 * report.dt,
            dt,
            residual: f64::INFINITY,
            vertex,
            at: model.start()[vertex].into(),
            advice: format!(
                "leave method.substep out, or try one below {:.1e} s",
                0.5 * dt
            ),
        }),
    }
}
