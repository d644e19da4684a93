//! Our bytes against another vendor's: for every type that crosses the border of the node, Cyclone DDS serialises
//! the same values from the schema text alone.

use std::collections::BTreeSet;

use serde_json::{Value, json};
use toile::wire::messages::simulation_interfaces as verbs;
use toile::wire::messages::{
    diagnostic_msgs, geometry_msgs, moveit_msgs, nav_msgs, rcl_interfaces, rosgraph_msgs,
    sensor_msgs, std_msgs, tf2_msgs, toile_msgs, visualization_msgs,
};
use toile::wire::{Message, cdr, channels, inbound};

use crate::python;
use crate::samples::sample;

/// Values of each type.
const SAMPLES: u64 = 8;

/// A value of a type as both sides know it.
struct Case {
    name: &'static str,
    line: Value,
    /// Whether big-endian bytes of the other side decode to the value.
    reads: fn(u64, &[u8]) -> bool,
    seed: u64,
}

fn cases<M: Message + PartialEq>() -> Vec<Case> {
    let case = |seed| {
        let value: M = sample(seed);
        let bytes = cdr::encode(&value).expect("encodes");
        let line = json!({
            "name": M::TYPE.name, "schema": M::TYPE.schema, "value": value, "cdr": hex(&bytes),
        });
        Case {
            name: M::TYPE.name,
            line,
            reads: |seed, bytes| cdr::decode::<M>(bytes) == Ok(sample(seed)),
            seed,
        }
    };
    (0..SAMPLES).map(case).collect()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

fn unhex(text: &str) -> Vec<u8> {
    let (pairs, _) = text.as_bytes().as_chunks::<2>();
    let digits = pairs.iter().map(|p| std::str::from_utf8(p).expect("ASCII"));
    digits
        .map(|d| u8::from_str_radix(d, 16).expect("hexadecimal"))
        .collect()
}

macro_rules! every {
    ($($kind:ty),* $(,)?) => { [$(cases::<$kind>()),*].into_iter().flatten().collect() };
}

fn all() -> Vec<Case> {
    every![
        diagnostic_msgs::DiagnosticArray,
        geometry_msgs::Vector3Stamped,
        geometry_msgs::WrenchStamped,
        moveit_msgs::CollisionObject,
        nav_msgs::Odometry,
        rcl_interfaces::Log,
        rosgraph_msgs::Clock,
        sensor_msgs::PointCloud2,
        std_msgs::String,
        tf2_msgs::TFMessage,
        toile_msgs::AirflowCommand,
        toile_msgs::AppliedCommand,
        toile_msgs::ContactEvents,
        toile_msgs::Keyframe,
        toile_msgs::MeshTopology,
        toile_msgs::ObstacleCommand,
        toile_msgs::StepReport,
        visualization_msgs::MarkerArray,
        verbs::DeleteEntityRequest,
        verbs::DeleteEntityResponse,
        verbs::GetEntityStateRequest,
        verbs::GetEntityStateResponse,
        verbs::GetSimulationStateRequest,
        verbs::GetSimulationStateResponse,
        verbs::GetSimulatorFeaturesRequest,
        verbs::GetSimulatorFeaturesResponse,
        verbs::ResetSimulationRequest,
        verbs::ResetSimulationResponse,
        verbs::SetEntityStateRequest,
        verbs::SetEntityStateResponse,
        verbs::SetSimulationStateRequest,
        verbs::SetSimulationStateResponse,
        verbs::SpawnEntityRequest,
        verbs::SpawnEntityResponse,
        verbs::StepSimulationRequest,
        verbs::StepSimulationResponse,
    ]
}

#[test]
fn every_type_that_crosses_the_border_is_compared() {
    let compared: BTreeSet<_> = all().iter().map(|case| case.name).collect();
    let out = channels::ALL.iter().map(|channel| channel.message.name);
    let asked = inbound::ALL.iter().map(|inlet| inlet.request.name);
    let answered = inbound::ALL.iter().filter_map(|inlet| inlet.response);
    for name in out.chain(asked).chain(answered.map(|r| r.name)) {
        assert!(compared.contains(name), "{name} is not compared");
    }
}

#[test]
fn verify_bytes_are_those_of_cyclone_dds() {
    let cases = all();
    let lines: Vec<_> = cases.iter().map(|case| case.line.clone()).collect();
    let answers = python::ask("cdr_peer.py", &lines);
    for (case, answer) in cases.iter().zip(answers) {
        let answer: Value = serde_json::from_str(&answer).expect("JSON");
        let name = case.name;
        let (ours, theirs) = (&case.line["cdr"], &answer["cyclone"]);
        assert!(answer["same"] == true, "{name}: {ours}, Cyclone {theirs}");
        assert!(
            answer["back"] == true,
            "{name}: Cyclone reads another value"
        );
        let big = unhex(answer["big_endian"].as_str().expect("text"));
        assert_eq!(&big[..4], [0, 0, 0, 0]);
        assert!((case.reads)(case.seed, &big), "{name}: big-endian");
    }
}

/// The comparison sees a single byte.
#[test]
fn a_changed_byte_is_seen() {
    let [case, ..] = &mut cases::<nav_msgs::Odometry>()[..] else {
        panic!("no case");
    };
    let mut bytes = unhex(case.line["cdr"].as_str().expect("text"));
    *bytes.last_mut().expect("a byte") ^= 1;
    case.line["cdr"] = hex(&bytes).into();
    let answers = python::ask("cdr_peer.py", std::slice::from_ref(&case.line));
    let answer: Value = serde_json::from_str(&answers[0]).expect("JSON");
    assert!(answer["same"] == false && answer["back"] == false);
}
