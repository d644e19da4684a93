//! A model with its state, and the step (DESIGN section 6).

use super::command::Rejected;
use super::equilibrium::{Equilibrium, equilibrium_step};
use super::implicit::Implicit;
use super::integrate::explicit::Explicit;
use super::integrate::xpbd::{self, Xpbd};
use super::integrate::{Rule, SAFETY};
use super::measure;
use super::model::Model;
use super::report::{StepReport, Work};
use super::sleep;
use super::start;
use super::state::State;
use super::step::{Diverged, explicit_step, implicit_step, position_step};
use crate::scene::{FabricError, Scene, Solver, StableLimit};

/// Why a simulation could not be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refused {
    /// The explicit scheme was asked for more than its stable step.
    #[error(
        "method.substep = {asked:.3e} s is over the stable limit of central-difference on this mesh, \
         {limit:.3e} s; leave it out to substep at the limit, or see it diverge with method.limit = \"ignore\""
    )]
    Unstable {
        /// Substep asked for \[s\].
        asked: f64,
        /// Stable limit \[s\].
        limit: f64,
    },
    /// An obstacle stands in the cloth.
    #[error("at the start: {0}")]
    World(#[from] Rejected),
    /// A mesh too coarse for what is observed.
    #[error(
        "observe.{0}.region holds no vertex of this mesh; make it larger, or sheet.triangles more"
    )]
    NothingSeen(String),
    /// The fabric cannot be one.
    #[error(transparent)]
    Fabric(#[from] FabricError),
}

/// What takes the steps.
pub(super) enum Engine {
    Implicit(Rule, Box<Implicit>),
    Explicit(Box<Explicit>, f64),
    Positions(Box<Xpbd>, f64),
}

/// A model with its state.
pub struct Simulation {
    pub(super) model: Model,
    pub(super) state: State,
    pub(super) report: StepReport,
    pub(super) engine: Engine,
    /// The state at the start, for a reset.
    pub(super) start: State,
    pub(super) found: Option<Equilibrium>,
    /// Whether the report is that of a sheet asleep.
    pub(super) asleep: bool,
}

impl Simulation {
    /// Builds model and start state from a checked scene; results do not depend on `threads`.
    pub fn new(scene: &Scene, threads: usize) -> Result<Self, Refused> {
        let fabric = scene.fabric.resolve()?;
        let model = Model::new(scene, fabric);
        if let Some(blind) = model.readings.iter().find(|r| r.probe.is_empty()) {
            return Err(Refused::NothingSeen(blind.name.clone()));
        }
        let (state, touch) = start::start(&model)?;
        let method = &scene.method;
        let engine = match (Rule::of(method), method.solver) {
            (Some(_), Solver::Xpbd) => {
                let substep = method.substep.unwrap_or(method.dt / xpbd::SUBSTEPS);
                Engine::Positions(Box::new(Xpbd::new(&model)), substep)
            }
            (Some(rule), _) => Engine::Implicit(rule, Box::new(Implicit::new(&model, threads))),
            (None, _) => {
                let explicit = Box::new(Explicit::new(&model, &state.nodes(), threads));
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
            start: state.clone(),
            state,
            report,
            engine,
            found: None,
            asleep: false,
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

    /// Substep of the explicit scheme \[s\], if that is the method; shorter where it may touch obstacles.
    pub fn substep(&self) -> Option<f64> {
        match self.engine {
            Engine::Explicit(_, substep) => Some(substep),
            Engine::Implicit(..) | Engine::Positions(..) => None,
        }
    }

    /// Takes one step, or leaves the state as it was and says why. A step that the sheet sleeps through
    /// ([`crate::scene::SleepSpec`]) reports no work.
    pub fn step(&mut self) -> Result<&StepReport, Diverged> {
        if sleep::sleeps(&self.model, &self.engine, &self.state) {
            return Ok(self.sleep());
        }
        self.asleep = false;
        // The last report is of the state that the step starts from.
        let near = self.report.layers_near;
        let mut next = self.state.clone();
        let mut report = StepReport {
            dt: self.model.scene.method.dt,
            converged: true,
            ..StepReport::default()
        };
        let touch = match &mut self.engine {
            Engine::Implicit(Rule::GradientFlow, solver) => {
                let (touch, found) = equilibrium_step(&self.model, solver, &mut next, &mut report)?;
                self.found = Some(found);
                touch
            }
            Engine::Implicit(rule, solver) => {
                let method = (&mut **solver, near);
                implicit_step(&self.model, *rule, method, &mut next, &mut report)?
            }
            Engine::Explicit(explicit, substep) => {
                let method = (&mut **explicit, near);
                explicit_step(&self.model, method, *substep, &mut next, &mut report)?
            }
            Engine::Positions(xpbd, substep) => {
                position_step(&self.model, xpbd, *substep, &mut next, &mut report)?
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
    /// A step that is slept through; the first one looks at the sheet once more.
    fn sleep(&mut self) -> &StepReport {
        sleep::sleep(&self.model, &mut self.state);
        if !self.asleep {
            self.look();
            self.report.work = Work::default();
            self.asleep = true;
        }
        self.report.step = self.state.step;
        self.report.time = self.state.step as f64 * self.report.dt;
        self.report.digest = self.state.digest();
        &self.report
    }
}

fn substep(model: &Model, limit: f64) -> Result<f64, Refused> {
    let keeps = model.scene.method.limit == StableLimit::Keep;
    match model.scene.method.substep {
        Some(asked) if asked > limit && keeps => Err(Refused::Unstable { asked, limit }),
        Some(asked) => Ok(asked),
        None => Ok(SAFETY * limit),
    }
}
