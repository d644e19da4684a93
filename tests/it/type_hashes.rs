//! Type hashes (REP 2011): pinned for every type, since a node of another hash does not match ours, and a recording
//! of another hash is of another type; and computed again by another implementation.

use serde_json::json;
use toile::wire::inbound;
use toile::wire::messages;

use crate::python;
use crate::tidy::read;

/// Name and hash of every type and service.
const PINNED: &str = "tests/references/type_hashes.csv";

/// Hashes as running ROS 2 systems printed them (`ros2 topic info -v`, Zenoh keys), found in public repositories.
const SEEN: [(&str, &str); 9] = [
    (
        "geometry_msgs/msg/Vector3Stamped",
        "d4829622288cbb443886e7ea94ea5671a3b1be6bab4ad04224432a65f7d7887a",
    ),
    (
        "geometry_msgs/msg/WrenchStamped",
        "8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77",
    ),
    (
        "nav_msgs/msg/Odometry",
        "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
    ),
    (
        "rcl_interfaces/msg/Log",
        "e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac",
    ),
    (
        "rosgraph_msgs/msg/Clock",
        "692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564",
    ),
    (
        "sensor_msgs/msg/PointCloud2",
        "9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5",
    ),
    (
        "std_msgs/msg/String",
        "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
    ),
    (
        "tf2_msgs/msg/TFMessage",
        "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    ),
    (
        "visualization_msgs/msg/MarkerArray",
        "86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf",
    ),
];
/// A service that is not one of ours, from the documentation of `rmw_zenoh`: services are hashed as ROS 2 does.
const CONTROL: (&str, &str) = (
    "example_interfaces/srv/AddTwoInts",
    "e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a",
);

/// Every type and service with its hash.
fn ours() -> Vec<(&'static str, &'static str)> {
    let types = messages::ALL.iter().map(|kind| (kind.name, kind.hash));
    let services = inbound::ALL.iter().filter_map(|inlet| inlet.service);
    let mut all: Vec<_> = types.chain(services.map(|s| (s.name, s.hash))).collect();
    all.sort_unstable();
    all
}

#[test]
fn regress_type_hashes() {
    let ours = ours();
    let rows: Vec<_> = ours
        .iter()
        .map(|(name, hash)| format!("{name},{hash}"))
        .collect();
    let pinned = read(PINNED);
    let pinned: Vec<_> = pinned.lines().collect();
    let new: Vec<_> = rows
        .iter()
        .filter(|row| !pinned.contains(&row.as_str()))
        .collect();
    assert!(new.is_empty(), "not in {PINNED}: {new:#?}");
    let old: Vec<_> = pinned
        .iter()
        .filter(|row| !rows.iter().any(|r| r == *row))
        .collect();
    assert!(old.is_empty(), "{PINNED} has rows of no type: {old:#?}");
}

#[test]
fn verify_type_hashes_are_those_of_another_implementation() {
    let types = messages::ALL
        .iter()
        .map(|kind| (kind.hash, json!({"name": kind.name, "schema": kind.schema})));
    let services = inbound::ALL.iter().filter_map(|inlet| inlet.service);
    let services = services.map(|service| {
        let (request, response) = (service.request.schema, service.response.schema);
        let line = json!({"name": service.name, "request": request, "response": response});
        (service.hash, line)
    });
    let control = json!({
        "name": CONTROL.0, "request": "int64 a\nint64 b\n", "response": "int64 sum\n",
    });
    let (hashes, lines): (Vec<_>, Vec<_>) = types
        .chain(services)
        .map(|(hash, line)| (hash.to_string(), line))
        .chain([(format!("RIHS01_{}", CONTROL.1), control)])
        .unzip();
    let answers = python::ask("rihs_peer.py", &lines);
    for ((hash, line), answer) in hashes.iter().zip(&lines).zip(answers) {
        assert_eq!(*hash, answer, "{}", line["name"]);
    }
}

#[test]
fn verify_type_hashes_are_those_that_ros_printed() {
    let ours = ours();
    for (name, hash) in SEEN {
        let hash = format!("RIHS01_{hash}");
        assert!(ours.contains(&(name, &hash)), "{name}");
    }
}
