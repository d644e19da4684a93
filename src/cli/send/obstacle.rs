//! `toile send obstacle`.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use nalgebra::UnitQuaternion;

use super::{numbers, vector};
use crate::cli::{CliError, source};
use crate::contact::Surface;
use crate::contact::surface::Triangles;
use crate::scene::ranges::MESH_SCALE;
use crate::wire::messages::geometry_msgs::{Point, Pose, Quaternion, Twist, Vector3};
use crate::wire::messages::shape_msgs::{Mesh, MeshTriangle, Plane, SolidPrimitive};
use crate::wire::messages::toile_msgs::ObstacleCommand;

/// Adds, moves or removes an obstacle.
#[derive(Args)]
pub(super) struct ObstacleArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// Add one, under a name that no other has.
    Add {
        /// Its name: letters, digits or single _, a letter first.
        name: String,
        #[command(flatten)]
        shape: Shape,
        /// What the lengths of the mesh are multiplied by; 1e-3 for millimetres.
        #[arg(long, value_name = "F", default_value_t = 1.0, value_parser = mesh_scale, requires = "mesh")]
        scale: f64,
        #[command(flatten)]
        motion: Motion,
        /// Friction coefficient against the cloth.
        #[arg(long, value_name = "MU", default_value_t = 0.3)]
        friction: f64,
    },
    /// Put one elsewhere, give it another velocity, or both.
    Move {
        /// Its name.
        name: String,
        #[command(flatten)]
        motion: Motion,
    },
    /// Take one away.
    Remove {
        /// Its name.
        name: String,
    },
}

#[derive(Args)]
#[group(required = true, multiple = false)]
struct Shape {
    /// Edge lengths of a box [m].
    #[arg(long = "box", value_name = "X,Y,Z", value_parser = vector)]
    cuboid: Option<[f64; 3]>,
    /// Radius of a sphere [m].
    #[arg(long, value_name = "R")]
    sphere: Option<f64>,
    /// Radius and length of a cylinder along its z axis [m].
    #[arg(long, value_name = "R,L", value_parser = numbers::<2>)]
    cylinder: Option<[f64; 2]>,
    /// Radius and length of a cylinder with hemispherical ends beyond it [m].
    #[arg(long, value_name = "R,L", value_parser = numbers::<2>)]
    capsule: Option<[f64; 2]>,
    /// Radius of a horizontal disc without thickness [m].
    #[arg(long, value_name = "R")]
    disc: Option<f64>,
    /// All that is below its z = 0.
    #[arg(long)]
    plane: bool,
    /// A triangle mesh in metres, from an STL or OBJ file: solid if closed, else a plate without thickness.
    #[arg(long, value_name = "FILE")]
    mesh: Option<PathBuf>,
}

#[derive(Args)]
struct Motion {
    /// Where it is [m].
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    position: Option<[f64; 3]>,
    /// Roll, pitch and yaw [degrees]; with a position.
    #[arg(long, value_name = "R,P,Y", value_parser = vector, allow_hyphen_values = true, requires = "position")]
    rotation: Option<[f64; 3]>,
    /// Its velocity [m/s].
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    velocity: Option<[f64; 3]>,
    /// Its angular velocity [rad/s].
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    spin: Option<[f64; 3]>,
}

impl ObstacleArgs {
    /// # Errors
    /// A file of triangles that cannot be read, or is no surface.
    pub(super) fn command(&self) -> Result<ObstacleCommand, CliError> {
        let mut command = ObstacleCommand::default();
        match &self.what {
            What::Add {
                name,
                shape,
                scale,
                motion,
                friction,
            } => {
                command.operation = ObstacleCommand::ADD;
                command.name.clone_from(name);
                command.friction = *friction;
                shape.put_into(*scale, &mut command)?;
                motion.put_into(&mut command);
            }
            What::Move { name, motion } => {
                command.operation = ObstacleCommand::MOVE;
                command.name.clone_from(name);
                motion.put_into(&mut command);
            }
            What::Remove { name } => {
                command.operation = ObstacleCommand::REMOVE;
                command.name.clone_from(name);
            }
        }
        Ok(command)
    }
}

impl Shape {
    fn put_into(&self, scale: f64, command: &mut ObstacleCommand) -> Result<(), CliError> {
        if let Some(path) = &self.mesh {
            command.shape = ObstacleCommand::MESH;
            command.mesh = triangles(path, scale)?;
        } else {
            self.put_solid_into(command);
        }
        Ok(())
    }

    fn put_solid_into(&self, command: &mut ObstacleCommand) {
        let mut solid = |shape, r#type, dimensions: &[f64]| {
            command.shape = shape;
            command.solid = SolidPrimitive {
                r#type,
                dimensions: dimensions.to_vec(),
                ..SolidPrimitive::default()
            };
        };
        // Of a cylinder, its definition names the length first.
        if let Some(size) = self.cuboid {
            solid(ObstacleCommand::SOLID, SolidPrimitive::BOX, &size);
        } else if let Some(radius) = self.sphere {
            solid(ObstacleCommand::SOLID, SolidPrimitive::SPHERE, &[radius]);
        } else if let Some([radius, length]) = self.cylinder {
            let size = [length, radius];
            solid(ObstacleCommand::SOLID, SolidPrimitive::CYLINDER, &size);
        } else if let Some([radius, length]) = self.capsule {
            let size = [length, radius];
            solid(ObstacleCommand::CAPSULE, SolidPrimitive::CYLINDER, &size);
        } else if let Some(radius) = self.disc {
            let size = [0.0, radius];
            solid(ObstacleCommand::DISC, SolidPrimitive::CYLINDER, &size);
        } else {
            command.shape = ObstacleCommand::PLANE;
            command.plane = Plane {
                coef: [0.0, 0.0, 1.0, 0.0],
            };
        }
    }
}

fn mesh_scale(text: &str) -> Result<f64, String> {
    let scale = text
        .parse()
        .ok()
        .filter(|&scale| MESH_SCALE.contains(scale));
    scale.ok_or_else(|| format!("must be a number {MESH_SCALE}"))
}

/// The triangles of a file, checked as those of a scene are.
fn triangles(path: &Path, scale: f64) -> Result<Mesh, CliError> {
    let refuse = |reason: String| CliError::Input(format!("{}: {reason}", path.display()));
    let bytes = source::triangles(path).map_err(CliError::Input)?;
    let surface = Surface::read(&bytes, scale).map_err(|error| refuse(error.to_string()))?;
    let Triangles {
        vertices,
        triangles,
    } = surface.into();
    let vertices = vertices.into_iter().map(|[x, y, z]| Point { x, y, z });
    let triangles = triangles
        .into_iter()
        .map(|vertex_indices| MeshTriangle { vertex_indices });
    Ok(Mesh {
        vertices: vertices.collect(),
        triangles: triangles.collect(),
    })
}

impl Motion {
    fn put_into(&self, command: &mut ObstacleCommand) {
        let [x, y, z] = self.position.unwrap_or_default();
        let [roll, pitch, yaw] = self.rotation.unwrap_or_default().map(f64::to_radians);
        let q = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
        command.set_pose = self.position.is_some();
        command.pose = Pose {
            position: Point { x, y, z },
            orientation: Quaternion {
                x: q.i,
                y: q.j,
                z: q.k,
                w: q.w,
            },
        };
        command.set_twist = self.velocity.is_some() || self.spin.is_some();
        let vector = |v: Option<[f64; 3]>| {
            let [x, y, z] = v.unwrap_or_default();
            Vector3 { x, y, z }
        };
        command.twist = Twist {
            linear: vector(self.velocity),
            angular: vector(self.spin),
        };
    }
}
