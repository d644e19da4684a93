//! What may be in a command: the ranges of a scene's keys, checked again here, since commands come from outside.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::command::{Command, Rejected};
use crate::contact::{Obstacle, Pose, Shape, Velocity};
use crate::scene::ranges::{FRICTION, NAME, PLACE, Range, SIZE, SPEED, TURN_RATE, is_name};

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
        Command::Blow(_) | Command::Reset => {}
    }
    Ok(command)
}

/// Checks an obstacle as a whole.
pub fn obstacle(obstacle: &mut Obstacle) -> Result<(), Rejected> {
    named(&obstacle.name)?;
    shape(&obstacle.shape)?;
    pose(&mut obstacle.pose)?;
    velocity(&obstacle.velocity)?;
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
        Shape::Plane => &[],
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
