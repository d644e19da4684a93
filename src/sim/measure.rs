//! Stage 8: what a step reports, read-only.

use super::assembly::pick;
use super::layers;
use super::model::Model;
use super::overlap;
use super::report::StepReport;
use super::state::State;
use super::touch::Touch;
use crate::physics::Potential;

/// Fills in everything that can be read off a state and its contacts.
pub fn measure(model: &Model, state: &State, touch: &Touch, report: &mut StepReport) {
    let nodes = state.nodes();
    let layers = layers::inspect(model, state, report);
    let energies = &mut report.energies;
    energies.kinetic = kinetic(model, state);
    energies.stretch = total(&model.stretch, &nodes);
    energies.bend = total(&model.bend, &nodes);
    energies.gravity = total(&model.gravity, &nodes) - model.start_gravity;
    energies.damping = state.ledger.damping;
    energies.friction = state.ledger.friction;
    energies.supports = state.ledger.supports;
    energies.air = state.ledger.air;
    if let Some(law) = &model.contact {
        energies.contact = touch.energy(model, law, &nodes);
        report.deepest_penetration = overlap::deepest(model, law, state, touch);
        report.contacts = touch.proximities.len() as u64;
    }
    energies.contact += layers;
    report.largest_strain = (0..model.stretch.count())
        .map(|s| {
            model
                .stretch
                .largest_principal(s, &pick(&nodes, &model.stretch.nodes(s)))
        })
        .fold(0.0, f64::max);
    report.readings = model
        .readings
        .iter()
        .map(|r| r.probe.read(&state.positions)[r.axis] - r.start)
        .collect();
    report.step = state.step;
    report.dt = model.scene.method.dt;
    report.time = state.step as f64 * report.dt;
    report.digest = state.digest();
}

/// Kinetic energy of the vertices \[J\].
pub fn kinetic(model: &Model, state: &State) -> f64 {
    let energy = |(m, v): (&f64, &nalgebra::Vector3<f64>)| 0.5 * m * v.norm_squared();
    model.masses.iter().zip(&state.velocities).map(energy).sum()
}

/// Energy of a term over all its stencils \[J\].
pub fn total<const N: usize>(term: &impl Potential<N>, nodes: &[nalgebra::Vector3<f64>]) -> f64 {
    (0..term.count())
        .map(|s| term.value(s, &pick(nodes, &term.nodes(s))))
        .sum()
}
