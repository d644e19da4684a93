//! States of rest: where the sheet ends when only its final shape is wanted.
//!
//! Implicit gradient flow with a growing step, which turns into Newton's method as the step grows ([`flow`]). What it
//! ends on is tested: a stationary point with a direction of negative curvature is no answer, so it is pushed off and
//! flows on ([`minimum`]).
//!
//! With `method.coarsest` it is looked for on coarser meshes first ([`nested`]). That costs about as much as from flat,
//! but what folds there are no longer depends on the mesh.

mod flow;
mod minimum;
mod nested;

use serde::Serialize;

use super::implicit::Implicit;
use super::measure;
use super::model::Model;
use super::report::{StepReport, Work};
use super::simulation::{Engine, Simulation};
use super::state::State;
use super::step::{Diverged, failure};
use super::touch::Touch;
use super::travel::before_passing;

/// Saddles that are left before the search gives up.
const MOST_SADDLES: u64 = 8;

/// A state of rest: a minimum of the energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Equilibrium {
    /// Sum of the residual forces over the weight \[-\].
    pub residual: f64,
    /// Steps of the flow, each one factorisation or more.
    pub flow_steps: u64,
    /// Saddles met and left.
    pub saddles: u64,
    /// Frequency of the softest vibration about the state \[Hz\], from above, within about 1 %; zero if the state is
    /// neutral, such as a sheet that may slide.
    pub lowest_frequency: f64,
}

impl Simulation {
    /// Finds an equilibrium from the present state, on its own mesh, to a residual of `tolerance` of the weight. The
    /// state comes to rest there; obstacles stand still, friction keeps its bonds.
    ///
    /// # Errors
    /// No minimum of the energy was reached; the state is then as it was.
    ///
    /// # Panics
    /// With another solver than Newton, which cannot do this.
    pub fn settle(&mut self, tolerance: f64) -> Result<Equilibrium, Diverged> {
        let Engine::Implicit(_, solver) = &mut self.engine else {
            panic!("settle() needs an implicit scheme with newton");
        };
        let (mut state, mut report) = (self.state.clone(), self.report.clone());
        solver.expect_layers(report.layers_near || self.model.scene.layers.is_some());
        let rest = rest(&self.model, solver, &mut state, tolerance, 0.0)?;
        measure::measure(&self.model, &state, &rest.touch, &mut report);
        self.state = state;
        self.report = report;
        self.found = Some(rest.found);
        Ok(rest.found)
    }

    /// The last state of rest that was found, if that is what the method looks for.
    pub fn equilibrium(&self) -> Option<&Equilibrium> {
        self.found.as_ref()
    }
}

/// One step of the scheme `equilibrium`: obstacles move on by the step, the sheet comes to rest against them.
pub fn equilibrium_step(
    model: &Model,
    solver: &mut Implicit,
    state: &mut State,
    report: &mut StepReport,
) -> Result<(Touch, Equilibrium), Diverged> {
    let time = model.script_time(state, model.scene.method.dt);
    let (positions, obstacles) = (state.positions.clone(), state.obstacles.clone());
    model.move_obstacles(&mut state.obstacles, time, model.scene.method.dt);
    model.hold(state, time);
    let moved = [&positions[..], &state.positions];
    if before_passing(model, moved, [&obstacles, &state.obstacles]) < 1.0 {
        let advice = "an obstacle would go through the sheet; try a smaller method.dt";
        return Err(failure(model, state, (0.0, 0), advice.into()));
    }
    let rest = rest_at(model, solver, state, time, &mut report.work)?;
    report.residual = rest.found.residual;
    Ok((rest.touch, rest.found))
}

/// Brings a sheet to rest whose supports are where they are at a `time` since the start of the run \[s\].
fn rest_at(
    model: &Model,
    solver: &mut Implicit,
    state: &mut State,
    time: f64,
    work: &mut Work,
) -> Result<Rest, Diverged> {
    let method = &model.scene.method;
    solver.expect_layers(true);
    if state.step == state.began {
        nested::approach(model, state, time, work)?;
    }
    let rest = rest(model, solver, state, method.tolerance, method.dt)
        .map_err(|diverged| nested::on_mesh(model, diverged))?;
    *work += rest.work;
    work.layer_searches += solver.layer_searches();
    Ok(rest)
}

/// What was found, with its contacts.
struct Rest {
    found: Equilibrium,
    touch: Touch,
    work: Work,
}

/// Brings the sheet to rest among obstacles that stand still, in the air of a time after the start of the step
/// \[s\].
fn rest(
    model: &Model,
    solver: &mut Implicit,
    state: &mut State,
    tolerance: f64,
    within: f64,
) -> Result<Rest, Diverged> {
    // A flow has no inertia: no surface needs to come out of the cloth slowly.
    for obstacle in &mut state.obstacles {
        obstacle.overlap = Default::default();
    }
    let moving = state.obstacles.clone();
    for obstacle in &mut state.obstacles {
        obstacle.velocity = Default::default();
        obstacle.scripted = false;
    }
    let mut work = Work::default();
    let mut saddles = 0;
    loop {
        let flowed = flow::flow(model, solver, state, (tolerance, within), &mut work)?;
        let softest = minimum::softest(model, solver, state, &mut work);
        if let Some(rate) = softest.stable() {
            state.obstacles = moving;
            state.history.restart();
            let found = Equilibrium {
                residual: flowed.residual,
                flow_steps: work.substeps + work.rejected,
                saddles,
                lowest_frequency: rate.max(0.0).sqrt() / std::f64::consts::TAU,
            };
            return Ok(Rest {
                found,
                touch: flowed.touch,
                work,
            });
        }
        saddles += 1;
        if saddles > MOST_SADDLES {
            let advice = "every state of rest found is a saddle of the energy; hold the sheet at more points, or \
                          give it a larger perturbation.amplitude";
            return Err(failure(model, state, (flowed.residual, 0), advice.into()));
        }
        softest.leave(model, state);
    }
}
