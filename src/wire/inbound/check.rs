//! The ranges of what comes in, and the one place where they are checked.

use std::ops::RangeInclusive;

use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};

use super::Malformed;
use crate::contact::{Pose, Shape, Velocity};
use crate::wire::WORLD;
use crate::wire::messages::geometry_msgs;

/// Sizes of obstacles \[m\].
const SIZE: RangeInclusive<f64> = 1e-4..=100.0;
/// Coordinates of obstacles and of air regions \[m\].
const PLACE: RangeInclusive<f64> = -1e3..=1e3;
/// Components of the velocities of obstacles and air \[m/s\].
const SPEED: RangeInclusive<f64> = -100.0..=100.0;
/// Components of angular velocities \[rad/s\].
const SPIN: RangeInclusive<f64> = -1e3..=1e3;
/// Coulomb friction coefficients \[-\].
const FRICTION: RangeInclusive<f64> = 0.0..=10.0;
/// How far the length of a quaternion may be from 1; senders with single precision stay well below.
const UNIT: f64 = 1e-3;
/// Rounding alone leaves this, and is left as it is.
const ROUNDING: f64 = 1e-15;

/// A number in a range; NaN is in none.
pub(super) fn number(
    field: &str,
    value: f64,
    range: &RangeInclusive<f64>,
    unit: &str,
) -> Result<f64, Malformed> {
    if range.contains(&value) {
        return Ok(value);
    }
    let (low, high) = (range.start(), range.end());
    let range = format!("must be {low:?} to {high:?} {unit}");
    Err(Malformed::range(field, value, range.trim_end()))
}

/// A size \[m\].
pub(super) fn size(field: &str, value: f64) -> Result<f64, Malformed> {
    number(field, value, &SIZE, "m")
}

/// How far a plane is from the origin of its frame \[m\].
pub(super) fn distance(field: &str, value: f64) -> Result<f64, Malformed> {
    number(field, value, &PLACE, "m from the origin")
}

/// A friction coefficient.
pub(super) fn friction(value: f64) -> Result<f64, Malformed> {
    number("friction", value, &FRICTION, "")
}

/// A unique name of an obstacle, which is also that of its frame and part of its topics.
pub(super) fn name(field: &str, value: &str) -> Result<String, Malformed> {
    match is_name(value) {
        true => Ok(value.to_string()),
        false => Err(Malformed::range(field, value, NAME)),
    }
}

const NAME: &str =
    "must be 1 to 64 letters, digits or single _, a letter first, no _ at the end, and not world";

/// Whether this can stand in ROS topics and frames; the rule of scenes.
fn is_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && !name.contains("__")
        && !name.ends_with('_')
        && name.len() <= 64
        && name != WORLD
}

/// The one frame that commands are given in.
pub(super) fn frame(value: &str) -> Result<(), Malformed> {
    match value {
        "" | WORLD => Ok(()),
        _ => Err(Malformed::range(
            "header.frame_id",
            value,
            "must be world, or empty",
        )),
    }
}

/// A pose with its rotation normalised.
pub(super) fn pose(field: &str, pose: &geometry_msgs::Pose) -> Result<Pose, Malformed> {
    let p = &pose.position;
    let place = vector(&format!("{field}.position"), [p.x, p.y, p.z], &PLACE, "m")?;
    let q = &pose.orientation;
    let quaternion = Quaternion::new(q.w, q.x, q.y, q.z);
    let error = (quaternion.norm() - 1.0).abs();
    let rotation = match error {
        _ if error <= ROUNDING => UnitQuaternion::new_unchecked(quaternion),
        _ if error <= UNIT => UnitQuaternion::new_normalize(quaternion),
        _ => {
            let field = format!("{field}.orientation");
            let found = [q.x, q.y, q.z, q.w];
            return Err(Malformed::range(&field, found, "must be of length 1"));
        }
    };
    Ok(Pose::from_parts(Translation3::from(place), rotation))
}

/// A pose in which a quaternion of all zeros means no rotation, as MoveIt has it.
pub(super) fn lenient_pose(field: &str, given: &geometry_msgs::Pose) -> Result<Pose, Malformed> {
    let mut given = given.clone();
    let q = &mut given.orientation;
    if [q.x, q.y, q.z, q.w] == [0.0; 4] {
        q.w = 1.0;
    }
    pose(field, &given)
}

/// A position.
pub(super) fn place(field: &str, p: &geometry_msgs::Point) -> Result<Vector3<f64>, Malformed> {
    vector(field, [p.x, p.y, p.z], &PLACE, "m")
}

/// A velocity of obstacle or air.
pub(super) fn speed(field: &str, v: &geometry_msgs::Vector3) -> Result<Vector3<f64>, Malformed> {
    vector(field, [v.x, v.y, v.z], &SPEED, "m/s")
}

/// A velocity from a description \[m/s\].
pub(super) fn speeds(field: &str, v: [f64; 3]) -> Result<Vector3<f64>, Malformed> {
    vector(field, v, &SPEED, "m/s")
}

/// An angular velocity from a description \[rad/s\].
pub(super) fn spins(field: &str, v: [f64; 3]) -> Result<Vector3<f64>, Malformed> {
    vector(field, v, &SPIN, "rad/s")
}

/// A pose that was computed.
pub(super) fn placed(field: &str, pose: Pose) -> Result<Pose, Malformed> {
    let p = pose.translation.vector;
    vector(&format!("{field}.position"), [p.x, p.y, p.z], &PLACE, "m")?;
    Ok(pose)
}

/// A shape that was described in words.
pub(super) fn shape(shape: Shape) -> Result<Shape, Malformed> {
    match shape {
        Shape::Plane => {}
        Shape::Box { size: edges } => {
            for edge in edges {
                size("entity_resource.shape.size", edge)?;
            }
        }
        Shape::Sphere { radius } | Shape::Disc { radius } => {
            size("entity_resource.shape.radius", radius)?;
        }
        Shape::Cylinder { radius, length } | Shape::Capsule { radius, length } => {
            size("entity_resource.shape.radius", radius)?;
            size("entity_resource.shape.length", length)?;
        }
    }
    Ok(shape)
}

/// A twist.
pub(super) fn twist(field: &str, twist: &geometry_msgs::Twist) -> Result<Velocity, Malformed> {
    let w = &twist.angular;
    Ok(Velocity {
        linear: speed(&format!("{field}.linear"), &twist.linear)?,
        angular: vector(&format!("{field}.angular"), [w.x, w.y, w.z], &SPIN, "rad/s")?,
    })
}

fn vector(
    field: &str,
    values: [f64; 3],
    range: &RangeInclusive<f64>,
    unit: &str,
) -> Result<Vector3<f64>, Malformed> {
    for (value, axis) in values.into_iter().zip(["x", "y", "z"]) {
        number(&format!("{field}.{axis}"), value, range, unit)?;
    }
    Ok(Vector3::from(values))
}
