//! What a request gets back: results as `simulation_interfaces` numbers them.

use super::{Inlet, Malformed};
use crate::contact::Obstacle;
use crate::sim::Rejected;
use crate::wire::cdr::{CdrError, encode};
use crate::wire::messages::geometry_msgs;
use crate::wire::messages::simulation_interfaces::{
    DeleteEntityResponse, EntityState, GetEntityStateResponse, GetSimulationStateResponse,
    GetSimulatorFeaturesResponse, ResetSimulationResponse, Result as Reply, SetEntityStateResponse,
    SetSimulationStateResponse, SimulationState, SimulatorFeatures as Feature, SpawnEntityResponse,
    StepSimulationResponse,
};
use crate::wire::{header, obstacles};

/// What became of a request.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// It was done.
    Done,
    /// What can be asked.
    Features {
        /// Whether the scene accepts obstacles.
        obstacles: bool,
    },
    /// Whether the simulation runs.
    State(RunState),
    /// Where an obstacle is at a simulated time \[s\].
    Entity {
        /// The obstacle.
        obstacle: Obstacle,
        /// When.
        time: f64,
    },
    /// An obstacle was added.
    Spawned {
        /// Under this name.
        name: String,
    },
    /// It was not understood, or cannot be done.
    Malformed(Malformed),
    /// The simulation did not take it; its state is as it was.
    Rejected(Rejected),
    /// The simulation was in the wanted state already.
    AlreadyThere(RunState),
    /// It cannot be done in this state.
    WrongState(RunState),
    /// It went wrong.
    Failed(String),
}

/// Whether steps are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunState {
    /// Not, and all is as at the start.
    Stopped,
    /// Yes.
    Playing,
    /// Not for now.
    Paused,
}

impl RunState {
    fn code(self) -> u8 {
        match self {
            RunState::Stopped => SimulationState::STATE_STOPPED,
            RunState::Playing => SimulationState::STATE_PLAYING,
            RunState::Paused => SimulationState::STATE_PAUSED,
        }
    }
}

impl std::fmt::Display for RunState {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        formatter.write_str(match self {
            RunState::Stopped => "stopped",
            RunState::Playing => "playing",
            RunState::Paused => "paused",
        })
    }
}

impl Outcome {
    /// Why it was not done, in one line; nothing if it was.
    pub fn reason(&self) -> Option<String> {
        match self {
            Outcome::Done
            | Outcome::Features { .. }
            | Outcome::State(_)
            | Outcome::Entity { .. }
            | Outcome::Spawned { .. } => None,
            Outcome::Malformed(malformed) => Some(malformed.to_string()),
            Outcome::Rejected(rejected) => Some(rejected.to_string()),
            Outcome::AlreadyThere(state) => Some(format!("the simulation is {state} already")),
            Outcome::WrongState(state) => Some(format!("the simulation is {state}")),
            Outcome::Failed(reason) => Some(reason.clone()),
        }
    }
}

/// The response of a service as CDR; nothing for a topic, which has none.
pub fn answer(inlet: &Inlet, outcome: &Outcome) -> Result<Vec<u8>, CdrError> {
    (inlet.write)(outcome)
}

/// The response of a topic.
pub(super) fn nothing(_: &Outcome) -> Result<Vec<u8>, CdrError> {
    Ok(vec![])
}

/// The result that most services share.
fn result(outcome: &Outcome) -> Reply {
    let code = match outcome {
        Outcome::Malformed(Malformed::Unsupported { .. })
        | Outcome::Rejected(Rejected::NotAccepted { .. }) => Reply::FEATURE_UNSUPPORTED,
        Outcome::Rejected(Rejected::UnknownObstacle { .. }) => Reply::NOT_FOUND,
        Outcome::WrongState(_) => Reply::INCORRECT_STATE,
        failed if failed.reason().is_some() => Reply::OPERATION_FAILED,
        _ => Reply::OK,
    };
    coded(code, outcome)
}

fn coded(result: u8, outcome: &Outcome) -> Reply {
    Reply {
        result,
        error_message: outcome.reason().unwrap_or_default(),
    }
}

pub(super) fn features(outcome: &Outcome) -> Result<Vec<u8>, CdrError> {
    let mut features = vec![
        Feature::SIMULATION_RESET,
        Feature::SIMULATION_RESET_STATE,
        Feature::SIMULATION_RESET_SPAWNED,
        Feature::SIMULATION_STATE_GETTING,
        Feature::SIMULATION_STATE_SETTING,
        Feature::SIMULATION_STATE_PAUSE,
        Feature::STEP_SIMULATION_SINGLE,
        Feature::STEP_SIMULATION_MULTIPLE,
        Feature::ENTITY_STATE_GETTING,
    ];
    if matches!(outcome, Outcome::Features { obstacles: true }) {
        features.extend([
            Feature::SPAWNING,
            Feature::SPAWNING_RESOURCE_STRING,
            Feature::DELETING,
            Feature::ENTITY_STATE_SETTING,
        ]);
    }
    features.sort_unstable();
    encode(&GetSimulatorFeaturesResponse {
        features: Feature {
            features: features.into_iter().map(u16::from).collect(),
            spawn_formats: vec!["toml".to_string()],
            custom_info: format!(
                "toile {}; an entity is an obstacle, its resource_string TOML as in [obstacle.NAME] of a scene",
                env!("CARGO_PKG_VERSION")
            ),
        },
    })
}

pub(super) fn get_state(outcome: &Outcome) -> Result<Vec<u8>, CdrError> {
    let state = match outcome {
        Outcome::State(state) => state.code(),
        _ => 0,
    };
    encode(&GetSimulationStateResponse {
        state: SimulationState { state },
        result: result(outcome),
    })
}

pub(super) fn set_state(outcome: &Outcome) -> Result<Vec<u8>, CdrError> {
    type Response = SetSimulationStateResponse;
    let result = match outcome {
        Outcome::AlreadyThere(_) => coded(Response::ALREADY_IN_TARGET_STATE, outcome),
        Outcome::WrongState(_) => coded(Response::INCORRECT_TRANSITION, outcome),
        Outcome::Failed(_) => coded(Response::STATE_TRANSITION_ERROR, outcome),
        other => result(other),
    };
    encode(&Response { result })
}

pub(super) fn step(outcome: &Outcome) -> Result<Vec<u8>, CdrError> {
    let result = match outcome {
        // So says the definition.
        Outcome::WrongState(_) => coded(Reply::OPERATION_FAILED, outcome),
        other => result(other),
    };
    encode(&StepSimulationResponse { result })
}

pub(super) fn reset(outcome: &Outcome) -> Result<Vec<u8>, CdrError> {
    let result = result(outcome);
    encode(&ResetSimulationResponse { result })
}

pub(super) fn get_entity(outcome: &Outcome) -> Result<Vec<u8>, CdrError> {
    let state = match outcome {
        Outcome::Entity { obstacle, time } => entity(obstacle, *time),
        _ => EntityState::default(),
    };
    let result = result(outcome);
    encode(&GetEntityStateResponse { result, state })
}

fn entity(obstacle: &Obstacle, time: f64) -> EntityState {
    EntityState {
        header: header(time),
        pose: obstacles::wire_pose(&obstacle.pose),
        twist: obstacles::wire_twist(&obstacle.velocity),
        acceleration: geometry_msgs::Accel::default(),
    }
}

pub(super) fn set_entity(outcome: &Outcome) -> Result<Vec<u8>, CdrError> {
    type Response = SetEntityStateResponse;
    let result = match outcome {
        Outcome::Malformed(m) if m.is_about("state.pose") => coded(Response::INVALID_POSE, outcome),
        other => result(other),
    };
    encode(&Response { result })
}

pub(super) fn delete(outcome: &Outcome) -> Result<Vec<u8>, CdrError> {
    let result = result(outcome);
    encode(&DeleteEntityResponse { result })
}

pub(super) fn spawn(outcome: &Outcome) -> Result<Vec<u8>, CdrError> {
    type Response = SpawnEntityResponse;
    let code = match outcome {
        Outcome::Rejected(Rejected::NameTaken { .. }) => Some(Response::NAME_NOT_UNIQUE),
        Outcome::Malformed(malformed) => [
            ("name", Response::NAME_INVALID),
            ("initial_pose", Response::INVALID_POSE),
            ("entity_namespace", Response::NAMESPACE_INVALID),
            ("entity_resource.uri", Response::UNSUPPORTED_FORMAT),
            ("entity_resource", Response::RESOURCE_PARSE_ERROR),
        ]
        .into_iter()
        .find_map(|(field, code)| malformed.is_about(field).then_some(code)),
        _ => None,
    };
    let entity_name = match outcome {
        Outcome::Spawned { name } => name.clone(),
        _ => String::new(),
    };
    let result = code.map_or_else(|| result(outcome), |code| coded(code, outcome));
    encode(&Response {
        result,
        entity_name,
    })
}
