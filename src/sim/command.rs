//! The only inputs of a simulation. They latch at step boundaries; each is taken whole or not at all.

use nalgebra::Vector3;

use crate::contact::{Obstacle, Pose, Velocity};

/// A change of the world around the sheet.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// A new obstacle, under a name that no other one has.
    AddObstacle(Obstacle),
    /// Puts an obstacle elsewhere, gives it another velocity, or both; what is not given stays. A new place is a
    /// jump, which takes no cloth along; a velocity does, by friction. A motion that the scene prescribes ends with it.
    MoveObstacle {
        /// Its name.
        name: String,
        /// Where it is from now on.
        pose: Option<Pose>,
        /// Its velocity from now on.
        velocity: Option<Velocity>,
    },
    /// Takes an obstacle away.
    RemoveObstacle {
        /// Its name.
        name: String,
    },
    /// Another air flow, in place of the present one.
    Blow(Airflow),
    /// Sheet, obstacles and air as at the start of the run. Time goes on.
    Reset,
}

/// A prescribed air velocity u(x, t), spatially constant within a region, with a ramp in time.
#[derive(Clone, Debug, PartialEq)]
pub struct Airflow {
    /// Velocity at the end of the ramp \[m/s\], world frame; zero stops the air.
    pub velocity: Vector3<f64>,
    /// C of the air force C (n·(u - v)) n \[kg/(m²·s)\]; what is not given stays.
    pub fluid_damping: Option<f64>,
    /// Where it blows; everywhere if not given. Another region than before holds at once.
    pub region: Option<AirRegion>,
    /// Time of the linear ramp from the velocity before to this one \[s\]; zero is a jump.
    pub rise: f64,
    /// Time from the command to the end of the flow, which then ramps to zero in `rise` \[s\]; endless if not given.
    /// What the ramp has not reached by then it does not reach.
    pub hold: Option<f64>,
}

/// An axis-aligned box of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AirRegion {
    /// \[m\]
    pub min: Vector3<f64>,
    /// \[m\]
    pub max: Vector3<f64>,
}

/// Why a command was not taken; the state is untouched.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Rejected {
    /// Physics that the scene has switched off.
    #[error("the scene does not accept {commands} commands; add \"{commands}\" to its key accept")]
    NotAccepted {
        /// The kind, as in the scene's key `accept`.
        commands: &'static str,
    },
    /// No such obstacle.
    #[error("there is no obstacle {name:?}; there are {known}")]
    UnknownObstacle {
        /// Name in the command.
        name: String,
        /// All names there are.
        known: String,
    },
    /// The name is taken.
    #[error("there is an obstacle {name:?} already")]
    NameTaken {
        /// Name in the command.
        name: String,
    },
    /// The obstacle would stand in the sheet.
    #[error(
        "obstacle {name:?} would reach {depth:.3} mm into the cloth; at most {most:.3} mm, half its thickness, with \
         overlap.rule = \"refuse\""
    )]
    Overlap {
        /// Name of the obstacle.
        name: String,
        /// How deep it would be in the cloth \[mm\].
        depth: f64,
        /// How deep it may be \[mm\].
        most: f64,
    },
    /// A value out of its range.
    #[error("{field} = {value} is out of range: {range}")]
    OutOfRange {
        /// Field of the command.
        field: String,
        /// Its value.
        value: String,
        /// What is allowed.
        range: String,
    },
}
