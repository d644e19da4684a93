//! Why there is no plan.

use super::plan::Tolerance;

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// Nothing to hold to the tolerance.
    #[error("scene `{0}` observes nothing; give it an [observe.NAME]")]
    NothingObserved(String),
    /// No way through time to compare.
    #[error(
        "scene `{0}` comes to rest in each step, and a waterfall compares ways through time; name one, such as \
         method.scheme = bdf2"
    )]
    NoTime(String),
    /// The mesh would have to be finer than is tried.
    #[error(
        "no mesh that runs in {budget} CPU seconds is within {tolerance}: {triangles} triangles are {:.2} % off by their \
         own estimate in {cpu:.1} s, and at order {order:.1} it would take {:.1e} triangles and {:.0e} s; try a wider \
         --tolerance{} or a larger --budget", 1e2 * estimate, *triangles as f64 * finer, cpu * dearer,
        if *at_rest { "" } else { ", a shorter --duration" }
    )]
    TooFine {
        /// What a run may cost \[CPU-s\].
        budget: f64,
        /// Triangles of the finest mesh that was tried.
        triangles: usize,
        /// What it cost \[CPU-s\].
        cpu: f64,
        /// Asked for.
        tolerance: Tolerance,
        /// Estimated error of the finest mesh \[-\].
        estimate: f64,
        /// Order with which it falls, measured or assumed.
        order: f64,
        /// Triangles of a mesh that is fine enough, if it goes on like that, over those of the finest \[-\].
        finer: f64,
        /// Its cost over that of the finest \[-\].
        dearer: f64,
        /// Whether each step ends at rest, so that a shorter run is no cheaper.
        at_rest: bool,
    },
    /// No two meshes to compare.
    #[error(
        "{budget} CPU seconds are not enough for two meshes, which an estimate needs; try a larger --budget"
    )]
    TooDear {
        /// What a run may cost \[CPU-s\].
        budget: f64,
    },
    /// What is observed depends on the step more than it may.
    #[error(
        "no step is within {tolerance} on {triangles} triangles: the mesh may be {:.2} % off, and half the explicit \
         scheme's substep still {:.2} %; try a wider --tolerance or a shorter --duration", 1e2 * space, 1e2 * time
    )]
    TooSensitive {
        /// Asked for.
        tolerance: Tolerance,
        /// Triangles of the mesh.
        triangles: usize,
        /// Estimated error of the mesh \[-\].
        space: f64,
        /// Estimated error of half the substep \[-\].
        time: f64,
    },
    /// A run that must not fail did.
    #[error("{0}")]
    Died(String),
}
