//! The report of a step as a message: a mirror, field by field.

use super::header;
use super::messages::toile_msgs::{Energies, StepReport, Work};
use crate::sim;

/// What the node counts since the start of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Steps that took longer than the pace allows.
    pub overruns: u64,
    /// Messages that live carriers dropped since nobody took them in time.
    pub dropped_live: u64,
    /// Commands that were dropped since the inbox was full.
    pub dropped_commands: u64,
    /// Commands that did not decode or were out of range.
    pub malformed_commands: u64,
}

/// A report with the readings named by the scene and the node's counts.
pub fn report(model: &sim::Model, report: &sim::StepReport, counters: &Counters) -> StepReport {
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
        layer_contacts: report.layer_contacts,
        layer_gap: report.layer_gap,
        crossings: report.crossings,
        neglect_flags: report.neglected.iter().map(ToString::to_string).collect(),
        reading_names: model.scene.observe.keys().cloned().collect(),
        reading_values: report.readings.clone(),
        overruns: counters.overruns,
        dropped_live: counters.dropped_live,
        dropped_commands: counters.dropped_commands,
        malformed_commands: counters.malformed_commands,
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
        evaluations: w.evaluations,
        factorisations: w.factorisations,
        indefinite: w.indefinite,
        constant: w.constant,
        tests: w.tests,
        solves: w.solves,
        halvings: w.halvings,
        layer_searches: w.layer_searches,
        layer_pairs: w.layer_pairs,
    }
}
