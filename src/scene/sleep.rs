//! When a sheet counts as at rest, so that its steps may be skipped.

use serde::{Deserialize, Serialize};

/// A sheet none of whose vertices is faster than `speed` nor gains speed faster than `acceleration` sleeps: its steps
/// cost nothing and it stays where it is, until an obstacle, a support, the air or a command moves something.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SleepSpec {
    /// Largest speed of a vertex at rest \[m/s\].
    pub speed: f64,
    /// Largest acceleration of a vertex at rest \[m/s²\]: the force that is out of balance, over the mass.
    pub acceleration: f64,
}

impl Default for SleepSpec {
    /// A tenth of a millimetre a second, and a hundredth of the weight: contact in explicit substeps never balances to a
    /// thousandth of it at every vertex.
    fn default() -> Self {
        Self {
            speed: 1e-4,
            acceleration: 0.1,
        }
    }
}
