//! Air: our own command, and the plain wind vector of anemometers and scripts.

use super::{Malformed, Request, check};
use crate::scene::ranges::{FLUID_DAMPING, TIME};
use crate::sim::{AirRegion, Airflow, Command};
use crate::wire::messages::{geometry_msgs::Vector3Stamped, toile_msgs::AirflowCommand};

/// An air flow with everything that can be said of it.
pub(super) fn flow(command: AirflowCommand) -> Result<Request, Malformed> {
    check::frame(&command.header.frame_id)?;
    let fluid_damping = command
        .set_fluid_damping
        .then(|| check::number("fluid_damping", command.fluid_damping, &FLUID_DAMPING))
        .transpose()?;
    let region = command.in_region.then(|| region(&command)).transpose()?;
    let hold = command
        .ends
        .then(|| check::number("hold", command.hold, &TIME))
        .transpose()?;
    Ok(Request::Command(vec![Command::Blow(Airflow {
        velocity: check::wind("velocity", &command.velocity)?,
        fluid_damping,
        region,
        rise: check::number("rise", command.rise, &TIME)?,
        hold,
    })]))
}

fn region(command: &AirflowCommand) -> Result<AirRegion, Malformed> {
    let min = check::place("region_min", &command.region_min)?;
    let max = check::place("region_max", &command.region_max)?;
    match min.iter().zip(max.iter()).all(|(low, high)| low < high) {
        true => Ok(AirRegion { min, max }),
        false => Err(Malformed::range(
            "region_max",
            [max.x, max.y, max.z],
            "must be greater than region_min along each axis",
        )),
    }
}

/// A wind that is the same everywhere, from now on.
pub(super) fn wind(wind: Vector3Stamped) -> Result<Request, Malformed> {
    check::frame(&wind.header.frame_id)?;
    Ok(Request::Command(vec![Command::Blow(Airflow {
        velocity: check::wind("vector", &wind.vector)?,
        fluid_damping: None,
        region: None,
        rise: 0.0,
        hold: None,
    })]))
}
