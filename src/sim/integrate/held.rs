//! Moving supports in the explicit scheme: what they hold follows them, and they do work on it.

use crate::sim::carry::Prescribed;
use crate::sim::lanes::{Lanes, ZERO};
use crate::sim::model::Model;
use crate::sim::state::State;

/// What moving supports hold at a time since the start of the run.
pub fn prescribed(model: &Model, time: f64) -> Vec<Prescribed> {
    let carried = model.carried.iter();
    carried.flat_map(|carried| carried.at(time)).collect()
}

/// Gives what is held the half-step rates that lead there.
pub fn send(held: &[Prescribed], nodes: &[Lanes], rates: &mut [Lanes], dt: f64) {
    for Prescribed {
        node, axes, value, ..
    } in held
    {
        for axis in (0..3).filter(|&axis| axes[axis]) {
            rates[*node][axis] = (value[axis] - nodes[*node][axis]) / dt;
        }
    }
}

/// Takes rounding out of where it went, and forgets what has acted before on its slopes, which come after the vertices.
pub fn place(held: &[Prescribed], vertices: usize, nodes: &mut [Lanes], forces: &mut [Lanes]) {
    for Prescribed {
        node, axes, value, ..
    } in held
    {
        for axis in (0..3).filter(|&axis| axes[axis]) {
            nodes[*node][axis] = value[axis];
        }
        if *node >= vertices {
            forces[*node] = ZERO;
        }
    }
}

/// Work against `forces` over a substep, and against damping, which acts on held parts too \[J\].
pub fn work_of_supports(model: &Model, held: &[Prescribed], forces: &[Lanes], dt: f64) -> f64 {
    let damping = |node: usize| model.damping.coefficients.get(node).copied().unwrap_or(0.0);
    let power = |held: &Prescribed| -> f64 {
        let axes = (0..3).filter(|&axis| held.axes[axis]);
        let along = |axis: usize| {
            let rate = held.rate[axis];
            (damping(held.node) * rate - forces[held.node][axis]) * rate
        };
        axes.map(along).sum()
    };
    held.iter().map(power).sum::<f64>() * dt
}

/// Rates of what is held come from its motion, so nothing of them is kept for the next step.
pub fn rest_supports(model: &Model, state: &mut State) {
    let vertices = state.positions.len();
    for (node, axes) in model.carried.iter().flat_map(|carried| carried.held()) {
        for axis in (0..3).filter(|&axis| axes[axis]) {
            if let Some(acceleration) = state.history.accelerations.get_mut(node) {
                acceleration[axis] = 0.0;
            }
            if let Some(edge) = node.checked_sub(vertices) {
                state.slope_rates[edge][axis] = 0.0;
            }
        }
    }
}
