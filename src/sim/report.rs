//! What a step says of itself.

use serde::Serialize;

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

/// Deterministic count of work in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Work {
    /// Substeps taken (1 for an implicit step that converged at once).
    pub substeps: u64,
    /// Attempts that did not converge and were repeated smaller.
    pub rejected: u64,
    /// Newton iterations.
    pub iterations: u64,
    /// Numerical factorisations.
    pub factorisations: u64,
    /// Linear solves.
    pub solves: u64,
    /// Line search halvings.
    pub halvings: u64,
    /// Searches of the sheet for where it comes near to itself.
    pub layer_searches: u64,
    /// Pairs of its features that they found near.
    pub layer_pairs: u64,
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
    /// Whether the residual met the tolerance.
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
    /// Edges of the sheet that pass through its faces.
    pub crossings: u64,
    /// Terms that the scene leaves out and should not.
    pub neglected: Vec<&'static str>,
    /// 64-bit digest of the state.
    pub digest: u64,
    /// Readings named in the scene, in its order \[m\].
    pub readings: Vec<f64>,
}
