//! The verbs of `simulation_interfaces`: what is asked, what is answered.

use nalgebra::Vector3;
use toile::contact::{Obstacle, Pose, Shape, Velocity};
use toile::sim::{Command, Rejected};
use toile::wire::inbound::{self, InletKind, Outcome, Request, RunState};
use toile::wire::messages::geometry_msgs::PoseStamped;
use toile::wire::messages::simulation_interfaces::{
    DeleteEntityRequest, DeleteEntityResponse, EntityState, GetEntityStateRequest,
    GetEntityStateResponse, GetSimulationStateRequest, GetSimulationStateResponse,
    GetSimulatorFeaturesRequest, GetSimulatorFeaturesResponse, ResetSimulationRequest, Resource,
    Result as Reply, SetEntityStateRequest, SetEntityStateResponse, SetSimulationStateRequest,
    SetSimulationStateResponse, SimulationState, SimulatorFeatures, SpawnEntityRequest,
    SpawnEntityResponse, StepSimulationRequest, StepSimulationResponse,
};
use toile::wire::{Message, cdr};

use crate::inbound::{AHEAD, LEFT, ask, commands, refusal, wire_pose};
use crate::tidy::read;

/// The answer to an outcome on an inlet.
fn answer<M: Message>(inlet: &str, outcome: Outcome) -> M {
    let inlet = inbound::find(inlet).expect("an inlet");
    assert_eq!(inlet.response.map(|r| r.name), Some(M::TYPE.name));
    cdr::decode(&inbound::answer(inlet, &outcome).expect("encodes")).expect("decodes")
}

/// What was refused, as the node hands it on.
fn refused<M: Message>(inlet: &str, request: &M) -> Outcome {
    Outcome::Malformed(ask(inlet, request).expect_err("refused"))
}

fn table() -> Obstacle {
    Obstacle {
        name: "table".into(),
        shape: Shape::Plane,
        pose: Pose::translation(1.0, 2.0, 3.0),
        velocity: Velocity {
            linear: Vector3::new(0.1, 0.2, 0.3),
            angular: Vector3::zeros(),
        },
        friction: 0.0,
        ..Obstacle::default()
    }
}

#[test]
fn states_are_asked_for_and_set() {
    let set = |state| SetSimulationStateRequest {
        state: SimulationState { state },
    };
    let inlet = "/toile/set_simulation_state";
    for (state, expected) in [
        (
            SimulationState::STATE_STOPPED,
            Request::Stop { quit: false },
        ),
        (SimulationState::STATE_PLAYING, Request::Resume),
        (SimulationState::STATE_PAUSED, Request::Pause),
        (
            SimulationState::STATE_QUITTING,
            Request::Stop { quit: true },
        ),
    ] {
        assert_eq!(ask(inlet, &set(state)), Ok(expected));
    }
    assert!(refusal(inlet, &set(4)).contains("state.state = 4"));
    let said = |outcome| {
        let response: SetSimulationStateResponse = answer(inlet, outcome);
        response.result.result
    };
    assert_eq!(said(Outcome::Done), Reply::OK);
    type Codes = SetSimulationStateResponse;
    let there = Outcome::AlreadyThere(RunState::Paused);
    assert_eq!(said(there), Codes::ALREADY_IN_TARGET_STATE);
    let wrong = Outcome::WrongState(RunState::Stopped);
    assert_eq!(said(wrong), Codes::INCORRECT_TRANSITION);

    let inlet = "/toile/get_simulation_state";
    assert_eq!(
        ask(inlet, &GetSimulationStateRequest::default()),
        Ok(Request::GetState)
    );
    let response: GetSimulationStateResponse = answer(inlet, Outcome::State(RunState::Paused));
    assert_eq!(response.state.state, SimulationState::STATE_PAUSED);
    assert_eq!(response.result.result, Reply::OK);
}

#[test]
fn steps_are_counted() {
    let inlet = "/toile/step_simulation";
    assert_eq!(
        ask(inlet, &StepSimulationRequest { steps: 7 }),
        Ok(Request::Step(7))
    );
    assert!(refusal(inlet, &StepSimulationRequest { steps: 0 }).contains("steps = 0"));
    refusal(inlet, &StepSimulationRequest { steps: u64::MAX });
    let wrong = Outcome::WrongState(RunState::Playing);
    let response: StepSimulationResponse = answer(inlet, wrong);
    assert_eq!(response.result.result, Reply::OPERATION_FAILED);
    assert_eq!(response.result.error_message, "the simulation is playing");
}

#[test]
fn a_reset_is_whole_and_time_goes_on() {
    let inlet = "/toile/reset_simulation";
    for scope in [0, 6, 255] {
        assert_eq!(
            commands(inlet, &ResetSimulationRequest { scope }),
            [Command::Reset]
        );
    }
    assert!(refusal(inlet, &ResetSimulationRequest { scope: 1 }).contains("time goes on"));
}

#[test]
fn features_are_those_of_the_scene() {
    let inlet = "/toile/get_simulator_features";
    let asked = ask(inlet, &GetSimulatorFeaturesRequest::default());
    assert_eq!(asked, Ok(Request::Features));
    let features = |obstacles| {
        let response: GetSimulatorFeaturesResponse = answer(inlet, Outcome::Features { obstacles });
        response.features.features
    };
    let spawning = u16::from(SimulatorFeatures::SPAWNING);
    let stepping = u16::from(SimulatorFeatures::STEP_SIMULATION_MULTIPLE);
    assert!(features(true).contains(&spawning) && features(true).contains(&stepping));
    assert!(!features(false).contains(&spawning) && features(false).contains(&stepping));
}

#[test]
fn an_entity_is_an_obstacle() {
    let inlet = "/toile/get_entity_state";
    let asked = GetEntityStateRequest {
        entity: "table".into(),
    };
    let name = "table".to_string();
    assert_eq!(
        ask(inlet, &asked),
        Ok(Request::GetEntity { name: name.clone() })
    );
    let found = Outcome::Entity {
        obstacle: table(),
        time: 0.5,
    };
    let response: GetEntityStateResponse = answer(inlet, found);
    assert_eq!(response.result.result, Reply::OK);
    assert_eq!(response.state.header.stamp.nanosec, 500_000_000);
    assert_eq!(response.state.pose, wire_pose([1.0, 2.0, 3.0], AHEAD));
    assert_eq!(response.state.twist.linear.z, 0.3);
    let unknown = Rejected::UnknownObstacle {
        name: name.clone(),
        known: "none".into(),
    };
    let response: GetEntityStateResponse = answer(inlet, Outcome::Rejected(unknown));
    assert_eq!(response.result.result, Reply::NOT_FOUND);

    let delete = DeleteEntityRequest { entity: name };
    let expected = Command::RemoveObstacle {
        name: "table".into(),
    };
    assert_eq!(commands("/toile/delete_entity", &delete), [expected]);
    let closed = Rejected::NotAccepted {
        commands: "obstacles",
    };
    let response: DeleteEntityResponse = answer("/toile/delete_entity", Outcome::Rejected(closed));
    assert_eq!(response.result.result, Reply::FEATURE_UNSUPPORTED);
}

#[test]
fn an_entity_is_moved_by_what_is_set() {
    let inlet = "/toile/set_entity_state";
    let mut request = SetEntityStateRequest {
        entity: "table".into(),
        state: EntityState {
            pose: wire_pose([0.0; 3], LEFT),
            ..EntityState::default()
        },
        set_pose: true,
        ..SetEntityStateRequest::default()
    };
    let [Command::MoveObstacle { pose, velocity, .. }] = &commands(inlet, &request)[..] else {
        panic!("not a move");
    };
    assert!(pose.is_some() && velocity.is_none());
    request.state.pose.orientation.w = 9.0;
    let response: SetEntityStateResponse = answer(inlet, refused(inlet, &request));
    assert_eq!(response.result.result, SetEntityStateResponse::INVALID_POSE);
    request.set_pose = false;
    refusal(inlet, &request);
    request.set_acceleration = true;
    let response: SetEntityStateResponse = answer(inlet, refused(inlet, &request));
    assert_eq!(response.result.result, Reply::FEATURE_UNSUPPORTED);
}

pub fn spawn(text: &str) -> SpawnEntityRequest {
    SpawnEntityRequest {
        name: "ball".into(),
        entity_resource: Resource {
            resource_string: text.into(),
            ..Resource::default()
        },
        initial_pose: PoseStamped {
            pose: wire_pose([1.0, 0.0, 0.0], LEFT),
            ..PoseStamped::default()
        },
        ..SpawnEntityRequest::default()
    }
}

pub const BALL: &str =
    "shape = { kind = \"sphere\", radius = 0.05 }\nposition = [0.5, 0.0, 0.0]\nfriction = 0.3";

/// The description is in the entity's frame: a quarter turn brings its (0.5, 0, 0) to (0, 0.5, 0).
#[test]
fn an_entity_is_spawned_from_its_description() {
    let inlet = "/toile/spawn_entity";
    let [Command::AddObstacle(ball)] = &commands(inlet, &spawn(BALL))[..] else {
        panic!("not an obstacle");
    };
    assert_eq!((&ball.name[..], ball.friction), ("ball", 0.3));
    assert_eq!(ball.shape, Shape::Sphere { radius: 0.05 });
    assert!((ball.pose.translation.vector - Vector3::new(1.0, 0.5, 0.0)).norm() < 1e-15);
    let spawned = Outcome::Spawned {
        name: "ball".into(),
    };
    let response: SpawnEntityResponse = answer(inlet, spawned);
    assert_eq!(
        (response.result.result, &response.entity_name[..]),
        (Reply::OK, "ball")
    );
}

#[test]
fn a_spawned_entity_may_get_another_name() {
    let request = SpawnEntityRequest {
        allow_renaming: true,
        ..spawn(BALL)
    };
    let request = ask("/toile/spawn_entity", &request).expect("understood");
    let named = |name: &str| Obstacle {
        name: name.into(),
        ..table()
    };
    let name_among = |present: &[Obstacle]| match &request.commands(present)[..] {
        [Command::AddObstacle(added)] => added.name.clone(),
        other => panic!("{other:?}"),
    };
    assert_eq!(name_among(&[]), "ball");
    assert_eq!(name_among(&[named("ball")]), "ball_1");
    assert_eq!(name_among(&[named("ball"), named("ball_1")]), "ball_2");
}

#[test]
fn spawning_says_why_not() {
    type Codes = SpawnEntityResponse;
    let inlet = "/toile/spawn_entity";
    let with = |change: fn(&mut SpawnEntityRequest)| {
        let mut request = spawn(BALL);
        change(&mut request);
        let response: SpawnEntityResponse = answer(inlet, refused(inlet, &request));
        response.result.result
    };
    assert_eq!(with(|r| r.name = String::new()), Codes::NAME_INVALID);
    assert_eq!(
        with(|r| r.entity_resource.uri = "a.sdf".into()),
        Codes::UNSUPPORTED_FORMAT
    );
    assert_eq!(
        with(|r| r.entity_namespace = "/a".into()),
        Codes::NAMESPACE_INVALID
    );
    assert_eq!(
        with(|r| r.initial_pose.pose.orientation.w = 3.0),
        Codes::INVALID_POSE
    );
    for text in [
        "",
        "shape = 1",
        "<robot/>",
        "shape = { kind = \"sphere\", radius = 1e9 }",
    ] {
        let response: SpawnEntityResponse = answer(inlet, refused(inlet, &spawn(text)));
        assert_eq!(
            response.result.result,
            Codes::RESOURCE_PARSE_ERROR,
            "{text}"
        );
    }
    let taken = Rejected::NameTaken {
        name: "ball".into(),
    };
    let response: SpawnEntityResponse = answer(inlet, Outcome::Rejected(taken));
    assert_eq!(response.result.result, Codes::NAME_NOT_UNIQUE);
    assert!(response.result.error_message.contains("ball"));
}

#[test]
fn every_inlet_is_in_the_table_once_and_answers_if_it_is_a_service() {
    for (i, inlet) in inbound::ALL.iter().enumerate() {
        assert!(
            inbound::ALL[..i]
                .iter()
                .all(|other| other.name != inlet.name)
        );
        let is_service = inlet.kind == InletKind::Service;
        assert_eq!(
            (inlet.response.is_some(), inlet.service.is_some()),
            (is_service, is_service)
        );
        for outcome in [Outcome::Done, Outcome::Failed("why".into())] {
            let bytes = inbound::answer(inlet, &outcome).expect("encodes");
            assert_eq!(!bytes.is_empty(), is_service);
        }
    }
    assert_eq!(inbound::ALL.len(), 14);
}

#[test]
fn the_readme_describes_every_inlet() {
    let readme = read("README.md");
    for inlet in inbound::ALL {
        let kind = inlet.service.map_or(inlet.request.name, |s| s.name);
        let row = format!("| `{}` | `{kind}` |", inlet.name);
        assert!(readme.contains(&row), "README.md has no row {row}");
    }
}
