//! Sleep: a sheet at rest in a world at rest costs nothing until something moves.
//!
//! Whether it sleeps is a function of the state and of what the coming step prescribes, never of what was before, so a
//! recording replays and a run resumes to the same bits. A step that is slept through sets the velocities to zero and
//! leaves the rest, accelerations too: what small commands add to those in the meantime wakes it when they add up.

use nalgebra::Vector3;

use super::carry::Prescribed;
use super::measure;
use super::model::Model;
use super::simulation::Engine;
use super::state::State;
use crate::scene::SleepSpec;

/// Whether the coming step is slept through: the scene allows it, the sheet is at rest, and nothing will move.
pub fn sleeps(model: &Model, engine: &Engine, state: &State) -> bool {
    let Some(limits) = &model.scene.sleep else {
        return false;
    };
    !matches!(engine, Engine::Positions(..)) && rests(limits, state) && still(model, state)
}

/// Whether nothing moves faster than the limits; a state without accelerations has just been cut off from its past.
fn rests(limits: &SleepSpec, state: &State) -> bool {
    let accelerations = &state.history.accelerations;
    let vertices = state.velocities.len();
    let within = |list: &[Vector3<f64>], most: f64| {
        let square = most * most;
        list.iter().all(|v| v.norm_squared() <= square)
    };
    accelerations.len() >= vertices
        && within(&state.velocities, limits.speed)
        && within(&accelerations[..vertices], limits.acceleration)
}

/// Whether obstacles, supports and air stand as they do until the end of the coming step.
fn still(model: &Model, state: &State) -> bool {
    let dt = model.scene.method.dt;
    let time = model.script_time(state, dt);
    let mut obstacles = state.obstacles.clone();
    model.move_obstacles(&mut obstacles, time, dt);
    let vertices = state.positions.len();
    let stands = |held: Prescribed| {
        let value = match held.node.checked_sub(vertices) {
            None => state.positions[held.node],
            Some(edge) => state.slopes[edge],
        };
        let mut axes = (0..3).filter(|&axis| held.axes[axis]);
        axes.all(|axis| held.rate[axis] == 0.0 && held.value[axis] == value[axis])
    };
    let elapsed = (state.step - state.air.since) as f64 * dt;
    state.obstacles == obstacles
        && obstacles
            .iter()
            .all(|body| body.velocity == Default::default())
        && state.air.velocity(elapsed) == state.air.velocity(elapsed + dt)
        && model
            .carried
            .iter()
            .flat_map(|carried| carried.at(time))
            .all(stands)
}

/// Takes the state over a step that it sleeps through. What was left of its motion counts as damped.
pub fn sleep(model: &Model, state: &mut State) {
    state.ledger.damping += measure::kinetic(model, state);
    state.velocities.fill(Vector3::zeros());
    state.slope_rates.fill(Vector3::zeros());
    state.history.velocities.fill(Vector3::zeros());
    if !state.history.positions.is_empty() {
        state.history.positions.clone_from(&state.positions);
    }
    state.step += 1;
}
