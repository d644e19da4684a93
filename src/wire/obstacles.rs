//! Obstacles: their shapes once, as a URDF that every viewer draws, and their poses as `/tf`.

use std::fmt::Write as _;

use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};

use super::messages::geometry_msgs::{self, Transform, TransformStamped};
use super::messages::tf2_msgs::TFMessage;
use super::{WORLD, header};
use crate::contact::{Obstacle, Pose, Shape, Velocity};

/// A half-space is drawn as a slab of this edge \[m\] whose top is the plane.
const PLANE_EXTENT: f64 = 2.0;
/// Thickness of that slab \[m\].
const PLANE_THICKNESS: f64 = 0.01;
/// A disc has no thickness; it is drawn as a cylinder of this length \[m\].
const DISC_THICKNESS: f64 = 2e-4;

/// URDF of the obstacles: a link each, named like the obstacle, floating in the world.
pub fn robot_description(obstacles: &[Obstacle]) -> String {
    let mut xml = String::from("<?xml version=\"1.0\"?>\n<robot name=\"toile\">\n");
    xml += "  <material name=\"obstacle\"><color rgba=\"0.45 0.50 0.56 1\"/></material>\n";
    let _ = writeln!(xml, "  <link name=\"{WORLD}\"/>");
    for obstacle in obstacles {
        let name = escaped(&obstacle.name);
        let _ = writeln!(xml, "  <link name=\"{name}\">");
        for (z, geometry) in solids(&obstacle.shape) {
            let _ = writeln!(
                xml,
                "    <visual><origin xyz=\"0 0 {z}\" rpy=\"0 0 0\"/><geometry>{geometry}</geometry>\
                 <material name=\"obstacle\"/></visual>"
            );
        }
        let _ = writeln!(
            xml,
            "  </link>\n  <joint name=\"{WORLD}_{name}\" type=\"floating\">\
             <parent link=\"{WORLD}\"/><child link=\"{name}\"/></joint>"
        );
    }
    xml + "</robot>\n"
}

/// The URDF solids that make up a shape: height of the centre \[m\] and geometry element.
fn solids(shape: &Shape) -> Vec<(f64, String)> {
    let cuboid = |[x, y, z]: [f64; 3]| format!("<box size=\"{x} {y} {z}\"/>");
    let sphere = |radius: f64| format!("<sphere radius=\"{radius}\"/>");
    let cylinder =
        |radius: f64, length: f64| format!("<cylinder radius=\"{radius}\" length=\"{length}\"/>");
    match *shape {
        // A URDF names the file of a mesh; its triangles are markers.
        Shape::Mesh(_) => vec![],
        Shape::Plane => vec![(
            -PLANE_THICKNESS / 2.0,
            cuboid([PLANE_EXTENT, PLANE_EXTENT, PLANE_THICKNESS]),
        )],
        Shape::Box { size } => vec![(0.0, cuboid(size))],
        Shape::Sphere { radius } => vec![(0.0, sphere(radius))],
        Shape::Disc { radius } => vec![(0.0, cylinder(radius, DISC_THICKNESS))],
        Shape::Cylinder { radius, length } => vec![(0.0, cylinder(radius, length))],
        Shape::Capsule { radius, length } => vec![
            (0.0, cylinder(radius, length)),
            (length / 2.0, sphere(radius)),
            (-length / 2.0, sphere(radius)),
        ],
    }
}

/// Text fit for an XML attribute.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('"', "&quot;")
}

/// Poses of all obstacles at a simulated time \[s\], each in a frame of its own name.
pub fn transforms(obstacles: &[Obstacle], time: f64) -> TFMessage {
    let transform = |obstacle: &Obstacle| TransformStamped {
        header: header(time),
        child_frame_id: obstacle.name.clone(),
        transform: wire(&obstacle.pose),
    };
    TFMessage {
        transforms: obstacles.iter().map(transform).collect(),
    }
}

fn wire(pose: &Pose) -> Transform {
    let (t, q) = (pose.translation.vector, pose.rotation);
    Transform {
        translation: geometry_msgs::Vector3 {
            x: t.x,
            y: t.y,
            z: t.z,
        },
        rotation: geometry_msgs::Quaternion {
            x: q.i,
            y: q.j,
            z: q.k,
            w: q.w,
        },
    }
}

/// A position as a message.
pub(super) fn wire_point(p: &Vector3<f64>) -> geometry_msgs::Point {
    geometry_msgs::Point {
        x: p.x,
        y: p.y,
        z: p.z,
    }
}

/// A pose as a message.
pub(super) fn wire_pose(pose: &Pose) -> geometry_msgs::Pose {
    let q = pose.rotation;
    geometry_msgs::Pose {
        position: wire_point(&pose.translation.vector),
        orientation: geometry_msgs::Quaternion {
            x: q.i,
            y: q.j,
            z: q.k,
            w: q.w,
        },
    }
}

/// A velocity as a message.
pub(super) fn wire_twist(velocity: &Velocity) -> geometry_msgs::Twist {
    geometry_msgs::Twist {
        linear: wire_vector(&velocity.linear),
        angular: wire_vector(&velocity.angular),
    }
}

/// A vector as a message.
pub(super) fn wire_vector(v: &Vector3<f64>) -> geometry_msgs::Vector3 {
    geometry_msgs::Vector3 {
        x: v.x,
        y: v.y,
        z: v.z,
    }
}

/// The pose that a transform holds.
pub fn pose(transform: &Transform) -> Pose {
    let (t, q) = (&transform.translation, &transform.rotation);
    Pose::from_parts(
        Translation3::new(t.x, t.y, t.z),
        UnitQuaternion::from_quaternion(Quaternion::new(q.w, q.x, q.y, q.z)),
    )
}
