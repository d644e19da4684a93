//! All that stays constant in a run.

use crate::fabric::Fabric;
use crate::scene::Scene;
use crate::sheet::Mesh;

/// Mesh, fabric and scene of a run.
#[derive(Clone, Debug)]
pub struct Model {
    /// The scene as checked.
    pub scene: Scene,
    /// The fabric in SI constants.
    pub fabric: Fabric,
    /// The sheet.
    pub mesh: Mesh,
}
