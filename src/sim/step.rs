//! One step of each kind of scheme, from the state to the next.

use super::air::Breeze;
use super::implicit::{Implicit, Solved};
use super::integrate::Rule;
use super::integrate::explicit::Explicit;
use super::integrate::xpbd::Xpbd;
use super::model::Model;
use super::report::{StepReport, Work};
use super::state::State;
use super::touch::Touch;
use crate::math::newton::{Limits, OVERSHOOT};
use crate::scene::{Solver, StableLimit};

/// Distance from the origin beyond which a vertex counts as lost \[m\].
const FAR: f64 = 1e6;
/// Smallest part of a step that is tried: 1/64.
const TICKS: u32 = 64;

/// Iterations of `quasi-newton` in place of one of `newton`; about what they cost.
const QUASI_NEWTON_ITERATIONS: usize = 25;

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

/// One outer step in as many parts as it needs: a part that fails is halved, one that succeeds may double.
pub fn implicit_step(
    model: &Model,
    rule: Rule,
    solver: &mut Implicit,
    state: &mut State,
    report: &mut StepReport,
) -> Result<Touch, Diverged> {
    let method = &model.scene.method;
    let limits = Limits {
        tolerance: method.tolerance,
        iterations: match method.solver {
            Solver::QuasiNewton => QUASI_NEWTON_ITERATIONS * method.max_iterations,
            _ => method.max_iterations,
        },
        overshoot: OVERSHOOT,
    };
    solver.forget();
    let (mut done, mut size) = (0, TICKS);
    let mut touch = Touch::default();
    while done < TICKS {
        let dt = method.dt * f64::from(size) / f64::from(TICKS);
        let within = method.dt * f64::from(done) / f64::from(TICKS);
        let solved = solver.solve(model, state, rule, (within, dt), &limits);
        count(&solved, report);
        if !solved.outcome.converged {
            if size == 1 {
                return Err(diverged(model, state, &solved, dt));
            }
            report.work.rejected += 1;
            size /= 2;
            continue;
        }
        advance(model, state, rule, &solved, (within, dt));
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
    report.work += Work::of(outcome);
    report.work.substeps += u64::from(outcome.converged);
    if outcome.converged {
        report.residual = report.residual.max(outcome.norm);
    }
}

/// Takes the solved part of a step and enters in the ledger what it exchanged.
fn advance(
    model: &Model,
    state: &mut State,
    rule: Rule,
    solved: &Solved,
    (within, dt): (f64, f64),
) {
    let breeze = Breeze::of(model, state);
    let powers = |state: &State, moment: f64| {
        let drag = breeze.as_ref().map(|breeze| breeze.at(moment));
        let air = drag.map_or(0.0, |drag| drag.power(&state.positions, &state.velocities));
        [model.damping.power(&state.velocities), air]
    };
    let before = powers(state, within);
    let pushed = solved
        .touch
        .work_of_obstacles(model, &state.obstacles, &solved.nodes);
    let slipped = take(state, rule, solved, dt);
    let after = powers(state, within + dt);
    let ledger = &mut state.ledger;
    ledger.damping += 0.5 * dt * (before[0] + after[0]);
    ledger.air += 0.5 * dt * (before[1] + after[1]);
    ledger.friction += slipped;
    // Contact acts from the start of the step to where its forces are taken, and on to the end.
    ledger.supports += pushed / solved.map.fraction;
}

/// Takes the state to the end of a solved step; returns the energy that slip took out \[J\].
pub fn take(state: &mut State, rule: Rule, solved: &Solved, dt: f64) -> f64 {
    let (bonds, slipped) = solved.touch.settle(&solved.nodes);
    rule.advance(state, &solved.map, &solved.nodes, dt);
    state.bonds = bonds;
    state.obstacles.iter_mut().for_each(|o| o.advance(dt));
    slipped
}

/// The step that failed, with where it was worst.
fn diverged(model: &Model, state: &State, solved: &Solved, dt: f64) -> Diverged {
    let method = &model.scene.method;
    let advice = format!(
        "try a smaller method.dt (now {:.1e} s), a finer mesh there, or more method.max_iterations (now {})",
        method.dt, method.max_iterations
    );
    let worst = (solved.outcome.norm, solved.worst);
    Diverged {
        dt,
        ..failure(model, state, worst, advice)
    }
}

/// A step that failed with a residual over the weight \[-\], largest at a vertex.
pub fn failure(
    model: &Model,
    state: &State,
    (residual, vertex): (f64, usize),
    advice: String,
) -> Diverged {
    let dt = model.scene.method.dt;
    Diverged {
        step: state.step + 1,
        time: state.step as f64 * dt,
        dt,
        residual,
        vertex,
        at: state.positions[vertex].into(),
        advice,
    }
}

/// One outer step in equal substeps.
pub fn explicit_step(
    model: &Model,
    explicit: &mut Explicit,
    substep: f64,
    state: &mut State,
    report: &mut StepReport,
) -> Result<Touch, Diverged> {
    let substep = match model.scene.method.limit {
        StableLimit::Keep => explicit.substep(model, state, substep, report.dt),
        StableLimit::Ignore => substep,
    };
    let parts = parts(report.dt, substep);
    let dt = report.dt / parts as f64;
    let touch = explicit.advance(model, state, dt, parts);
    report.work.substeps = parts;
    report.work.evaluations = parts;
    let advice = "leave method.substep out, or try one below";
    found(model, state, dt, advice).map(|()| touch)
}

/// Substeps of at most `substep` in a step; rounding must not add one.
fn parts(dt: f64, substep: f64) -> u64 {
    (dt / substep * (1.0 - 1e-12)).ceil().max(1.0) as u64
}

/// One outer step of position-based substeps. It is not repeated where it does not converge: it says so.
pub fn position_step(
    model: &Model,
    xpbd: &mut Xpbd,
    substep: f64,
    state: &mut State,
    report: &mut StepReport,
) -> Result<Touch, Diverged> {
    let parts = parts(report.dt, substep);
    let dt = report.dt / parts as f64;
    let (touch, residual, _) = xpbd.advance(model, state, dt, parts);
    report.work.substeps = parts;
    report.work.iterations = parts;
    report.work.evaluations = parts + 1;
    report.residual = residual;
    report.converged = residual <= model.scene.method.tolerance;
    found(model, state, dt, "try a method.substep below").map(|()| touch)
}

/// Whether all vertices are somewhere; else which is not, with advice that ends in half of `dt` \[s\].
fn found(model: &Model, state: &State, dt: f64, advice: &str) -> Result<(), Diverged> {
    let lost = |x: &nalgebra::Vector3<f64>| !x.iter().all(|c| c.is_finite() && c.abs() < FAR);
    let Some(vertex) = state.positions.iter().position(lost) else {
        return Ok(());
    };
    Err(Diverged {
        at: model.start()[vertex].into(),
        dt,
        ..failure(
            model,
            state,
            (f64::INFINITY, vertex),
            format!("{advice} {:.1e} s", 0.5 * dt),
        )
    })
}
