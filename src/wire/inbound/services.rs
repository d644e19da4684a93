//! The verbs of `simulation_interfaces`.

use super::{Malformed, Request, check};
use crate::contact::{Obstacle, Velocity};
use crate::scene::ObstacleSpec;
use crate::sim::Command;
use crate::wire::messages::simulation_interfaces::{
    DeleteEntityRequest, GetEntityStateRequest, GetSimulationStateRequest,
    GetSimulatorFeaturesRequest, ResetSimulationRequest, SetEntityStateRequest,
    SetSimulationStateRequest, SimulationState, SpawnEntityRequest, StepSimulationRequest,
};

/// Most steps of one request.
const MOST_STEPS: u64 = 1_000_000_000;
/// Longest description of an entity \[bytes\].
const LONGEST_RESOURCE: usize = 4096;
/// Name of an entity that was given none.
const NAMELESS: &str = "obstacle";
/// Longest name that can still get a number.
const LONGEST_NUMBERED: usize = 56;

pub(super) fn features(_: GetSimulatorFeaturesRequest) -> Result<Request, Malformed> {
    Ok(Request::Features)
}

pub(super) fn get_state(_: GetSimulationStateRequest) -> Result<Request, Malformed> {
    Ok(Request::GetState)
}

pub(super) fn set_state(request: SetSimulationStateRequest) -> Result<Request, Malformed> {
    match request.state.state {
        SimulationState::STATE_STOPPED => Ok(Request::Stop { quit: false }),
        SimulationState::STATE_PLAYING => Ok(Request::Resume),
        SimulationState::STATE_PAUSED => Ok(Request::Pause),
        SimulationState::STATE_QUITTING => Ok(Request::Stop { quit: true }),
        other => Err(Malformed::range(
            "state.state",
            other,
            "must be 0 (STOPPED), 1 (PLAYING), 2 (PAUSED) or 3 (QUITTING)",
        )),
    }
}

pub(super) fn step(request: StepSimulationRequest) -> Result<Request, Malformed> {
    match request.steps {
        steps @ 1..=MOST_STEPS => Ok(Request::Step(steps)),
        other => {
            let range = format!("must be 1 to {MOST_STEPS}");
            Err(Malformed::range("steps", other, &range))
        }
    }
}

/// Resets the state and takes spawned obstacles away; the two go together, and time goes on in either case.
pub(super) fn reset(request: ResetSimulationRequest) -> Result<Request, Malformed> {
    type Scope = ResetSimulationRequest;
    const WHOLE: u8 = Scope::SCOPE_STATE | Scope::SCOPE_SPAWNED;
    match request.scope {
        Scope::SCOPE_DEFAULT | Scope::SCOPE_ALL | WHOLE => {
            Ok(Request::Command(vec![Command::Reset]))
        }
        other => Err(Malformed::unsupported(
            "scope",
            other,
            "send 0 (default) or 6 (state and spawned entities); time goes on",
        )),
    }
}

pub(super) fn get_entity(request: GetEntityStateRequest) -> Result<Request, Malformed> {
    let name = check::name("entity", &request.entity)?;
    Ok(Request::GetEntity { name })
}

pub(super) fn set_entity(request: SetEntityStateRequest) -> Result<Request, Malformed> {
    let name = check::name("entity", &request.entity)?;
    let state = &request.state;
    check::frame(&state.header.frame_id)?;
    if request.set_acceleration {
        let instead = "an obstacle keeps its twist until it gets another";
        return Err(Malformed::unsupported("set_acceleration", true, instead));
    }
    if !request.set_pose && !request.set_twist {
        let range = "must be set, or set_twist";
        return Err(Malformed::range("set_pose", false, range));
    }
    let pose = request
        .set_pose
        .then(|| check::pose("state.pose", &state.pose));
    let velocity = request
        .set_twist
        .then(|| check::twist("state.twist", &state.twist));
    Ok(Request::Command(vec![Command::MoveObstacle {
        name,
        pose: pose.transpose()?,
        velocity: velocity.transpose()?,
    }]))
}

pub(super) fn delete(request: DeleteEntityRequest) -> Result<Request, Malformed> {
    let name = check::name("entity", &request.entity)?;
    let command = Command::RemoveObstacle { name };
    Ok(Request::Command(vec![command]))
}

/// An entity is an obstacle, described as in a scene: TOML with the keys of `[obstacle.NAME]`.
pub(super) fn spawn(request: SpawnEntityRequest) -> Result<Request, Malformed> {
    let rename = request.allow_renaming;
    let name = match request.name.as_str() {
        "" if rename => NAMELESS.to_string(),
        given => check::name("name", given)?,
    };
    if rename && name.len() > LONGEST_NUMBERED {
        let range = format!("must be at most {LONGEST_NUMBERED} characters with allow_renaming");
        return Err(Malformed::range("name", name, &range));
    }
    if !request.entity_namespace.is_empty() {
        let found = &request.entity_namespace;
        return Err(Malformed::range("entity_namespace", found, "must be empty"));
    }
    let start = &request.initial_pose;
    check::frame(&start.header.frame_id)?;
    let pose = check::pose("initial_pose.pose", &start.pose)?;
    let spec = resource(&request)?;
    if spec.motion.is_some() {
        let instead = "only a scene prescribes motions, send commands instead";
        let field = "entity_resource.motion";
        return Err(Malformed::unsupported(field, "a motion", instead));
    }
    if let Some(found) = spec.friction_static {
        let instead = "only a scene tells it from friction, send friction alone";
        let field = "entity_resource.friction_static";
        return Err(Malformed::unsupported(field, found, instead));
    }
    let [linear, angular] = [spec.linear_velocity, spec.angular_velocity];
    Ok(Request::Spawn {
        obstacle: Obstacle {
            name,
            shape: check::shape(spec.shape.clone())?,
            pose: check::placed("entity_resource", pose * spec.pose())?,
            velocity: Velocity {
                linear: pose.rotation * check::speeds("entity_resource.linear_velocity", linear)?,
                angular: pose.rotation * check::spins("entity_resource.angular_velocity", angular)?,
            },
            friction: check::friction(spec.friction)?,
            ..Obstacle::default()
        },
        rename,
    })
}

fn resource(request: &SpawnEntityRequest) -> Result<ObstacleSpec, Malformed> {
    let (uri, text) = (
        &request.entity_resource.uri,
        &request.entity_resource.resource_string,
    );
    if !uri.is_empty() {
        let instead = "send resource_string, TOML as in [obstacle.NAME] of a scene";
        return Err(Malformed::unsupported("entity_resource.uri", uri, instead));
    }
    let field = "entity_resource.resource_string";
    if text.is_empty() || text.len() > LONGEST_RESOURCE {
        let range = format!("must be 1 to {LONGEST_RESOURCE} bytes");
        let found = format_args!("{} bytes", text.len());
        return Err(Malformed::range(field, found, &range));
    }
    toml::from_str(text).map_err(|error: toml::de::Error| {
        let range = format!(
            "must be TOML as in [obstacle.NAME] of a scene: {}",
            error.message().replace('\n', " ")
        );
        Malformed::range(field, text, &range)
    })
}
