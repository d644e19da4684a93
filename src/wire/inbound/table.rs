//! Every channel that requests come in on, in one table.

use super::{Malformed, Outcome, Request, air, answer, object, obstacle};
use crate::wire::cdr::CdrError;
use crate::wire::messages::geometry_msgs::Vector3Stamped;
use crate::wire::messages::moveit_msgs::CollisionObject;
use crate::wire::messages::nav_msgs::Odometry;
use crate::wire::messages::toile_msgs::{AirflowCommand, ObstacleCommand};
use crate::wire::{Message, MessageType, cdr};

/// Longest request \[bytes\].
const MOST_BYTES: usize = 1 << 20;

/// How an inlet is reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InletKind {
    /// Messages, with no answer.
    Topic,
    /// Requests, each with one answer.
    Service,
}

/// A channel that requests come in on.
#[derive(Debug)]
pub struct Inlet {
    /// ROS 2 name of the topic or service.
    pub name: &'static str,
    /// Which of them it is.
    pub kind: InletKind,
    /// Type of what comes in.
    pub request: &'static MessageType,
    /// Type of the answer of a service.
    pub response: Option<&'static MessageType>,
    read: fn(&[u8]) -> Result<Request, Malformed>,
    pub(super) write: fn(&Outcome) -> Result<Vec<u8>, CdrError>,
}

impl PartialEq for Inlet {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

macro_rules! topic {
    ($name:literal, $message:ty, $read:path) => {
        Inlet {
            name: $name,
            kind: InletKind::Topic,
            request: <$message>::TYPE,
            response: None,
            read: |bytes| $read(cdr::decode::<$message>(bytes)?),
            write: answer::nothing,
        }
    };
}

static OBSTACLE: Inlet = topic!("/toile/cmd/obstacle", ObstacleCommand, obstacle::command);
static COLLISION_OBJECT: Inlet = topic!(
    "/toile/cmd/collision_object",
    CollisionObject,
    object::collision_object
);
static ODOMETRY: Inlet = topic!("/toile/cmd/obstacle_odometry", Odometry, obstacle::odometry);
static AIRFLOW: Inlet = topic!("/toile/cmd/airflow", AirflowCommand, air::flow);
static WIND: Inlet = topic!("/toile/cmd/wind", Vector3Stamped, air::wind);

/// All of them.
pub static ALL: &[&Inlet] = &[&OBSTACLE, &COLLISION_OBJECT, &ODOMETRY, &AIRFLOW, &WIND];

/// The inlet of a name.
pub fn find(name: &str) -> Option<&'static Inlet> {
    ALL.iter().copied().find(|inlet| inlet.name == name)
}

/// Reads what came in on an inlet and checks all of it.
pub fn decode(inlet: &Inlet, bytes: &[u8]) -> Result<Request, Malformed> {
    match bytes.len() {
        0..=MOST_BYTES => (inlet.read)(bytes),
        bytes => Err(Malformed::TooLong {
            bytes,
            most: MOST_BYTES,
        }),
    }
}
