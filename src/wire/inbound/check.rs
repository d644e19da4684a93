//! Checks of what comes in: the ranges of scenes, with the path of the field in the message.

use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};

use super::Malformed;
use crate::contact::{Pose, Shape, Velocity};
use crate::scene::ranges::{FRICTION, NAME, PLACE, Range, SPEED, TURN_RATE, WIND, is_name};
use crate::wire::WORLD;
use crate::wire::messages::geometry_msgs;

/// Sizes of obstacles; what a scene may have beyond this nobody means in a message.
const SIZE: Range = Range {
    min: 1e-4,
    max: 100.0,
    unit: "m",
};
/// How far the length of a quaternion may be from 1; senders with single precision stay well below.
const UNIT: f64 = 1e-3;
/// Rounding alone leaves this, and is left as it is.
const ROUNDING: f64 = 1e-15;

/// A number in a range; NaN is in none.
pub(super) fn number(field: &str, value: f64, range: &Range) -> Result<f64, Malformed> {
    match range.contains(value) {
        true => Ok(value),
        false => Err(Malformed::range(field, value, &format!("must be {range}"))),
    }
}

/// A size \[m\].
pub(super) fn size(field: &str, value: f64) -> Result<f64, Malformed> {
    number(field, value, &SIZE)
}

/// How far a plane is from the origin of its frame \[m\].
pub(super) fn distance(field: &str, value: f64) -> Result<f64, Malformed> {
    number(field, value, &PLACE)
}

/// A friction coefficient.
pub(super) fn friction(value: f64) -> Result<f64, Malformed> {
    number("friction", value, &FRICTION)
}

/// A unique name of an obstacle, which is also that of its frame and part of its topics.
pub(super) fn name(field: &str, value: &str) -> Result<String, Malformed> {
    match is_name(value) {
        true => Ok(value.to_string()),
        false => Err(Malformed::range(field, value, &format!("must be {NAME}"))),
    }
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
    let place = vector(&format!("{field}.position"), [p.x, p.y, p.z], &PLACE)?;
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
    vector(field, [p.x, p.y, p.z], &PLACE)
}

/// A velocity of the air.
pub(super) fn wind(field: &str, v: &geometry_msgs::Vector3) -> Result<Vector3<f64>, Malformed> {
    vector(field, [v.x, v.y, v.z], &WIND)
}

/// A velocity of an obstacle.
fn speed(field: &str, v: &geometry_msgs::Vector3) -> Result<Vector3<f64>, Malformed> {
    vector(field, [v.x, v.y, v.z], &SPEED)
}

/// A velocity from a description \[m/s\].
pub(super) fn speeds(field: &str, v: [f64; 3]) -> Result<Vector3<f64>, Malformed> {
    vector(field, v, &SPEED)
}

/// An angular velocity from a description \[rad/s\].
pub(super) fn spins(field: &str, v: [f64; 3]) -> Result<Vector3<f64>, Malformed> {
    vector(field, v, &TURN_RATE)
}

/// A pose that was computed.
pub(super) fn placed(field: &str, pose: Pose) -> Result<Pose, Malformed> {
    let p = pose.translation.vector;
    vector(&format!("{field}.position"), [p.x, p.y, p.z], &PLACE)?;
    Ok(pose)
}

/// A shape that was described in words.
pub(super) fn shape(shape: Shape) -> Result<Shape, Malformed> {
    match shape {
        Shape::Plane | Shape::Mesh(_) => {}
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
        angular: vector(&format!("{field}.angular"), [w.x, w.y, w.z], &TURN_RATE)?,
    })
}

fn vector(field: &str, values: [f64; 3], range: &Range) -> Result<Vector3<f64>, Malformed> {
    for (value, axis) in values.into_iter().zip(["x", "y", "z"]) {
        number(&format!("{field}.{axis}"), value, range)?;
    }
    Ok(Vector3::from(values))
}
