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
}

impl Request {
    /// The changes of the world that it asks for where these obstacles are, taken all or none; empty for a request
    /// that asks for something else.
    pub fn commands(&self, present: &[Obstacle]) -> Vec<Command> {
        match self {
            Request::Command(commands) => commands.clone(),
            Request::Object(object) => object.commands(present),
        }
    }
}
