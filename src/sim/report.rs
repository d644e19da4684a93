//! What a step says of itself.

use std::ops::AddAssign;

use serde::Serialize;

use crate::math::newton::Outcome;

/// Energy ledger at the end of a step \[J\]; the last four are sums since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Energies {
    /// Kinetic.
    pub kinetic: f64,
    /// Membrane strain.
    pub stretch: f64,
    /// Bending.
    pub bend: f64,
    /// Weight, zero at the start.
    pub gravity: f64,
    /// Stored in contact compliance.
    pub contact: f64,
    /// Taken out by viscous damping.
    pub damping: f64,
    /// Taken out by friction.
    pub friction: f64,
    /// Put in by moving supports and obstacles.
    pub supports: f64,
    /// Put in by the air; negative where it brakes.
    pub air: f64,
}

/// Deterministic count of work in a step: what a run costs, without a stopwatch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Work {
    /// Substeps taken (1 for an implicit step that converged at once).
    pub substeps: u64,
    /// Attempts that did not converge, whose error was too large, or in which something met unforeseen, and were repeated.
    pub rejected: u64,
    /// Iterations of the solver.
    pub iterations: u64,
    /// Evaluations of the forces on the whole sheet.
    pub evaluations: u64,
    /// Numerical factorisations, whatever their cause: a tangent, unless it is one of the next three.
    pub factorisations: u64,
    /// Of these, tangents that were not positive definite, and were made again with more of their stress projected.
    pub indefinite: u64,
    /// Of these, constant matrices, one for each length of a part of the step.
    pub constant: u64,
    /// Of these, tests of a state of rest.
    pub tests: u64,
    /// Linear solves.
    pub solves: u64,
    /// Line search halvings.
    pub halvings: u64,
    /// Searches of the sheet for where it comes near to itself.
    pub layer_searches: u64,
    /// Pairs of its features that they found near.
    pub layer_pairs: u64,
}

impl Work {
    /// What one solve of a system took.
    pub(super) fn of(outcome: &Outcome) -> Self {
        Self {
            iterations: outcome.iterations,
            evaluations: outcome.evaluations,
            factorisations: outcome.factorisations,
            indefinite: outcome.indefinite,
            constant: outcome.constant,
            solves: outcome.solves,
            halvings: outcome.halvings,
            ..Self::default()
        }
    }
}

impl AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        self.substeps += other.substeps;
        self.rejected += other.rejected;
        self.iterations += other.iterations;
        self.evaluations += other.evaluations;
        self.factorisations += other.factorisations;
        self.indefinite += other.indefinite;
        self.constant += other.constant;
        self.tests += other.tests;
        self.solves += other.solves;
        self.halvings += other.halvings;
        self.layer_searches += other.layer_searches;
        self.layer_pairs += other.layer_pairs;
    }
}

/// Read-only outcome of a step.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StepReport {
    /// Step index.
    pub step: u64,
    /// Simulated time at the end of the step \[s\].
    pub time: f64,
    /// Step \[s\].
    pub dt: f64,
    /// Energy ledger.
    pub energies: Energies,
    /// Work counted.
    pub work: Work,
    /// Force residual over the sheet's weight \[-\].
    pub residual: f64,
    /// Whether the residual met the tolerance, and the error of every part of the step its `step_tolerance`.
    pub converged: bool,
    /// Largest principal membrane strain, absolute \[-\].
    pub largest_strain: f64,
    /// Deepest penetration of the cloth surface into an obstacle \[m\].
    pub deepest_penetration: f64,
    /// Contacts carrying force.
    pub contacts: u64,
    /// Places where layers of the sheet touch.
    pub layer_contacts: u64,
    /// Distance of the nearest layers' middle surfaces \[m\], or the thickness if none are nearer.
    pub layer_gap: f64,
    /// Whether layers touch, or nearly so.
    pub layers_near: bool,
    /// Edges of the sheet that pass through its faces.
    pub crossings: u64,
    /// Terms that the scene leaves out and should not.
    pub neglected: Vec<&'static str>,
    /// 64-bit digest of the state.
    pub digest: u64,
    /// Readings named in the scene, in its order \[m\].
    pub readings: Vec<f64>,
}
