//! Rigid obstacles: a convex shape with a pose and a velocity.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// Shape of an obstacle in its own frame; every one is convex. Lengths in metres.
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
}

impl Obstacle {
    /// Velocity of the obstacle's point that is now at `x` \[m/s\], world frame.
    pub fn velocity_at(&self, x: &Vector3<f64>) -> Vector3<f64> {
        let arm = x - self.pose.translation.vector;
        self.velocity.linear + self.velocity.angular.cross(&arm)
    }

    /// Moves the pose by its velocity for `dt` seconds (exact rotation for constant angular velocity).
    pub fn advance(&mut self, dt: f64) {
        self.pose.translation.vector += self.velocity.linear * dt;
        let turn = UnitQuaternion::from_scaled_axis(self.velocity.angular * dt);
        self.pose.rotation = turn * self.pose.rotation;
    }
}
