//! What may be in a command: the ranges of a scene's keys, checked again here, since commands come from outside.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::air::Air;
use super::command::{AirRegion, Airflow, Command, Rejected};
use crate::contact::{Obstacle, Pose, Shape, Velocity};
use crate::scene::ranges::{
    FLUID_DAMPING, FRICTION, NAME, OVERLAP, PLACE, Range, SIZE, SPEED, TIME, TURN_RATE, WIND,
    is_name,
};

/// How far the norm of a rotation's quaternion may be from 1: single precision and rounded text pass.
const OFF_UNIT: f64 = 1e-3;

/// The command with exact unit quaternions, if every value in it is finite and in its range.
pub fn admit(command: &Command) -> Result<Command, Rejected> {
    let mut command = command.clone();
    match &mut command {
        Command::AddObstacle(obstacle) => self::obstacle(obstacle)?,
        Command::MoveObstacle {
            name,
            pose: place,
            velocity: rate,
        } => {
            named(name)?;
            place.as_mut().map_or(Ok(()), pose)?;
            rate.as_ref().map_or(Ok(()), velocity)?;
        }
        Command::RemoveObstacle { name } => named(name)?,
        Command::Blow(flow) => airflow(flow)?,
        Command::Reset => {}
    }
    Ok(command)
}

/// Checks an obstacle as a whole.
pub fn obstacle(obstacle: &mut Obstacle) -> Result<(), Rejected> {
    named(&obstacle.name)?;
    shape(&obstacle.shape)?;
    pose(&mut obstacle.pose)?;
    velocity(&obstacle.velocity)?;
    number("overlap.depth", obstacle.overlap.depth, &OVERLAP)?;
    number("overlap.speed", obstacle.overlap.speed, &OVERLAP)?;
    number("friction", obstacle.friction, &FRICTION)
}

fn named(name: &str) -> Result<(), Rejected> {
    if is_name(name) {
        return Ok(());
    }
    let start: String = name.chars().take(64).collect();
    Err(refusal("name", format!("{start:?}"), NAME))
}

fn shape(shape: &Shape) -> Result<(), Rejected> {
    let sizes: &[(&str, f64)] = match *shape {
        // A surface is checked when it is made.
        Shape::Plane | Shape::Mesh(_) => &[],
        Shape::Box { size: [x, y, z] } => &[("size.x", x), ("size.y", y), ("size.z", z)],
        Shape::Sphere { radius } | Shape::Disc { radius } => &[("radius", radius)],
        Shape::Cylinder { radius, length } | Shape::Capsule { radius, length } => {
            &[("radius", radius), ("length", length)]
        }
    };
    sizes
        .iter()
        .try_for_each(|(field, value)| number(&format!("shape.{field}"), *value, &SIZE))
}

/// Leaves the rotation of norm 1 to the last bit.
fn pose(pose: &mut Pose) -> Result<(), Rejected> {
    vector("position", &pose.translation.vector, &PLACE)?;
    let q: Quaternion<f64> = pose.rotation.into_inner();
    let norm = q.norm();
    if norm.is_finite() && (norm - 1.0).abs() <= OFF_UNIT {
        pose.rotation = UnitQuaternion::from_quaternion(q);
        return Ok(());
    }
    let value = format!("[{:e}, {:e}, {:e}, {:e}]", q.i, q.j, q.k, q.w);
    let range = format!("a quaternion of norm 1 to {OFF_UNIT}");
    Err(refusal("orientation", value, range))
}

fn velocity(velocity: &Velocity) -> Result<(), Rejected> {
    vector("velocity.linear", &velocity.linear, &SPEED)?;
    vector("velocity.angular", &velocity.angular, &TURN_RATE)
}

fn airflow(flow: &Airflow) -> Result<(), Rejected> {
    vector("velocity", &flow.velocity, &WIND)?;
    if let Some(fluid_damping) = flow.fluid_damping {
        number("fluid_damping", fluid_damping, &FLUID_DAMPING)?;
    }
    if let Some(AirRegion { min, max }) = &flow.region {
        vector("region.min", min, &PLACE)?;
        vector("region.max", max, &PLACE)?;
        for (i, axis) in ["x", "y", "z"].iter().enumerate() {
            if min[i] >= max[i] {
                let range = format!("less than region.max.{axis} = {:e} m", max[i]);
                return Err(refusal(
                    &format!("region.min.{axis}"),
                    format!("{:e}", min[i]),
                    range,
                ));
            }
        }
    }
    number("rise", flow.rise, &TIME)?;
    flow.hold.map_or(Ok(()), |hold| number("hold", hold, &TIME))
}

/// Checks the air of a state.
pub fn air(air: &Air) -> Result<(), Rejected> {
    vector("air.from", &air.from, &WIND)?;
    number("air.delay", air.delay, &TIME)?;
    airflow(&Airflow {
        velocity: air.to,
        fluid_damping: Some(air.fluid_damping),
        region: air.region,
        rise: air.rise,
        hold: air.hold,
    })
}

fn vector(field: &str, value: &Vector3<f64>, range: &Range) -> Result<(), Rejected> {
    ["x", "y", "z"]
        .iter()
        .zip(value.iter())
        .try_for_each(|(axis, value)| number(&format!("{field}.{axis}"), *value, range))
}

fn number(field: &str, value: f64, range: &Range) -> Result<(), Rejected> {
    if range.contains(value) {
        return Ok(());
    }
    Err(refusal(field, format!("{value:e}"), range))
}

/// A value out of its range.
pub fn refusal(field: &str, value: impl ToString, range: impl ToString) -> Rejected {
    Rejected::OutOfRange {
        field: field.to_string(),
        value: value.to_string(),
        range: range.to_string(),
    }
}
