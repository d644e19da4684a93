//! All that a bitwise equal resume needs.

use nalgebra::Vector3;

use crate::contact::Obstacle;

/// The integrated state.
#[derive(Clone, Debug)]
pub struct State {
    /// Index of the last step taken; time is `step * dt`.
    pub step: u64,
    /// Vertex positions \[m\], world frame, shape \[vertices\].
    pub positions: Vec<Vector3<f64>>,
    /// Vertex velocities \[m/s\], shape \[vertices\].
    pub velocities: Vec<Vector3<f64>>,
    /// Derivative of the position across each edge \[-\], shape \[edges\].
    pub slopes: Vec<Vector3<f64>>,
    /// Obstacles where they are now, in the order of the scene.
    pub obstacles: Vec<Obstacle>,
}
