//! Message structs against their definitions: an independent reader follows the schema text through the bytes
//! that the structs encode to.

use toile::wire::messages::{
    self, builtin_interfaces::Time, geometry_msgs, sensor_msgs, std_msgs, tf2_msgs, toile_msgs,
    visualization_msgs,
};
use toile::wire::{Message, cdr, channels};

use crate::schema_reader::{parse, walk};

/// Paths of all values in a struct, as serde sees them.
fn serde_fields<M: Message>(message: &M) -> Vec<String> {
    fn leaves(value: &serde_json::Value, path: &str, out: &mut Vec<String>) {
        match value {
            serde_json::Value::Object(map) => {
                map.iter()
                    .for_each(|(k, v)| leaves(v, &format!("{path}.{k}"), out));
            }
            serde_json::Value::Array(items) => {
                let items = items.iter().enumerate();
                items.for_each(|(i, v)| leaves(v, &format!("{path}[{i}]"), out));
            }
            _ => out.push(path.to_string()),
        }
    }
    let mut out = vec![];
    leaves(&serde_json::to_value(message).expect("json"), "", &mut out);
    out.sort();
    out
}

fn assert_mirrors<M: Message + PartialEq + std::fmt::Debug>(message: &M) {
    let seen = walk(message);
    let mut names: Vec<_> = seen
        .iter()
        .map(|s| s.split(" = ").next().unwrap_or_default())
        .collect();
    names.sort_unstable();
    assert_eq!(names, serde_fields(message), "{}", M::TYPE.name);
    let bytes = cdr::encode(message).expect("encodes");
    assert_eq!(cdr::decode::<M>(&bytes).as_ref(), Ok(message));
}

fn header() -> std_msgs::Header {
    std_msgs::Header {
        stamp: Time { sec: 3, nanosec: 7 },
        frame_id: "world".into(),
    }
}

pub fn sample_report() -> toile_msgs::StepReport {
    toile_msgs::StepReport {
        header: header(),
        step: 5,
        time: 0.25,
        dt: 0.05,
        energies: toile_msgs::Energies {
            kinetic: 1.5,
            supports: -2.0,
            ..Default::default()
        },
        work: toile_msgs::Work {
            substeps: 1,
            halvings: 9,
            ..Default::default()
        },
        converged: true,
        contacts: 4,
        digest: 0x0123_4567_89ab_cdef,
        neglect_flags: vec!["drag".into()],
        reading_names: vec!["corner".into(), "tip".into()],
        reading_values: vec![-0.042, 0.5],
        overruns: 6,
        malformed_commands: 2,
        ..Default::default()
    }
}

#[test]
fn structs_mirror_their_definitions() {
    assert_mirrors(&sample_report());
    assert_mirrors(&toile_msgs::MeshTopology {
        header: header(),
        triangles: vec![0, 1, 2],
        outline: vec![0.0, 0.5, 1.0],
        material: vec![0.25],
    });
    assert_mirrors(&sensor_msgs::PointCloud2 {
        header: header(),
        fields: vec![sensor_msgs::PointField {
            name: "x".into(),
            count: 1,
            ..Default::default()
        }],
        data: vec![1, 2, 3],
        width: 9,
        ..Default::default()
    });
    assert_mirrors(&visualization_msgs::MarkerArray {
        markers: vec![visualization_msgs::Marker {
            points: vec![
                geometry_msgs::Point {
                    x: 1.0,
                    y: 2.0,
                    z: 3.0
                };
                2
            ],
            colors: vec![std_msgs::ColorRGBA::default()],
            text: "text".into(),
            ..Default::default()
        }],
    });
    assert_mirrors(&tf2_msgs::TFMessage {
        transforms: vec![geometry_msgs::TransformStamped {
            child_frame_id: "table".into(),
            ..Default::default()
        }],
    });
    assert_mirrors(&messages::rosgraph_msgs::Clock {
        clock: Time { sec: 1, nanosec: 2 },
    });
    assert_mirrors(&std_msgs::String {
        data: "text".into(),
    });
}

#[test]
fn an_independent_reader_sees_the_values() {
    let seen = walk(&sample_report());
    for expected in [
        ".header.stamp.nanosec = 7",
        ".energies.supports = -2",
        ".work.halvings = 9",
        ".converged = 1",
        ".digest = 81985529216486895",
        ".reading_names[1] = tip",
        ".reading_values[0] = -0.042",
    ] {
        assert!(
            seen.iter().any(|s| s == expected),
            "{expected} not in {seen:#?}"
        );
    }
}

#[test]
fn every_schema_is_complete_and_every_field_of_ours_has_a_unit() {
    for message in messages::ALL {
        let (root, definitions) = parse(message.name, message.schema);
        // Some services ask nothing.
        let may_be_empty = root.ends_with("_Request");
        let is_empty = definitions[&root].is_empty();
        assert!(may_be_empty || !is_empty, "{root} has no fields");
        assert!(message.hash.starts_with("RIHS01_") && message.hash.len() == 71);
        if root.starts_with("toile_msgs") {
            let own = message.schema.split("====").next().unwrap_or_default();
            let is_constant = |l: &str| l.split('#').next().is_some_and(|code| code.contains('='));
            let fields = own
                .lines()
                .filter(|l| !l.trim().is_empty() && !l.starts_with('#') && !is_constant(l));
            for line in fields {
                let comment = line.split_once('#').map(|(_, c)| c).unwrap_or_default();
                let has_unit = comment.contains('[') && comment.contains(']');
                let described_elsewhere = line.starts_with("std_msgs/Header");
                assert!(has_unit || described_elsewhere, "no unit in {root}: {line}");
            }
        }
    }
}

#[test]
fn cmake_lists_every_message() {
    let root = env!("CARGO_MANIFEST_DIR");
    let cmake = std::fs::read_to_string(format!("{root}/msgs/CMakeLists.txt")).expect("read");
    for file in std::fs::read_dir(format!("{root}/msgs/msg")).expect("list") {
        let name = file
            .expect("entry")
            .file_name()
            .into_string()
            .expect("UTF-8");
        assert!(
            cmake.contains(&format!("\"msg/{name}\"")),
            "{name} is not in CMakeLists.txt"
        );
    }
}

#[test]
fn channels_are_unique_and_typed() {
    for (i, channel) in channels::ALL.iter().enumerate() {
        assert!(channels::ALL[..i].iter().all(|c| c.topic != channel.topic));
        assert!(messages::ALL.contains(&channel.message));
        assert!(channel.qos.offered_profiles().starts_with("- history: 1\n"));
    }
}
