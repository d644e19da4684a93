//! All that a bitwise equal resume needs.

use nalgebra::Vector3;

use super::air::Air;
use crate::contact::{Obstacle, obstacle_of, with_obstacle};

/// The integrated state. Vectors are written by stage 6 (advance) of a step.
#[derive(Clone, Debug)]
pub struct State {
    /// Index of the last step taken; time is `step * dt`.
    pub step: u64,
    /// Index of the step at which the run began, or was reset last: prescribed motions count from there.
    pub began: u64,
    /// Vertex positions \[m\], world frame, shape \[vertices\].
    pub positions: Vec<Vector3<f64>>,
    /// Vertex velocities \[m/s\], shape \[vertices\].
    pub velocities: Vec<Vector3<f64>>,
    /// Derivative of the position across each edge \[-\], shape \[edges\].
    pub slopes: Vec<Vector3<f64>>,
    /// Rates of the slopes \[1/s\], shape \[edges\]; zero but for the explicit scheme and
    /// `xpbd`, where slopes have inertia.
    pub slope_rates: Vec<Vector3<f64>>,
    /// Obstacles where they are now, in the order of their names.
    pub obstacles: Vec<Obstacle>,
    /// The air that blows.
    pub air: Air,
    /// What the scheme remembers of the past.
    pub history: History,
    /// Frictional bonds, sorted by key.
    pub bonds: Vec<Memory>,
    /// What the sheet has exchanged with the world; no step depends on it, but a report does.
    pub ledger: Ledger,
}

/// Energy exchanged since the start \[J\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger {
    /// Taken out by viscous damping.
    pub damping: f64,
    /// Taken out by friction.
    pub friction: f64,
    /// Put in by moving supports and obstacles, commands included.
    pub supports: f64,
    /// Put in by the air; negative where it brakes.
    pub air: f64,
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
    /// Accelerations now \[m/s²\], shape \[vertices\]; with the explicit scheme, those of the slopes follow. Empty
    /// after a jump of the force.
    pub accelerations: Vec<Vector3<f64>>,
}

impl History {
    /// Forgets the past, which a jump of the force has cut off from the steps to come.
    pub(super) fn restart(&mut self) {
        self.dt = 0.0;
        self.accelerations.clear();
    }
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
    /// Positions, then slopes: the nodes of the bending stencils.
    pub fn nodes(&self) -> Vec<Vector3<f64>> {
        self.positions.iter().chain(&self.slopes).copied().collect()
    }

    /// Where the obstacle of a name stands.
    pub fn find_obstacle(&self, name: &str) -> Option<usize> {
        self.obstacles
            .binary_search_by(|o| o.name.as_str().cmp(name))
            .ok()
    }

    /// Adds an obstacle at its place in the order of names; every bond stays with its obstacle.
    pub(super) fn add_obstacle(&mut self, obstacle: Obstacle) -> usize {
        let at = self.obstacles.partition_point(|o| o.name < obstacle.name);
        for bond in &mut self.bonds {
            let number = obstacle_of(bond.key);
            if number as usize >= at {
                bond.key = with_obstacle(bond.key, number + 1);
            }
        }
        self.obstacles.insert(at, obstacle);
        at
    }

    /// Takes an obstacle away with its bonds; every other bond stays with its obstacle.
    pub(super) fn remove_obstacle(&mut self, at: usize) {
        self.obstacles.remove(at);
        self.bonds
            .retain(|bond| obstacle_of(bond.key) as usize != at);
        for bond in &mut self.bonds {
            let number = obstacle_of(bond.key);
            if number as usize > at {
                bond.key = with_obstacle(bond.key, number - 1);
            }
        }
    }
}
