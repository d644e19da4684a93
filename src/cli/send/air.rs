//! `toile send air`.

use clap::Args;

use super::{numbers, vector};
use crate::wire::messages::geometry_msgs::{Point, Vector3};
use crate::wire::messages::toile_msgs::AirflowCommand;

/// A flow of air in place of the present one.
#[derive(Args)]
pub(super) struct AirArgs {
    /// Velocity of the air [m/s]; 0,0,0 stops it.
    #[arg(value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    velocity: [f64; 3],
    /// Force on the cloth per area and speed across it [kg/(m² s)]; what is not given stays.
    #[arg(long, value_name = "C")]
    damping: Option<f64>,
    /// Box in which it blows, lower and upper corner [m]; everywhere if not given.
    #[arg(long, value_name = "X,Y,Z,X,Y,Z", value_parser = numbers::<6>, allow_hyphen_values = true)]
    region: Option<[f64; 6]>,
    /// Time from the present flow to this one [s].
    #[arg(long, value_name = "S", default_value_t = 0.0)]
    rise: f64,
    /// Time after which it ends [s]; endless if not given.
    #[arg(long, value_name = "S")]
    hold: Option<f64>,
}

impl AirArgs {
    pub(super) fn command(&self) -> AirflowCommand {
        let [x, y, z] = self.velocity;
        let [x0, y0, z0, x1, y1, z1] = self.region.unwrap_or_default();
        AirflowCommand {
            velocity: Vector3 { x, y, z },
            set_fluid_damping: self.damping.is_some(),
            fluid_damping: self.damping.unwrap_or_default(),
            in_region: self.region.is_some(),
            region_min: Point {
                x: x0,
                y: y0,
                z: z0,
            },
            region_max: Point {
                x: x1,
                y: y1,
                z: z1,
            },
            rise: self.rise,
            ends: self.hold.is_some(),
            hold: self.hold.unwrap_or_default(),
            ..AirflowCommand::default()
        }
    }
}
