//! Collision objects of MoveIt, with its rules: ADD replaces, a quaternion of zeros is no rotation, and the pose
//! of an only shape is that of its object if the object has none.
//!
//! An object of one shape that needs no pose of its own is an obstacle of the same name. Any other becomes
//! several, `NAME_0`, `NAME_1`, ... in the order of primitives, meshes, planes; to move them, MOVE brings the shapes'
//! poses again, since obstacles do not know of each other.

use super::obstacle::{mesh, plane, primitive};
use super::{Malformed, Request, check};
use crate::contact::{Obstacle, Pose, Shape, Velocity};
use crate::sim::Command;
use crate::wire::messages::geometry_msgs;
use crate::wire::messages::moveit_msgs::CollisionObject;

/// Most shapes that one object may have.
const MOST_SHAPES: usize = 64;
/// Friction of obstacles that come from planners, whose objects have none.
const FRICTION: f64 = 0.0;

/// What is to be done with an object; what that means depends on the obstacles that there are.
#[derive(Clone, Debug, PartialEq)]
pub enum Object {
    /// Puts it in place of what has its name.
    Put {
        /// Its name.
        name: String,
        /// What it consists of, named.
        obstacles: Vec<Obstacle>,
    },
    /// Moves it.
    Move(Vec<(String, Pose)>),
    /// Takes it away.
    Remove {
        /// Its name.
        name: String,
    },
}

impl Object {
    /// The commands that do it where these obstacles are.
    pub fn commands(&self, present: &[Obstacle]) -> Vec<Command> {
        let remove = |name| Command::RemoveObstacle { name };
        match self {
            Object::Put { name, obstacles } => {
                let old = parts(name, present).into_iter().map(remove);
                old.chain(obstacles.iter().cloned().map(Command::AddObstacle))
                    .collect()
            }
            Object::Move(poses) => poses
                .iter()
                .map(|(name, pose)| Command::MoveObstacle {
                    name: name.clone(),
                    pose: Some(*pose),
                    velocity: None,
                })
                .collect(),
            Object::Remove { name } => match parts(name, present) {
                // The simulation says that it is not there.
                none if none.is_empty() => vec![remove(name.clone())],
                old => old.into_iter().map(remove).collect(),
            },
        }
    }
}

/// The names of the obstacles that an object consists of.
fn parts(name: &str, present: &[Obstacle]) -> Vec<String> {
    let is_there = |name: &String| present.iter().any(|o| o.name == *name);
    let whole = name.to_string();
    if is_there(&whole) {
        return vec![whole];
    }
    let numbered = (0..MOST_SHAPES).map(|i| format!("{name}_{i}"));
    numbered.take_while(is_there).collect()
}

/// Adds, moves or removes an object.
pub(super) fn collision_object(object: CollisionObject) -> Result<Request, Malformed> {
    check::frame(&object.header.frame_id)?;
    let name = check::name("id", &object.id)?;
    let object = match object.operation {
        CollisionObject::ADD => put(&object, name)?,
        CollisionObject::REMOVE => Object::Remove { name },
        CollisionObject::MOVE => moved(&object, &name)?,
        CollisionObject::APPEND => {
            let instead = "send 0 (ADD) with all shapes";
            return Err(Malformed::unsupported("operation", "APPEND", instead));
        }
        other => {
            let range = "must be 0 (ADD), 1 (REMOVE) or 3 (MOVE)";
            return Err(Malformed::range("operation", other, range));
        }
    };
    Ok(Request::Object(object))
}

fn put(object: &CollisionObject, name: String) -> Result<Object, Malformed> {
    let mut shapes: Vec<(Shape, Pose)> = vec![];
    for (i, solid) in object.primitives.iter().take(MOST_SHAPES).enumerate() {
        shapes.push((
            primitive(&format!("primitives[{i}]"), solid)?,
            Pose::identity(),
        ));
    }
    for (i, triangles) in object.meshes.iter().take(MOST_SHAPES).enumerate() {
        shapes.push((mesh(&format!("meshes[{i}]"), triangles)?, Pose::identity()));
    }
    for (i, half_space) in object.planes.iter().take(MOST_SHAPES).enumerate() {
        shapes.push((Shape::Plane, plane(&format!("planes[{i}]"), half_space)?));
    }
    let count = object.primitives.len() + object.meshes.len() + object.planes.len();
    if count == 0 || count > MOST_SHAPES {
        let range = format!("must be 1 to {MOST_SHAPES} with meshes and planes");
        let found = format_args!("{count} shapes");
        return Err(Malformed::range("primitives", found, &range));
    }
    same(
        "primitive_poses",
        &object.primitive_poses,
        object.primitives.len(),
    )?;
    same("mesh_poses", &object.mesh_poses, object.meshes.len())?;
    same("plane_poses", &object.plane_poses, object.planes.len())?;
    let poses = named(object, &name)?;
    let obstacles = poses.into_iter().zip(shapes);
    let obstacle = |((name, pose), (shape, local))| Obstacle {
        name,
        shape,
        pose: pose * local,
        velocity: Velocity::default(),
        friction: FRICTION,
        ..Obstacle::default()
    };
    Ok(Object::Put {
        obstacles: obstacles.map(obstacle).collect(),
        name,
    })
}

fn same(field: &str, poses: &[geometry_msgs::Pose], shapes: usize) -> Result<(), Malformed> {
    match poses.len() {
        found if found == shapes => Ok(()),
        found => Err(Malformed::range(
            field,
            format_args!("{found} poses"),
            &format!("must be as many as there are shapes, {shapes}"),
        )),
    }
}

fn moved(object: &CollisionObject, name: &str) -> Result<Object, Malformed> {
    if !object.primitives.is_empty() || !object.planes.is_empty() || !object.meshes.is_empty() {
        let range = "must be empty to MOVE, as must planes and meshes";
        let found = format_args!("{} shapes", object.primitives.len());
        return Err(Malformed::range("primitives", found, range));
    }
    if !object.plane_poses.is_empty() {
        let instead = "planes cannot be moved since their equations are not sent again, ADD them";
        let found = format_args!("{} poses", object.plane_poses.len());
        return Err(Malformed::unsupported("plane_poses", found, instead));
    }
    Ok(Object::Move(named(object, name)?))
}

/// World poses of the shapes of an object, with the names of their obstacles; of the object itself if there are
/// no shapes.
fn named(object: &CollisionObject, name: &str) -> Result<Vec<(String, Pose)>, Malformed> {
    let whole = check::lenient_pose("pose", &object.pose)?;
    let given = object.primitive_poses.iter().chain(&object.mesh_poses);
    let given = given.chain(&object.plane_poses);
    let poses: Result<Vec<Pose>, Malformed> = given
        .take(MOST_SHAPES + 1)
        .enumerate()
        .map(|(i, pose)| check::lenient_pose(&format!("poses[{i}]"), pose))
        .collect();
    let placed = |name: String, pose| Ok((name, check::placed("pose", pose)?));
    match poses?[..] {
        [] => Ok(vec![placed(name.to_string(), whole)?]),
        [only] if only == Pose::identity() || whole == Pose::identity() => {
            Ok(vec![placed(name.to_string(), whole * only)?])
        }
        ref several => several
            .iter()
            .enumerate()
            .map(|(i, pose)| placed(check::name("id", &format!("{name}_{i}"))?, whole * pose))
            .collect(),
    }
}
