//! One step of each kind of scheme, from the state to the next.

use super::air::Breeze;
use super::error_control::ErrorControl;
use super::implicit::{Implicit, Solved};
use super::integrate::Rule;
use super::integrate::explicit::Explicit;
use super::integrate::xpbd::Xpbd;
use super::model::Model;
use super::report::{StepReport, Work};
use super::state::State;
use super::touch::Touch;
use super::travel;
use crate::math::newton::{Limits, OVERSHOOT};
use crate::scene::{Solver, StableLimit};

/// Distance from the origin beyond which a vertex counts as lost \[m\].
const FAR: f64 = 1e6;
/// Smallest part of a step that is tried: 1/4096.
const TICKS: u32 = 4096;

/// Substeps of an explicit step beyond which it is not repeated smaller for speed.
const MOST_PARTS: u64 = 1 << 16;

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

/// One outer step in as many parts as it needs: a part that fails is halved, one that succeeds may double. With a
/// tolerance on the error of a part, one that misses it is repeated smaller too; the smallest is taken as it is, since a
/// jump of the velocity can ask for more than any step gives, but the report says that it missed. Where layers are not
/// `near` at its start, each part is looked at when it is solved, and solved again with them if they met.
pub fn implicit_step(
    model: &Model,
    rule: Rule,
    (solver, near): (&mut Implicit, bool),
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
    solver.expect_layers(near);
    let part = |size: u32| method.dt * f64::from(size) / f64::from(TICKS);
    let control = ErrorControl::of(model, rule);
    let first = |c: &ErrorControl| c.first(state, TICKS, part(1));
    let (mut done, mut size) = (0, control.as_ref().map_or(TICKS, first));
    let mut touch = Touch::default();
    while done < TICKS {
        while size > 1 && travel::ahead(model, state, part(size)) > 1.0 {
            size /= 2;
        }
        let dt = part(size);
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
        if solver.missed_layers(model, state, &solved) {
            report.work.rejected += 1;
            continue;
        }
        let end = || end_of(model, state, rule, &solved, (within, dt));
        if let Some(smaller) = misses(model, control.as_ref(), state, end, size) {
            if smaller < size {
                report.work.rejected += 1;
                size = smaller;
                continue;
            }
            report.converged = false;
        }
        advance(model, state, rule, &solved, (within, dt));
        touch = solved.touch;
        done += size;
        let may_double = control.as_ref().is_none_or(|c| c.may_double(state));
        if size < TICKS && done % (2 * size) == 0 && may_double {
            size *= 2;
        }
    }
    report.work.layer_searches += solver.layer_searches();
    Ok(touch)
}

/// Ticks with which a solved part of `size` is to be tried again: half where sheet and obstacle moved against each other
/// so far that one may have passed the other, fewer where its error is too large. `size` itself if that has to do.
fn misses(
    model: &Model,
    control: Option<&ErrorControl>,
    start: &State,
    end: impl FnOnce() -> State,
    size: u32,
) -> Option<u32> {
    let meets = size > 1 && !start.obstacles.is_empty();
    if !meets && control.is_none() {
        return None;
    }
    let end = end();
    let places = [&start.positions[..], &end.positions];
    if meets && travel::taken(model, places, [&start.obstacles, &end.obstacles]) > 2.0 {
        return Some(size / 2);
    }
    control.and_then(|control| control.smaller(start, &end, size))
}

/// The state at the end of a solved part.
fn end_of(
    model: &Model,
    state: &State,
    rule: Rule,
    solved: &Solved,
    (within, dt): (f64, f64),
) -> State {
    let mut end = state.clone();
    take(model, &mut end, rule, solved, (within, dt));
    end
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
    let held = model.held_kinetic(state);
    let slipped = take(model, state, rule, solved, (within, dt));
    let after = powers(state, within + dt);
    let accelerated = model.held_kinetic(state) - held;
    let ledger = &mut state.ledger;
    ledger.damping += 0.5 * dt * (before[0] + after[0]);
    ledger.air += 0.5 * dt * (before[1] + after[1]);
    ledger.friction += slipped;
    // Contact acts from the start of the step to where its forces are taken, and on to the end.
    ledger.supports += pushed / solved.map.fraction + solved.support_work + accelerated;
}

/// Takes the state to the end of a solved step, which starts `within` the outer one and takes `dt`; returns the energy
/// that slip took out \[J\].
pub fn take(
    model: &Model,
    state: &mut State,
    rule: Rule,
    solved: &Solved,
    (within, dt): (f64, f64),
) -> f64 {
    let (bonds, slipped) = solved.touch.settle(&solved.nodes);
    let (layer_bonds, rubbed) = solved.layers.settle(&solved.nodes);
    rule.advance(state, &solved.map, &solved.nodes, dt);
    state.bonds = bonds;
    state.layer_bonds = layer_bonds;
    if rule != Rule::GradientFlow {
        let time = model.script_time(state, within + dt);
        model.move_obstacles(&mut state.obstacles, time, dt);
        model.hold(state, time);
    }
    slipped + rubbed
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

/// One outer step in equal substeps. Where layers are not `near` at its start, they are looked at when it is over; if they
/// met, it is taken again with an eye on them.
pub fn explicit_step(
    model: &Model,
    (explicit, near): (&mut Explicit, bool),
    substep: f64,
    state: &mut State,
    report: &mut StepReport,
) -> Result<Touch, Diverged> {
    let start = state.clone();
    explicit.expect_layers(model, state, near, report.dt);
    let mut taken = substeps(model, explicit, substep, (&start, state), report)?;
    if explicit.missed_layers(model) {
        report.work.rejected += 1;
        state.clone_from(&start);
        explicit.watch_layers();
        taken = substeps(model, explicit, substep, (&start, state), report)?;
    }
    let (touch, dt) = taken;
    report.work += explicit.layer_work().unwrap_or_default();
    let advice = "leave method.substep out, or try one below";
    found(model, state, dt, advice).map(|()| touch)
}

/// Substeps of a length that obstacles and layers bear, from the start that the state is at; with that length \[s\].
fn substeps(
    model: &Model,
    explicit: &mut Explicit,
    substep: f64,
    (start, state): (&State, &mut State),
    report: &mut StepReport,
) -> Result<(Touch, f64), Diverged> {
    let substep = match model.scene.method.limit {
        StableLimit::Keep => explicit.substep(model, state, substep, report.dt),
        StableLimit::Ignore => substep,
    };
    let mut parts = parts(report.dt, substep);
    loop {
        let dt = report.dt / parts as f64;
        let (touch, haste) = explicit.advance(model, state, dt, parts);
        report.work.substeps += parts;
        report.work.evaluations += parts;
        let void = explicit.layer_work().is_none();
        if void && parts >= MOST_PARTS {
            let advice = "layers of cloth meet too hard; try a smaller method.dt or a finer mesh";
            return Err(failure(model, start, (f64::INFINITY, 0), advice.into()));
        }
        let safe = haste <= 1.0 || !haste.is_finite() || parts >= MOST_PARTS;
        let ignored = model.scene.method.limit == StableLimit::Ignore;
        if (safe || ignored) && !void {
            return Ok((touch, dt));
        }
        // Too fast to be seen coming: once more in smaller substeps.
        report.work.rejected += 1;
        parts = (parts as f64 * (1.2 * haste).min(16.0)).ceil() as u64;
        state.clone_from(start);
    }
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
