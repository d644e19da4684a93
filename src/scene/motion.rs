//! Motions that a scene prescribes, and what becomes of obstacles that are put into the cloth.

use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::contact::{Law, Motion, Pose};

/// Motion of an obstacle through given poses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObstacleMotion {
    /// How it goes from one pose to the next.
    #[serde(default)]
    pub law: Law,
    /// Times of the poses since the start of the run, rising \[s\].
    pub times: Vec<f64>,
    /// World positions of its origin then \[m\]; left out, it stays at `position`.
    #[serde(default)]
    pub positions: Option<Vec<[f64; 3]>>,
    /// Roll, pitch, yaw then \[degrees\], the shorter way from one to the next; left out, it stays as `rotation` has it.
    #[serde(default)]
    pub rotations: Option<Vec<[f64; 3]>>,
}

/// Rigid motion of a support, about the centre of the part of the sheet that it holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SupportMotion {
    /// How it goes from one pose to the next.
    #[serde(default)]
    pub law: Law,
    /// Times of the poses since the start of the run, rising \[s\].
    pub times: Vec<f64>,
    /// Displacements then, from where the support is at the start \[m\]; left out, there are none.
    #[serde(default)]
    pub displacements: Option<Vec<[f64; 3]>>,
    /// Roll, pitch, yaw then, from how the support is at the start \[degrees\], the shorter way from one to the next.
    #[serde(default)]
    pub rotations: Option<Vec<[f64; 3]>>,
}

impl ObstacleMotion {
    /// The motion of an obstacle that is at rest at a position \[m\] and rotation \[degrees\].
    pub fn through(&self, (position, rotation): ([f64; 3], [f64; 3])) -> Motion {
        let pose = |i: usize| {
            let place = self.positions.as_ref().map_or(position, |list| list[i]);
            let turn = self.rotations.as_ref().map_or(rotation, |list| list[i]);
            placed(&place.into(), &turn)
        };
        let times = self.times.iter().enumerate();
        Motion::new(self.law, times.map(|(i, t)| (*t, pose(i))).collect())
    }
}

impl SupportMotion {
    /// The motion of the frame whose origin is at `centre` \[m\] and whose axes are those of the world without it.
    pub fn about(&self, centre: &Vector3<f64>) -> Motion {
        let pose = |i: usize| {
            let moved = self.displacements.as_ref().map_or([0.0; 3], |list| list[i]);
            let turn = self.rotations.as_ref().map_or([0.0; 3], |list| list[i]);
            placed(&(centre + Vector3::from(moved)), &turn)
        };
        let times = self.times.iter().enumerate();
        Motion::new(self.law, times.map(|(i, t)| (*t, pose(i))).collect())
    }
}

/// The pose at a position \[m\] with roll, pitch and yaw \[degrees\].
pub(super) fn placed(position: &Vector3<f64>, rotation: &[f64; 3]) -> Pose {
    let [roll, pitch, yaw] = rotation.map(f64::to_radians);
    Pose::from_parts(
        (*position).into(),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
}

/// What becomes of an obstacle that is put into the cloth, at the start or by a command.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OverlapSpec {
    /// Whether it may.
    pub rule: OverlapRule,
    /// Time in which the cloth is pushed out, if the speed allows it \[s\].
    pub time: f64,
    /// Largest speed at which it is pushed out \[m/s\]; deeper cloth takes longer.
    pub speed: f64,
}

impl Default for OverlapSpec {
    fn default() -> Self {
        Self {
            rule: OverlapRule::PushOut,
            time: 0.05,
            speed: 0.5,
        }
    }
}

/// Whether an obstacle may be put into the cloth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OverlapRule {
    /// It may, and pushes the cloth out.
    PushOut,
    /// It may not, deeper than half the cloth's thickness.
    Refuse,
}
