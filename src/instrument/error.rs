//! Why an instrument gives no reading.

use super::Settings;
use crate::scene::{FabricError, SceneError};
use crate::sim::{Diverged, Refused};

/// Why there is no reading.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeasureError {
    /// A setting that the instrument cannot use.
    #[error("{field} = {value}: must be {allowed}")]
    Setting {
        /// Its name on the command line.
        field: &'static str,
        /// What it is, SI.
        value: f64,
        /// What it may be.
        allowed: String,
    },
    /// The fabric is not known or cannot be one.
    #[error("fabric.{}: {}", .0.field(), .0)]
    Fabric(#[from] FabricError),
    /// The specimen's scene was refused.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The specimen could not be built.
    #[error(transparent)]
    Refused(#[from] Refused),
    /// No state of rest was found.
    #[error("the specimen does not come to rest: {0}")]
    Diverged(#[from] Diverged),
    /// No overhang brings the strip to the angle.
    #[error(
        "no overhang brings the strip to {angle} degrees: at {overhang} m it hangs at {reached} degrees"
    )]
    NoOverhang {
        /// Wanted \[degrees\].
        angle: f64,
        /// The last that was tried \[m\].
        overhang: f64,
        /// Where the strip hung then \[degrees\].
        reached: f64,
    },
}

impl MeasureError {
    pub(super) fn setting(field: &'static str, value: f64, allowed: impl Into<String>) -> Self {
        let allowed = allowed.into();
        Self::Setting {
            field,
            value,
            allowed,
        }
    }
}

impl Settings {
    /// Whether each setting can be meant at all.
    pub(super) fn check(&self) -> Result<(), MeasureError> {
        let sizes = [
            ("length", self.length),
            ("width", self.width),
            ("edge", self.edge),
        ];
        let sizes = sizes.map(|(field, size)| (field, size.unwrap_or(1e-2), 1e-5, 10.0, "m"));
        let others = [
            ("strain", self.strain, 1e-5, 0.5, "(1 is 100 %)"),
            ("angle", self.angle, 5.0, 85.0, "degrees"),
            ("gravity", self.gravity, 1e-2, 1e3, "m/s²"),
            ("meshes", self.meshes as f64, 1.0, 100.0, ""),
        ];
        for (field, value, min, max, unit) in sizes.into_iter().chain(others) {
            if !(value >= min && value <= max) {
                let allowed = format!("from {min} to {max} {unit}");
                return Err(MeasureError::setting(field, value, allowed.trim_end()));
            }
        }
        Ok(())
    }
}
