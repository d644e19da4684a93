//! A run goes on from a state that was kept.

use nalgebra::Vector3;

use super::admit;
use super::command::Rejected;
use super::model::Model;
use super::simulation::Simulation;
use super::state::State;
use crate::contact::{Obstacle, obstacle_of};

/// Why a state does not fit the simulation that should go on from it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Mismatch {
    /// A list has the wrong length: another mesh, or another scheme.
    #[error("state.{field} has {found} entries; this scene and method need {expected}")]
    Length {
        /// The list.
        field: &'static str,
        /// Its length.
        found: usize,
        /// What it should be.
        expected: String,
    },
    /// A number that no step can come from.
    #[error("state.{field} holds a value that is not finite")]
    NotFinite {
        /// Where.
        field: &'static str,
    },
    /// Obstacles or bonds out of order, or bonds of an obstacle that is not there.
    #[error("state.{field} is out of order, or names what is not there")]
    Order {
        /// Which list.
        field: &'static str,
    },
    /// An obstacle or air that no command could have brought.
    #[error("state: {0}")]
    World(#[from] Rejected),
    /// The scene has no contact, so its steps would pass through the obstacles.
    #[error("state.obstacles is not empty, but the scene neither has nor accepts obstacles")]
    NoContact,
    /// The scene has no air, so its steps would not feel it.
    #[error("state.air blows, but the scene neither has nor accepts air")]
    NoAir,
}

impl Simulation {
    /// Goes on from a state of the same scene: from here on every bit is what it would have been without the
    /// interruption.
    ///
    /// # Errors
    /// The state does not fit mesh, method or scene, or is damaged. The simulation is then untouched.
    pub fn resume(&mut self, state: State) -> Result<(), Mismatch> {
        sizes(&self.model, &state, self.substep().is_some())?;
        finite(&state)?;
        obstacles(&self.model, &state)?;
        air(&self.model, &state)?;
        self.state = state;
        self.look();
        Ok(())
    }
}

fn sizes(model: &Model, state: &State, explicit: bool) -> Result<(), Mismatch> {
    let (vertices, edges) = (model.masses.len(), model.mesh.edges.len());
    let past = &state.history;
    // Only the explicit scheme steps slopes in time, and only implicit ones can do without the past.
    let earlier = if past.dt > 0.0 && !explicit {
        [vertices; 2]
    } else {
        [0, vertices]
    };
    let accelerations = if explicit { vertices + edges } else { 0 };
    let lists = [
        ("positions", &state.positions, [vertices; 2]),
        ("velocities", &state.velocities, [vertices; 2]),
        ("slopes", &state.slopes, [edges; 2]),
        ("slope_rates", &state.slope_rates, [edges; 2]),
        ("history.positions", &past.positions, earlier),
        ("history.velocities", &past.velocities, earlier),
        (
            "history.accelerations",
            &past.accelerations,
            [vertices, accelerations],
        ),
    ];
    for (field, list, [one, other]) in lists {
        let found = list.len();
        if found != one && found != other {
            let expected = match one == other {
                true => one.to_string(),
                false => format!("{one} or {other}"),
            };
            return Err(Mismatch::Length {
                field,
                found,
                expected,
            });
        }
    }
    Ok(())
}

fn finite(state: &State) -> Result<(), Mismatch> {
    let past = &state.history;
    let offsets: Vec<Vector3<f64>> = state.bonds.iter().map(|bond| bond.offset).collect();
    let ledger = &state.ledger;
    let sums = [
        Vector3::new(ledger.damping, ledger.friction, ledger.supports),
        Vector3::repeat(ledger.air),
    ];
    let lists: [(&'static str, &[Vector3<f64>]); 10] = [
        ("positions", &state.positions),
        ("velocities", &state.velocities),
        ("slopes", &state.slopes),
        ("slope_rates", &state.slope_rates),
        ("history.positions", &past.positions),
        ("history.velocities", &past.velocities),
        ("history.accelerations", &past.accelerations),
        ("history.dt", &[Vector3::repeat(past.dt)]),
        ("bonds", &offsets),
        ("ledger", &sums),
    ];
    let damaged = |list: &[Vector3<f64>]| !list.iter().flatten().all(|c| c.is_finite());
    match lists.into_iter().find(|(_, list)| damaged(list)) {
        Some((field, _)) => Err(Mismatch::NotFinite { field }),
        None => Ok(()),
    }
}

fn obstacles(model: &Model, state: &State) -> Result<(), Mismatch> {
    let obstacles = &state.obstacles;
    if !obstacles.is_empty() && model.contact.is_none() {
        return Err(Mismatch::NoContact);
    }
    for obstacle in obstacles {
        admit::obstacle(&mut obstacle.clone())?;
    }
    if !obstacles.is_sorted_by(|a, b| a.name < b.name) {
        return Err(Mismatch::Order { field: "obstacles" });
    }
    let follows = |o: &Obstacle| !o.scripted || model.motions.contains_key(&o.name);
    if !obstacles.iter().all(follows) || state.began > state.step {
        return Err(Mismatch::Order { field: "obstacles" });
    }
    let known = |key: u64| (obstacle_of(key) as usize) < obstacles.len();
    let sorted = state.bonds.is_sorted_by(|a, b| a.key < b.key);
    match sorted && state.bonds.iter().all(|bond| known(bond.key)) {
        true => Ok(()),
        false => Err(Mismatch::Order { field: "bonds" }),
    }
}

fn air(model: &Model, state: &State) -> Result<(), Mismatch> {
    let air = &state.air;
    if air.fluid_damping != 0.0 && !model.drag {
        return Err(Mismatch::NoAir);
    }
    admit::air(air)?;
    match air.since <= state.step {
        true => Ok(()),
        false => Err(Mismatch::Order { field: "air.since" }),
    }
}
