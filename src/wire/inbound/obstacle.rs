//! One obstacle: our own command, and odometry, which moves it as a rig reports.

use nalgebra::{Translation3, Unit, UnitQuaternion, Vector3};

use super::{Malformed, Request, check};
use crate::contact::surface::Triangles;
use crate::contact::{Obstacle, Pose, Shape, Surface, Velocity};
use crate::sim::Command;
use crate::wire::messages::nav_msgs::Odometry;
use crate::wire::messages::shape_msgs::{Mesh, Plane, SolidPrimitive};
use crate::wire::messages::toile_msgs::ObstacleCommand;

/// Adds, moves or removes an obstacle.
pub(super) fn command(command: ObstacleCommand) -> Result<Request, Malformed> {
    check::frame(&command.header.frame_id)?;
    let name = check::name("name", &command.name)?;
    let command = match command.operation {
        ObstacleCommand::ADD => Command::AddObstacle(added(&command, name)?),
        ObstacleCommand::MOVE => moved(&command, name)?,
        ObstacleCommand::REMOVE => Command::RemoveObstacle { name },
        other => {
            let range = "must be 0 (ADD), 1 (MOVE) or 2 (REMOVE)";
            return Err(Malformed::range("operation", other, range));
        }
    };
    Ok(Request::Command(vec![command]))
}

fn added(command: &ObstacleCommand, name: String) -> Result<Obstacle, Malformed> {
    let (shape, local) = match command.shape {
        ObstacleCommand::PLANE => (Shape::Plane, plane("plane", &command.plane)?),
        ObstacleCommand::MESH => (mesh("mesh", &command.mesh)?, Pose::identity()),
        kind => (shape(kind, &command.solid)?, Pose::identity()),
    };
    let velocity = match command.set_twist {
        true => check::twist("twist", &command.twist)?,
        false => Velocity::default(),
    };
    Ok(Obstacle {
        name,
        shape,
        pose: check::placed("pose", check::pose("pose", &command.pose)? * local)?,
        velocity,
        friction: check::friction(command.friction)?,
        ..Obstacle::default()
    })
}

/// A triangle mesh.
pub(super) fn mesh(field: &str, mesh: &Mesh) -> Result<Shape, Malformed> {
    let given = Triangles {
        vertices: mesh.vertices.iter().map(|p| [p.x, p.y, p.z]).collect(),
        triangles: mesh.triangles.iter().map(|t| t.vertex_indices).collect(),
    };
    let count = given.triangles.len();
    match Surface::try_from(given) {
        Ok(surface) => Ok(Shape::Mesh(surface)),
        Err(error) => {
            let found = format_args!("{count} triangles");
            Err(Malformed::range(field, found, &error.to_string()))
        }
    }
}

fn shape(kind: u8, solid: &SolidPrimitive) -> Result<Shape, Malformed> {
    let cylinder = |dimension: usize| match solid.r#type {
        SolidPrimitive::CYLINDER => measure("solid", solid, 2, dimension),
        other => Err(Malformed::range(
            "solid.type",
            other,
            "must be 3 (CYLINDER)",
        )),
    };
    let radius = usize::from(SolidPrimitive::CYLINDER_RADIUS);
    let length = usize::from(SolidPrimitive::CYLINDER_HEIGHT);
    match kind {
        ObstacleCommand::SOLID => primitive("solid", solid),
        ObstacleCommand::DISC => match cylinder(length)? {
            0.0 => Ok(Shape::Disc {
                radius: check::size("solid.dimensions[1]", cylinder(radius)?)?,
            }),
            thick => Err(Malformed::range(
                "solid.dimensions[0]",
                thick,
                "must be 0 for DISC",
            )),
        },
        ObstacleCommand::CAPSULE => Ok(Shape::Capsule {
            radius: check::size("solid.dimensions[1]", cylinder(radius)?)?,
            length: check::size("solid.dimensions[0]", cylinder(length)?)?,
        }),
        other => Err(Malformed::range(
            "shape",
            other,
            "must be 0 (SOLID), 1 (PLANE), 3 (DISC) or 4 (CAPSULE)",
        )),
    }
}

/// A solid as toile knows it.
pub(super) fn primitive(field: &str, solid: &SolidPrimitive) -> Result<Shape, Malformed> {
    let size = |count, dimension| -> Result<f64, Malformed> {
        let value = measure(field, solid, count, dimension)?;
        check::size(&format!("{field}.dimensions[{dimension}]"), value)
    };
    match solid.r#type {
        SolidPrimitive::BOX => Ok(Shape::Box {
            size: [size(3, 0)?, size(3, 1)?, size(3, 2)?],
        }),
        SolidPrimitive::SPHERE => Ok(Shape::Sphere {
            radius: size(1, 0)?,
        }),
        SolidPrimitive::CYLINDER => Ok(Shape::Cylinder {
            length: size(2, usize::from(SolidPrimitive::CYLINDER_HEIGHT))?,
            radius: size(2, usize::from(SolidPrimitive::CYLINDER_RADIUS))?,
        }),
        SolidPrimitive::CONE | SolidPrimitive::PRISM => Err(Malformed::unsupported(
            &format!("{field}.type"),
            solid.r#type,
            "send 1 (BOX), 2 (SPHERE) or 3 (CYLINDER)",
        )),
        other => Err(Malformed::range(
            &format!("{field}.type"),
            other,
            "must be 1 (BOX), 2 (SPHERE) or 3 (CYLINDER)",
        )),
    }
}

/// One of the dimensions of a solid that has `count` of them.
fn measure(
    field: &str,
    solid: &SolidPrimitive,
    count: usize,
    dimension: usize,
) -> Result<f64, Malformed> {
    if solid.dimensions.len() == count {
        return Ok(solid.dimensions[dimension]);
    }
    let (field, found) = (format!("{field}.dimensions"), solid.dimensions.len());
    let range = format!("must be {count} numbers for type {}", solid.r#type);
    Err(Malformed::range(
        &field,
        format_args!("{found} numbers"),
        &range,
    ))
}

/// Where the half-space z <= 0 goes so that its surface is a x + b y + c z + d = 0 with (a, b, c) out of it.
pub(super) fn plane(field: &str, plane: &Plane) -> Result<Pose, Malformed> {
    let [a, b, c, d] = plane.coef;
    let normal = Vector3::new(a, b, c);
    let length = normal.norm();
    let (field, range) = (format!("{field}.coef"), "must be a normal and a distance");
    if !(1e-6..=1e6).contains(&length) || !d.is_finite() {
        return Err(Malformed::range(&field, plane.coef, range));
    }
    let distance = check::distance(&field, -d / length)?;
    let normal = Unit::new_normalize(normal);
    let turn =
        UnitQuaternion::rotation_between_axis(&Vector3::z_axis(), &normal).unwrap_or_else(|| {
            UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
        });
    Ok(Pose::from_parts(
        Translation3::from(normal.into_inner() * distance),
        turn,
    ))
}

fn moved(command: &ObstacleCommand, name: String) -> Result<Command, Malformed> {
    if !command.set_pose && !command.set_twist {
        let range = "must be set, or set_twist, to MOVE";
        return Err(Malformed::range("set_pose", false, range));
    }
    let pose = command.set_pose.then(|| check::pose("pose", &command.pose));
    let velocity = command
        .set_twist
        .then(|| check::twist("twist", &command.twist));
    Ok(Command::MoveObstacle {
        name,
        pose: pose.transpose()?,
        velocity: velocity.transpose()?,
    })
}

/// Moves the obstacle `child_frame_id`. Its twist is given in its own frame (REP 105, `nav_msgs/Odometry`).
pub(super) fn odometry(odometry: Odometry) -> Result<Request, Malformed> {
    check::frame(&odometry.header.frame_id)?;
    let pose = check::pose("pose.pose", &odometry.pose.pose)?;
    let own = check::twist("twist.twist", &odometry.twist.twist)?;
    Ok(Request::Command(vec![Command::MoveObstacle {
        name: check::name("child_frame_id", &odometry.child_frame_id)?,
        pose: Some(pose),
        velocity: Some(Velocity {
            linear: pose.rotation * own.linear,
            angular: pose.rotation * own.angular,
        }),
    }]))
}
