//! What a peer sees that shares no code with toile.

use std::collections::BTreeMap;
use std::process::{Command, Stdio};

use serde_json::Value;
use toile::wire::channels::{self, Channel};
use toile::wire::inbound::{self, InletKind};
use toile::wire::messages::geometry_msgs::Vector3Stamped;
use toile::wire::messages::nav_msgs::Odometry;
use toile::wire::messages::tf2_msgs::TFMessage;
use toile::wire::messages::toile_msgs::{AppliedCommand, MeshTopology};

use super::rig::{Rig, SCENE, Talk, output, recorded};

/// Best effort may lose a state when the machine is busy with other things: one of so many listeners in a row must
/// have got them all.
const TRIES: usize = 3;

#[test]
fn a_foreign_listener_gets_every_state_and_what_was_said_before_it_came() {
    let mut rig = Rig::start(SCENE, &["--pace", "real"]);
    let listen = || {
        let mut peer = rig.peer("dds_peer.py", 60);
        let said = peer.args(["listen", "--seconds", "10"]).output().unwrap();
        String::from_utf8_lossy(&said.stdout).into_owned()
    };
    let heard: Vec<_> = (0..TRIES)
        .map(|_| listen())
        .take_while_inclusive(|said| !whole(said))
        .collect();
    assert!(heard.iter().any(|said| whole(said)), "{heard:?}");
    let topology = output(rig.peer("ros2_peer.py", 60).arg("topology"));
    let (summary, _) = rig.stop();
    let mesh: &MeshTopology = &recorded(&rig.recording(), "/toile/topology")[0];
    let topology: Value = serde_json::from_str(&topology).unwrap();
    assert_eq!(topology["vertices"], mesh.material.len() / 2);
    assert_eq!(topology["triangles"], mesh.triangles.len() / 3);
    assert_eq!(summary["bridge"]["restarts"], 0, "{summary}");
}

/// `states 1001 gaps 0 clock 1000 robot_description 512 characters`
fn whole(said: &str) -> bool {
    let words: Vec<_> = said.split_whitespace().collect();
    let number = |name: &str| -> usize {
        let at = words.iter().position(|word| *word == name);
        at.and_then(|at| words.get(at + 1)?.parse().ok())
            .unwrap_or(0)
    };
    let gaps = words.contains(&"gaps") && number("gaps") == 0;
    // Of 1,000 in ten seconds, less what passes while the peer is still looking for the run.
    gaps && number("states") > 800 && number("clock") > 800 && number("robot_description") > 0
}

/// The elements up to the first one that does not hold, and that one.
trait TakeWhileInclusive: Iterator + Sized {
    fn take_while_inclusive(
        self,
        holds: impl Fn(&Self::Item) -> bool,
    ) -> impl Iterator<Item = Self::Item> {
        let mut over = false;
        self.map_while(move |item| {
            if over {
                return None;
            }
            over = !holds(&item);
            Some(item)
        })
    }
}
impl<I: Iterator> TakeWhileInclusive for I {}

#[test]
fn commands_of_a_foreign_peer_take_effect_and_are_told_to_all() {
    let windy = SCENE.replace("[method]", "[air]\nfluid_damping = 1.0\n[method]");
    let mut rig = Rig::start(&windy, &["--pace", "real"]);
    let mut applied = Talk::with(rig.peer("ros2_peer.py", 90).args(["applied", "3"]));
    assert_eq!(applied.line(), "ready");
    let send = |arguments: &[&str]| output(rig.peer("dds_peer.py", 60).args(arguments));
    send(&["wind", "0", "0", "0.5"]);
    let wind = applied.json();
    send(&["move", "table", "0.25", "0", "-0.5"]);
    let moved = applied.json();
    send(&["move", "nobody", "0", "0", "0"]);
    let refused = applied.json();
    applied.end();
    let (_, _) = rig.stop();
    for (told, channel, accepted) in [
        (&wind, "/toile/cmd/wind", true),
        (&moved, "/toile/cmd/obstacle_odometry", true),
        (&refused, "/toile/cmd/obstacle_odometry", false),
    ] {
        assert_eq!(
            (&told["channel"], &told["accepted"]),
            (&channel.into(), &accepted.into()),
            "{told}"
        );
    }
    assert!(
        refused["reason"].as_str().unwrap().contains("nobody"),
        "{refused}"
    );
    // What was told is what was recorded, byte for byte, and what the peer sent.
    let in_recording: Vec<AppliedCommand> = recorded(&rig.recording(), "/toile/applied");
    assert_eq!(in_recording.len(), 3);
    for (told, kept) in [&wind, &moved, &refused].into_iter().zip(&in_recording) {
        let bytes: String = kept
            .payload
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect();
        assert_eq!(told["payload"], bytes);
        assert_eq!(told["step"], kept.step);
    }
    let wind: Vector3Stamped = toile::wire::cdr::decode(&in_recording[0].payload).unwrap();
    assert_eq!(
        (wind.header.frame_id.as_str(), wind.vector.z),
        ("world", 0.5)
    );
    let odometry: Odometry = toile::wire::cdr::decode(&in_recording[1].payload).unwrap();
    assert_eq!(odometry.child_frame_id, "table");
    // The table is where it was told to be, from the next state on and no sooner.
    let moved = in_recording[1].step;
    for (k, frames) in recorded::<TFMessage>(&rig.recording(), "/tf")
        .iter()
        .enumerate()
    {
        let at = &frames.transforms[0].transform.translation;
        let expected = if 2 * k as u64 > moved {
            (0.25, -0.5)
        } else {
            (0.0, -0.05)
        };
        assert_eq!(
            (at.x, at.z),
            expected,
            "state {k}, moved after step {moved}"
        );
    }
}

#[test]
fn the_graph_shows_the_node_with_all_its_topics_and_types() {
    let mut rig = Rig::start(
        SCENE,
        &[
            "--pace",
            "real",
            "--node-name",
            "cloth",
            "--namespace",
            "/cell",
        ],
    );
    let graph = output(rig.peer("ros2_peer.py", 60).args(["graph", "cloth"]));
    let graph: Value = serde_json::from_str(&graph).unwrap();
    rig.stop();
    assert_eq!(graph["namespace"], "/cell");
    let names = |side: &str| -> BTreeMap<String, String> {
        serde_json::from_value(graph[side].clone()).unwrap()
    };
    let (published, subscribed) = (names("publishers"), names("subscribers"));
    let placed = |name: &str| match name.strip_prefix("/toile/") {
        Some(rest) => format!("/cell/toile/{rest}"),
        None => name.to_string(),
    };
    let mangled = |ros: &str| match ros.split('/').collect::<Vec<_>>()[..] {
        [package, kind, name] => format!("{package}::{kind}::dds_::{name}_"),
        _ => panic!("{ros}"),
    };
    for channel in channels::ALL {
        let name = channel.topic.replace(channels::OBSTACLE, "table");
        let topic = format!("rt{}", placed(&name));
        let Channel { message, .. } = channel;
        assert_eq!(
            published.get(&topic),
            Some(&mangled(message.name)),
            "{topic}"
        );
    }
    for inlet in inbound::ALL {
        let name = placed(inlet.name);
        let (topic, answer) = match inlet.kind {
            InletKind::Topic => (format!("rt{name}"), None),
            InletKind::Service => (format!("rq{name}Request"), Some(format!("rr{name}Reply"))),
        };
        assert_eq!(
            subscribed.get(&topic),
            Some(&mangled(inlet.request.name)),
            "{topic}"
        );
        if let (Some(answer), Some(response)) = (answer, inlet.response) {
            assert_eq!(
                published.get(&answer),
                Some(&mangled(response.name)),
                "{answer}"
            );
        }
    }
}

#[test]
fn the_command_line_reaches_a_run_over_ros_2() {
    let windy = SCENE.replace("[method]", "[air]\nfluid_damping = 1.0\n[method]");
    let mut rig = Rig::start(&windy, &["--pace", "real"]);
    let toile = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_toile"));
        command.args(arguments).arg("--ros2").stdin(Stdio::null());
        command.env("ROS_DOMAIN_ID", rig.domain.to_string());
        let output = command.output().unwrap();
        let said = [output.stdout, output.stderr].concat();
        (output.status.code(), String::from_utf8(said).unwrap())
    };
    let (code, said) = toile(&[
        "send",
        "obstacle",
        "move",
        "table",
        "--position",
        "0.25,0,-0.5",
    ]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.starts_with("applied after step "), "{said}");
    let (code, said) = toile(&["send", "obstacle", "remove", "nobody"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("nobody"), "{said}");
    let (code, said) = toile(&["watch", "tf", "--count", "3", "--full"]);
    assert_eq!(code, Some(0), "{said}");
    let lines: Vec<Value> = said
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok())
        .collect();
    assert_eq!(lines.len(), 3, "{said}");
    for line in &lines {
        let transform = &line["message"]["transforms"][0];
        assert_eq!(transform["transform"]["translation"]["z"], -0.5, "{line}");
        let stamp = &transform["header"]["stamp"];
        let seconds = stamp["sec"].as_f64().unwrap() + 1e-9 * stamp["nanosec"].as_f64().unwrap();
        assert!(
            (line["time"].as_f64().unwrap() - seconds).abs() < 1e-6,
            "{line}"
        );
    }
    assert_eq!(
        toile(&["send", "state"]),
        (Some(0), "playing\n".to_string())
    );
    let (code, said) = toile(&["send", "quit"]);
    assert_eq!(code, Some(0), "{said}");
    let (summary, errors) = rig.finish();
    assert_eq!(summary["bridge"]["restarts"], 0, "{summary} {errors}");
}
