//! All that a bitwise equal resume needs.

use nalgebra::Vector3;
use xxhash_rust::xxh3::Xxh3;

use crate::contact::Obstacle;

/// The integrated state. Vectors are written by stage 6 (advance) of a step.
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
    /// Rates of the slopes \[1/s\], shape \[edges\]; zero but for the explicit scheme, where slopes have inertia.
    pub slope_rates: Vec<Vector3<f64>>,
    /// Obstacles where they are now, in the order of their names.
    pub obstacles: Vec<Obstacle>,
    /// What the scheme remembers of the past.
    pub history: History,
    /// Frictional bonds, sorted by key.
    pub bonds: Vec<Memory>,
}

/// Scheme history.
#[derive(Clone, Debug, Default)]
pub struct History {
    /// Length of the step before \[s\]; zero at the start.
    pub dt: f64,
    /// Positions one step before \[m\], shape \[vertices\]; empty at the start.
    pub positions: Vec<Vector3<f64>>,
    /// Velocities one step before \[m/s\], shape \[vertices\]; empty at the start.
    pub velocities: Vec<Vector3<f64>>,
    /// Accelerations now \[m/s²\], shape \[vertices\]; with the explicit scheme, those of the slopes follow.
    pub accelerations: Vec<Vector3<f64>>,
}

/// What a frictional bond remembers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Memory {
    /// Identity of the proximity.
    pub key: u64,
    /// Elastic tangential offset \[m\].
    pub offset: Vector3<f64>,
}

impl State {
    /// A 64-bit digest of every number that the next step depends on.
    pub fn digest(&self) -> u64 {
        let mut hash = Xxh3::new();
        let mut vectors = |list: &[Vector3<f64>]| {
            for v in list {
                for c in v.iter() {
                    hash.update(&c.to_le_bytes());
                }
            }
        };
        vectors(&self.positions);
        vectors(&self.velocities);
        vectors(&self.slopes);
        vectors(&self.slope_rates);
        vectors(&self.history.positions);
        vectors(&self.history.velocities);
        vectors(&self.history.accelerations);
        for obstacle in &self.obstacles {
            vectors(&[
                obstacle.pose.translation.vector,
                obstacle.pose.rotation.imag(),
                obstacle.velocity.linear,
                obstacle.velocity.angular,
            ]);
        }
        for bond in &self.bonds {
            vectors(&[bond.offset]);
        }
        hash.update(&self.step.to_le_bytes());
        hash.update(&self.history.dt.to_le_bytes());
        hash.digest()
    }

    /// Positions, then slopes: the nodes of the bending stencils.
    pub fn nodes(&self) -> Vec<Vector3<f64>> {
        self.positions.iter().chain(&self.slopes).copied().collect()
    }
}
