//! Every channel that requests come in on, in one table.

use super::compose::compose;
use super::{Malformed, Outcome, Request, air, answer, object, obstacle, services};
use crate::wire::cdr::CdrError;
use crate::wire::messages::geometry_msgs::Vector3Stamped;
use crate::wire::messages::moveit_msgs::CollisionObject;
use crate::wire::messages::nav_msgs::Odometry;
use crate::wire::messages::simulation_interfaces as verbs;
use crate::wire::messages::toile_msgs::{AirflowCommand, ObstacleCommand};
use crate::wire::{Message, MessageType, Service, ServiceType, cdr};

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
    /// The service, if it is one.
    pub service: Option<&'static ServiceType>,
    read: fn(&[u8]) -> Result<Request, Malformed>,
    compose: fn(&serde_json::Value) -> Result<Vec<u8>, String>,
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
            service: None,
            read: |bytes| $read(cdr::decode::<$message>(bytes)?),
            compose: compose::<$message>,
            write: answer::nothing,
        }
    };
}

macro_rules! service {
    ($name:literal, $service:ty, $verb:ident) => {
        Inlet {
            name: $name,
            kind: InletKind::Service,
            request: <$service as Service>::TYPE.request,
            response: Some(<$service as Service>::TYPE.response),
            service: Some(<$service as Service>::TYPE),
            read: |bytes| services::$verb(cdr::decode::<<$service as Service>::Request>(bytes)?),
            compose: compose::<<$service as Service>::Request>,
            write: answer::$verb,
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

static FEATURES: Inlet = service!(
    "/toile/get_simulator_features",
    verbs::GetSimulatorFeatures,
    features
);
static GET_STATE: Inlet = service!(
    "/toile/get_simulation_state",
    verbs::GetSimulationState,
    get_state
);
static SET_STATE: Inlet = service!(
    "/toile/set_simulation_state",
    verbs::SetSimulationState,
    set_state
);
static STEP: Inlet = service!("/toile/step_simulation", verbs::StepSimulation, step);
static RESET: Inlet = service!("/toile/reset_simulation", verbs::ResetSimulation, reset);
static GET_ENTITY: Inlet = service!("/toile/get_entity_state", verbs::GetEntityState, get_entity);
static SET_ENTITY: Inlet = service!("/toile/set_entity_state", verbs::SetEntityState, set_entity);
static SPAWN: Inlet = service!("/toile/spawn_entity", verbs::SpawnEntity, spawn);
static DELETE: Inlet = service!("/toile/delete_entity", verbs::DeleteEntity, delete);

/// All of them.
pub static ALL: &[&Inlet] = &[
    &OBSTACLE,
    &COLLISION_OBJECT,
    &ODOMETRY,
    &AIRFLOW,
    &WIND,
    &FEATURES,
    &GET_STATE,
    &SET_STATE,
    &STEP,
    &RESET,
    &GET_ENTITY,
    &SET_ENTITY,
    &SPAWN,
    &DELETE,
];

/// The inlet of a name.
pub fn find(name: &str) -> Option<&'static Inlet> {
    ALL.iter().copied().find(|inlet| inlet.name == name)
}

impl Inlet {
    /// The bytes of a request with these fields by name; fields that are not given are zero or empty.
    ///
    /// # Errors
    /// One line that names the field.
    pub fn compose(&self, fields: &serde_json::Value) -> Result<Vec<u8>, String> {
        (self.compose)(fields)
    }
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
