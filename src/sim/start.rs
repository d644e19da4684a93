//! The state at the start of a run.

use nalgebra::Vector3;

use super::air::Breeze;
use super::command::Rejected;
use super::kernel::Kernel;
use super::lanes::{Lanes, ZERO, add, lanes, vector};
use super::layers::LayerTouch;
use super::model::Model;
use super::overlap;
use super::slopes::SlopeSolver;
use super::state::{History, Ledger, State};
use super::touch::Touch;
use crate::physics::Potential;

/// Start state at rest, slopes relaxed, with its contacts and accelerations.
///
/// # Errors
/// An obstacle stands in the cloth, and the scene refuses that.
pub fn start(model: &Model) -> Result<(State, Touch), Rejected> {
    let mut nodes = model.start();
    SlopeSolver::new(model).relax(model, &mut nodes);
    let vertices = model.masses.len();
    let mut state = State {
        step: 0,
        began: 0,
        positions: nodes[..vertices].to_vec(),
        velocities: vec![Vector3::zeros(); vertices],
        slopes: nodes[vertices..].to_vec(),
        slope_rates: vec![Vector3::zeros(); nodes.len() - vertices],
        obstacles: model.obstacles(),
        air: model.air(),
        history: History::default(),
        bonds: vec![],
        layer_bonds: vec![],
        ledger: Ledger::default(),
    };
    model.hold(&mut state, 0.0);
    overlap::enter_all(model, &mut state)?;
    let touch = Touch::of(model, &state, None);
    let mut forces = vec![ZERO; nodes.len()];
    let in_lanes: Vec<Lanes> = nodes.iter().map(lanes).collect();
    Kernel::new(model).add_forces(&in_lanes, &mut forces);
    if let Some(law) = &model.contact {
        for (v, push) in touch.pushes(model, law, &state.positions) {
            forces[v as usize] = add(forces[v as usize], lanes(&push));
        }
    }
    if let Some(law) = &model.layers {
        let layers = LayerTouch::of(model, &state);
        for (v, push) in layers.pushes(law, &state.positions) {
            forces[v as usize] = add(forces[v as usize], lanes(&push));
        }
    }
    if let Some(breeze) = Breeze::of(model, &state) {
        let pushes = breeze.at(0.0).forces(&state.positions, &state.velocities);
        for (force, push) in forces.iter_mut().zip(&pushes) {
            *force = add(*force, lanes(push));
        }
    }
    state.history.accelerations = (0..vertices)
        .map(|v| {
            let pull = vector(&forces[v]) - model.gravity.gradient(v, &[nodes[v]])[0];
            model.dofs.free(v, pull) / model.masses[v]
        })
        .collect();
    Ok((state, touch))
}
