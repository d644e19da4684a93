//! Prescribed motion: poses at given times, and how it goes from one to the next.

use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::obstacle::{Pose, Velocity};

/// How a motion goes from one pose to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Law {
    /// At constant velocity, which jumps at the given times.
    #[default]
    Linear,
    /// From rest to rest with continuous acceleration: 10 s^3 - 15 s^4 + 6 s^5.
    Smooth,
}

impl Law {
    /// Share of the way and its rate at a share of the time, 0 to 1.
    fn progress(self, s: f64) -> (f64, f64) {
        match self {
            Law::Linear => (s, 1.0),
            Law::Smooth => {
                let rest = s * (1.0 - s);
                let share = s * s * s * (10.0 + s * (6.0 * s - 15.0));
                (share, 30.0 * rest * rest)
            }
        }
    }
}

/// A rigid motion. Positions go straight from one to the next, rotations about one axis and the shorter way.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    law: Law,
    /// Times \[s\], rising, with the poses then; at least one.
    poses: Vec<(f64, Pose)>,
}

impl Motion {
    /// A motion through poses at rising times \[s\].
    ///
    /// # Panics
    /// If there is no pose.
    pub fn new(law: Law, poses: Vec<(f64, Pose)>) -> Self {
        assert!(!poses.is_empty(), "a motion has poses");
        Self { law, poses }
    }

    /// Pose and velocity at a time \[s\]; at rest before the first pose and after the last. Where the velocity jumps,
    /// that of the interval that begins.
    pub fn at(&self, time: f64) -> (Pose, Velocity) {
        let next = self.poses.partition_point(|(t, _)| *t <= time);
        if next == 0 || next == self.poses.len() {
            let (_, pose) = self.poses[next.saturating_sub(1)];
            return (pose, Velocity::default());
        }
        let [(start, from), (end, to)] = [self.poses[next - 1], self.poses[next]];
        let span = end - start;
        let (share, rate) = self.law.progress((time - start) / span);
        let way = to.translation.vector - from.translation.vector;
        let turn = (to.rotation * from.rotation.inverse()).scaled_axis();
        let place: Vector3<f64> = from.translation.vector + way * share;
        let pose = Pose::from_parts(
            place.into(),
            UnitQuaternion::from_scaled_axis(turn * share) * from.rotation,
        );
        let velocity = Velocity {
            linear: way * (rate / span),
            angular: turn * (rate / span),
        };
        (pose, velocity)
    }

    /// Largest linear and angular speed \[m/s, rad/s\].
    pub fn fastest(&self) -> (f64, f64) {
        let peak = match self.law {
            Law::Linear => 1.0,
            Law::Smooth => 1.875,
        };
        let mut fastest: (f64, f64) = (0.0, 0.0);
        for pair in self.poses.windows(2) {
            let [(start, from), (end, to)] = [pair[0], pair[1]];
            let rate = peak / (end - start);
            let way = (to.translation.vector - from.translation.vector).norm();
            let turn = to.rotation.angle_to(&from.rotation);
            fastest = (fastest.0.max(way * rate), fastest.1.max(turn * rate));
        }
        fastest
    }
}
