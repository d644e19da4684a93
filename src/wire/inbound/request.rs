//! What can be asked of a node.

use super::Object;
use crate::contact::Obstacle;
use crate::sim::Command;

/// A request that has been decoded and found in range.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// Changes of the world, taken all or none.
    Command(Vec<Command>),
    /// A collision object; [`commands`](Self::commands) says what it means.
    Object(Object),
    /// A new obstacle, under a name of the node's choice if the given one is taken or empty.
    Spawn {
        /// What to add.
        obstacle: Obstacle,
        /// Whether it may get another name.
        rename: bool,
    },
    /// Take no steps until told to.
    Pause,
    /// Take steps again.
    Resume,
    /// Pause with sheet, obstacles and air as at the start; or end the run.
    Stop {
        /// Whether the run is to end.
        quit: bool,
    },
    /// Take so many steps, while paused.
    Step(u64),
    /// Say what can be asked.
    Features,
    /// Say whether it runs.
    GetState,
    /// Say where an obstacle is.
    GetEntity {
        /// Its name.
        name: String,
    },
}

impl Request {
    /// The changes of the world that it asks for where these obstacles are, taken all or none; empty for a request
    /// that asks for something else.
    pub fn commands(&self, present: &[Obstacle]) -> Vec<Command> {
        match self {
            Request::Command(commands) => commands.clone(),
            Request::Object(object) => object.commands(present),
            Request::Spawn { obstacle, rename } => {
                let mut obstacle = obstacle.clone();
                if *rename {
                    obstacle.name = free_name(&obstacle.name, present);
                }
                vec![Command::AddObstacle(obstacle)]
            }
            Request::Stop { quit: false } => vec![Command::Reset],
            Request::Stop { quit: true }
            | Request::Pause
            | Request::Resume
            | Request::Step(_)
            | Request::Features
            | Request::GetState
            | Request::GetEntity { .. } => vec![],
        }
    }
}

/// The name if it is free, else the first of `NAME_1`, `NAME_2`, ... that is.
fn free_name(name: &str, present: &[Obstacle]) -> String {
    let is_taken = |name: &String| present.iter().any(|o| o.name == *name);
    let others = (1..=present.len()).map(|i| format!("{name}_{i}"));
    let mut names = std::iter::once(name.to_string()).chain(others);
    // Of one name more than there are obstacles, one is free.
    names.find(|n| !is_taken(n)).unwrap_or_default()
}
