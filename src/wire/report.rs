//! The report of a step as a message: a mirror, field by field.

use super::header;
use super::messages::toile_msgs::{Energies, StepReport, Work};
use crate::sim;

/// A report with the readings named by the scene.
pub fn report(model: &sim::Model, report: &sim::StepReport) -> StepReport {
    StepReport {
        header: header(report.time),
        step: report.step,
        time: report.time,
        dt: report.dt,
        energies: energies(&report.energies),
        work: work(&report.work),
        residual: report.residual,
        converged: report.converged,
        largest_strain: report.largest_strain,
        deepest_penetration: report.deepest_penetration,
        contacts: report.contacts,
        digest: report.digest,
        neglect_flags: vec![],
        reading_names: model.scene.observe.keys().cloned().collect(),
        reading_values: report.readings.clone(),
        carrier_names: vec![],
        carrier_dropped: vec![],
    }
}

fn energies(e: &sim::Energies) -> Energies {
    Energies {
        kinetic: e.kinetic,
        stretch: e.stretch,
        bend: e.bend,
        gravity: e.gravity,
        contact: e.contact,
        damping: e.damping,
        friction: e.friction,
        supports: e.supports,
        air: e.air,
    }
}

fn work(w: &sim::Work) -> Work {
    Work {
        substeps: w.substeps,
        rejected: w.rejected,
        iterations: w.iterations,
        factorisations: w.factorisations,
        solves: w.solves,
        halvings: w.halvings,
    }
}
