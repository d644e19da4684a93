//! The standard verbs of simulators as ROS 2 services, in both mappings.

use std::net::Ipv4Addr;
use std::time::Duration;

use ros2_client::dds::rustdds::DomainParticipantBuilder;
use ros2_client::{
    Client, Context, Message, Name, Node, NodeName, NodeOptions, QosProfile, ServiceMapping,
    ServiceTypeName,
};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use toile::node::ros2::Peer;
use toile::wire::cdr;
use toile::wire::inbound;
use toile::wire::messages::simulation_interfaces::{
    GetSimulationStateResponse, SimulationState, StepSimulationRequest, StepSimulationResponse,
};

use super::rig::{PATIENCE, Rig, SCENE, output, wait};

#[derive(Clone, Debug, Serialize, Deserialize)]
struct Empty {
    structure_needs_at_least_one_member: u8,
}
#[derive(Clone, Debug, Serialize, Deserialize)]
struct State {
    state: u8,
}
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Steps {
    steps: u64,
}
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Outcome {
    result: u8,
    message: String,
}
#[derive(Clone, Debug, Serialize, Deserialize)]
struct StateAndOutcome {
    state: u8,
    outcome: Outcome,
}
impl Message for Empty {}
impl Message for State {}
impl Message for Steps {}
impl Message for Outcome {}
impl Message for StateAndOutcome {}

const OK: u8 = 1;
const PLAYING: u8 = 1;
const PAUSED: u8 = 2;

/// A client of ros2-client, whose services are not those of the bridge.
struct Caller {
    node: Node,
}

impl Caller {
    fn on(domain: u16) -> Self {
        let builder = DomainParticipantBuilder::new(domain);
        let participant = builder.with_only_networks([Ipv4Addr::LOCALHOST]).build();
        let context = Context::from_domain_participant(participant.unwrap()).unwrap();
        let name = NodeName::new("/", "caller").unwrap();
        let options = NodeOptions::new().enable_rosout(false);
        let node = context.new_node(name, options).unwrap();
        Self { node }
    }

    /// One call. A request that is sent before the server is known goes nowhere, so it is sent again.
    fn call<Q, A>(&mut self, service: &str, kind: &str, request: &Q) -> A
    where
        Q: Message + Clone + 'static,
        A: Message + 'static,
    {
        let qos = QosProfile::publisher_default();
        let name = Name::new("/toile", service).unwrap();
        let kind = ServiceTypeName::new("simulation_interfaces", kind);
        let client: Client<Q, A> = self
            .node
            .create_client(ServiceMapping::Enhanced, &name, &kind, qos.clone(), qos)
            .unwrap();
        wait(service, || {
            let sent = client.send_request(request.clone()).ok()?;
            for _ in 0..200 {
                match client.receive_response() {
                    Ok(Some((id, answer))) if id == sent => return Some(answer),
                    _ => std::thread::sleep(Duration::from_millis(10)),
                }
            }
            None
        })
    }
}

#[test]
fn the_verbs_of_simulators_work_as_services() {
    let mut rig = Rig::start(SCENE, &["--pace", "real"]);
    let mut caller = Caller::on(rig.domain);
    let asked = Empty {
        structure_needs_at_least_one_member: 0,
    };
    let state = |caller: &mut Caller| -> u8 {
        let answer: StateAndOutcome =
            caller.call("get_simulation_state", "GetSimulationState", &asked);
        assert_eq!(answer.outcome.result, OK);
        answer.state
    };
    assert_eq!(state(&mut caller), PLAYING);
    let pause = State { state: PAUSED };
    let outcome: Outcome = caller.call("set_simulation_state", "SetSimulationState", &pause);
    assert!(outcome.result == OK || outcome.result == 101, "{outcome:?}");
    assert_eq!(state(&mut caller), PAUSED);
    let outcome: Outcome = caller.call("step_simulation", "StepSimulation", &Steps { steps: 7 });
    assert_eq!((outcome.result, outcome.message.as_str()), (OK, ""));
    assert_eq!(state(&mut caller), PAUSED);
    // The client of the command line speaks the same.
    let mut peer = Peer::join(rig.settings()).unwrap();
    let inlet = inbound::find("/toile/get_simulation_state").unwrap();
    let request = cdr::encode(
        &toile::wire::messages::simulation_interfaces::GetSimulationStateRequest::default(),
    );
    let answer = peer
        .send(inlet, &request.unwrap(), PATIENCE)
        .unwrap()
        .unwrap();
    let answer: GetSimulationStateResponse = cdr::decode(&answer).unwrap();
    assert_eq!(answer.state.state, SimulationState::STATE_PAUSED);
    let (summary, _) = rig.stop();
    let traffic = &summary["bridge"]["traffic"];
    assert_eq!(traffic["answered"], traffic["received"], "{summary}");
}

#[test]
fn services_in_the_mapping_of_cyclone_answer_a_foreign_client() {
    let arguments = ["--pace", "lockstep", "--service-mapping", "cyclone"];
    let mut rig = Rig::start(SCENE, &arguments);
    let ask = |arguments: &[&str]| -> Value {
        let said = output(rig.peer("ros2_peer.py", 60).args(arguments));
        serde_json::from_str(&said).unwrap()
    };
    let state = ask(&["state"]);
    assert_eq!(
        (&state["state"], &state["result"]),
        (&PAUSED.into(), &OK.into())
    );
    let stepped = ask(&["step", "12"]);
    assert_eq!(
        (&stepped["result"], &stepped["message"]),
        (&OK.into(), &"".into())
    );
    let mut settings = rig.settings();
    settings.services = toile::node::ros2::ServiceMapping::Cyclone;
    let mut peer = Peer::join(settings).unwrap();
    let inlet = inbound::find("/toile/step_simulation").unwrap();
    let request = cdr::encode(&StepSimulationRequest { steps: 3 }).unwrap();
    let answer = peer.send(inlet, &request, PATIENCE).unwrap().unwrap();
    let answer: StepSimulationResponse = cdr::decode(&answer).unwrap();
    assert_eq!(answer.result.result, OK);
    let (summary, _) = rig.stop();
    assert_eq!(summary["steps"], 15, "{summary}");
}
