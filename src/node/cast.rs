//! Which obstacles a recording speaks of: those of the scene, and those that commands added.

use crate::contact::{Obstacle, Velocity};
use crate::scene::Scene;
use crate::sim::Command;
use crate::wire::inbound;
use crate::wire::messages::builtin_interfaces::Time;
use crate::wire::messages::tf2_msgs::TFMessage;
use crate::wire::messages::toile_msgs::AppliedCommand;
use crate::wire::pose;

/// Obstacles with the time \[ns\] since which they are known; a later one of the same name replaces it.
pub(super) struct Cast(Vec<(u64, Obstacle)>);

impl Cast {
    pub(super) fn new(scene: &Scene, commands: &[AppliedCommand]) -> Self {
        let start: Vec<Obstacle> = scene
            .obstacle
            .iter()
            .map(|(name, spec)| Obstacle {
                name: name.clone(),
                shape: spec.shape.clone(),
                pose: spec.pose(),
                velocity: Velocity::default(),
                friction: spec.friction,
                ..Obstacle::default()
            })
            .collect();
        let mut known: Vec<_> = start.iter().map(|o| (0, o.clone())).collect();
        let mut present = start.clone();
        for command in commands.iter().filter(|c| c.accepted) {
            let request = inbound::find(&command.channel)
                .and_then(|inlet| inbound::decode(inlet, &command.payload).ok());
            let Some(request) = request else { continue };
            let stamp = nanoseconds(&command.header.stamp);
            for change in request.commands(&present) {
                match change {
                    Command::AddObstacle(obstacle) => {
                        known.push((stamp, obstacle.clone()));
                        present.push(obstacle);
                    }
                    Command::RemoveObstacle { name } => present.retain(|o| o.name != name),
                    Command::Reset => {
                        present.clone_from(&start);
                        known.extend(start.iter().map(|o| (stamp, o.clone())));
                    }
                    Command::MoveObstacle { .. } | Command::Blow(_) => {}
                }
            }
        }
        Self(known)
    }

    /// The obstacles that there are at a time \[ns\], where they are.
    pub(super) fn placed(&self, stamp: u64, poses: &TFMessage) -> Vec<Obstacle> {
        let placed = poses.transforms.iter().filter_map(|transform| {
            let known = |(since, o): &&(u64, Obstacle)| {
                *since <= stamp && o.name == transform.child_frame_id
            };
            let (_, obstacle) = self.0.iter().rfind(known)?;
            Some(Obstacle {
                pose: pose(&transform.transform),
                ..obstacle.clone()
            })
        });
        placed.collect()
    }
}

fn nanoseconds(time: &Time) -> u64 {
    u64::try_from(time.sec).unwrap_or(0) * 1_000_000_000 + u64::from(time.nanosec)
}
