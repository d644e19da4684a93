//! Rigid obstacles: a shape with a pose and a velocity.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::surface::Surface;

/// Shape of an obstacle in its own frame; every one is convex, but for meshes. Lengths in metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Shape {
    /// The half-space z <= 0.
    Plane,
    /// A box centred on the origin.
    Box {
        /// Full edge lengths \[m\].
        size: [f64; 3],
    },
    /// A ball centred on the origin.
    Sphere {
        /// Radius \[m\].
        radius: f64,
    },
    /// A circular plate without thickness in the plane z = 0.
    Disc {
        /// Radius \[m\].
        radius: f64,
    },
    /// A solid cylinder about z, centred on the origin.
    Cylinder {
        /// Radius \[m\].
        radius: f64,
        /// Length along z \[m\].
        length: f64,
    },
    /// A cylinder about z with hemispherical ends; `length` is that of the straight part.
    Capsule {
        /// Radius \[m\].
        radius: f64,
        /// Length of the axis \[m\].
        length: f64,
    },
    /// Triangles: a solid if they are closed, else a plate without thickness.
    Mesh(Surface),
}

/// Where an obstacle is: `world = orientation * local + position`.
pub type Pose = Isometry3<f64>;

/// Rigid velocity of an obstacle about its own origin, world frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Velocity {
    /// \[m/s\]
    pub linear: Vector3<f64>,
    /// \[rad/s\]
    pub angular: Vector3<f64>,
}

/// A rigid obstacle in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// Unique name, used in topics and frames.
    pub name: String,
    /// Its shape.
    pub shape: Shape,
    /// Its pose.
    pub pose: Pose,
    /// Its velocity.
    pub velocity: Velocity,
    /// Coulomb friction coefficient against the sheet \[-\].
    pub friction: f64,
    /// Whether it follows the motion that the scene prescribes for it.
    pub scripted: bool,
    /// What is left of cloth that it was put into.
    pub overlap: Overlap,
}

/// An obstacle that was put into the cloth acts from a surface drawn in by `depth`, which comes out at `speed` and
/// takes the cloth along: it is pushed off, not thrown off.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Overlap {
    /// How far the surface is still drawn in \[m\].
    pub depth: f64,
    /// How fast it comes out \[m/s\].
    pub speed: f64,
}

impl Overlap {
    /// Speed at which the surface comes out now \[m/s\].
    pub fn rate(&self) -> f64 {
        if self.depth > 0.0 { self.speed } else { 0.0 }
    }

    fn advance(&mut self, dt: f64) {
        self.depth = (self.depth - self.speed * dt).max(0.0);
        if self.depth == 0.0 {
            self.speed = 0.0;
        }
    }
}

impl Default for Obstacle {
    /// A plane without friction at rest in the origin, without a name.
    fn default() -> Self {
        Self {
            name: String::new(),
            shape: Shape::Plane,
            pose: Pose::identity(),
            velocity: Velocity::default(),
            friction: 0.0,
            scripted: false,
            overlap: Overlap::default(),
        }
    }
}

impl Obstacle {
    /// Velocity of the obstacle's point that is now at `x` \[m/s\], world frame.
    pub fn velocity_at(&self, x: &Vector3<f64>) -> Vector3<f64> {
        let arm = x - self.pose.translation.vector;
        self.velocity.linear + self.velocity.angular.cross(&arm)
    }

    /// Whether it turns, or follows a motion that may turn it.
    pub fn may_turn(&self) -> bool {
        self.scripted || self.velocity.angular.norm() > 0.0
    }

    /// Whether its surface stays where it is.
    pub fn is_still(&self) -> bool {
        !self.scripted && self.velocity == Velocity::default() && self.overlap.speed == 0.0
    }

    /// Velocity of its surface at `x`, where the normal is `normal` \[m/s\]: that of the body, and out of it while it
    /// comes out of cloth that it was put into.
    pub fn surface_velocity(&self, x: &Vector3<f64>, normal: &Vector3<f64>) -> Vector3<f64> {
        self.velocity_at(x) + normal * self.overlap.rate()
    }

    /// Moves it for `dt` seconds: by its velocity (exact rotation for constant angular velocity), or to the place that
    /// its `motion` has for it at the end.
    pub fn advance(&mut self, motion: Option<(Pose, Velocity)>, dt: f64) {
        self.overlap.advance(dt);
        if let Some((pose, velocity)) = motion {
            (self.pose, self.velocity) = (pose, velocity);
            return;
        }
        self.pose.translation.vector += self.velocity.linear * dt;
        let turn = UnitQuaternion::from_scaled_axis(self.velocity.angular * dt);
        self.pose.rotation = turn * self.pose.rotation;
    }
}
