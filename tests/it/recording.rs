//! A run through the real file and back.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use tempfile::TempDir;
use toile::node::{Memory, NodeError, Recording, RunOptions, Summary, run};
use toile::scene::Scene;
use toile::sim::Simulation;
use toile::wire::channels::{self, Rate};

/// A square over a table beside a moving ball, 20 steps of 5 ms.
const SCENE: &str = r#"
name = "two-obstacles"
description = "a square over a table beside a moving ball"
duration = 0.1
[sheet]
outline = { kind = "rectangle", length = 0.2, width = 0.2 }
triangles = 400
position = [0.0, 0.0, 0.001]
[fabric]
name = "F1"
[obstacle.table]
shape = { kind = "box", size = [0.1, 0.1, 0.1] }
position = [0.0, 0.0, -0.05]
friction = 0.3
[obstacle.ball]
shape = { kind = "sphere", radius = 0.02 }
position = [0.3, 0.0, 0.0]
[method]
dt = 0.005
[output]
rate = 100.0
mesh_rate = 25.0
[observe.corner]
points = [[0.1, 0.1]]
axis = "z"
"#;

pub fn scene() -> Scene {
    toml::from_str(SCENE).expect("the scene is well formed")
}

fn record(path: &Path) -> Summary {
    let options = RunOptions {
        output: Some(path.to_path_buf()),
        ..RunOptions::default()
    };
    run(&scene(), options, &mut |_| {}).expect("the run succeeds")
}

pub fn recorded() -> (TempDir, PathBuf) {
    let directory = TempDir::new().expect("a directory");
    let path = directory.path().join("run.mcap");
    record(&path);
    (directory, path)
}

#[test]
fn round_trip_through_the_file() {
    let (_directory, path) = recorded();
    let recording = Recording::open(&path).expect("opens");
    assert_eq!(recording.scene(), &scene());
    let mut simulation = Simulation::new(&scene(), 1).expect("a checked scene");
    assert_eq!(recording.faces(), simulation.model().mesh.faces);
    let times = recording.times();
    assert_eq!(times.len(), 11);
    for (index, time) in times.iter().enumerate() {
        assert!((time - 0.01 * index as f64).abs() < 1e-9);
        let frame = recording.frame(index).expect("every state is there");
        assert_eq!(frame.time, *time);
        for (read, true_position) in frame.positions.iter().zip(&simulation.state().positions) {
            assert_eq!(*read, true_position.map(|x| f64::from(x as f32)));
        }
        for (read, truth) in frame.obstacles.iter().zip(&simulation.state().obstacles) {
            assert_eq!((&read.name, &read.shape), (&truth.name, &truth.shape));
            assert!((read.pose.translation.vector - truth.pose.translation.vector).norm() < 1e-15);
            assert!(read.pose.rotation.angle_to(&truth.pose.rotation) < 1e-7);
        }
        assert_eq!(frame.obstacles.len(), 2);
        for _ in 0..2 {
            simulation.step().expect("steps");
        }
    }
}

#[test]
fn same_run_same_bytes() {
    let (_first, a) = recorded();
    let (_second, b) = recorded();
    assert!(fs::read(a).expect("read") == fs::read(b).expect("read"));
}

#[test]
fn every_carrier_gets_the_bytes_of_the_file() {
    let directory = TempDir::new().expect("a directory");
    let path = directory.path().join("run.mcap");
    let memory = Memory::default();
    let options = RunOptions {
        output: Some(path.clone()),
        carriers: vec![Box::new(memory.clone())],
        ..RunOptions::default()
    };
    run(&scene(), options, &mut |_| {}).expect("the run succeeds");
    let bytes = fs::read(&path).expect("read");
    let stream = mcap::MessageStream::new(&bytes).expect("an MCAP file");
    let read: Vec<_> = stream.map(|m| m.expect("a message")).collect();
    let packets = memory.packets();
    assert_eq!(read.len(), packets.len());
    for (message, packet) in read.iter().zip(&packets) {
        assert_eq!(message.channel.topic, packet.topic());
        assert_eq!(message.data, packet.bytes);
        assert_eq!(
            (message.log_time, message.publish_time),
            (packet.stamp, packet.stamp)
        );
    }
    for channel in channels::ALL {
        let count = packets
            .iter()
            .filter(|p| std::ptr::eq(p.channel, channel))
            .count();
        let expected = match channel.rate {
            // No obstacle is a mesh.
            Rate::Once if channel.topic == "/toile/obstacle_markers" => 0,
            Rate::Once => 1,
            // steps 0, 2, ... 20
            Rate::Output if channel.is_per_obstacle() => 11 * scene().obstacle.len(),
            Rate::Output => 11,
            Rate::Mesh => 4, // steps 0, 8, 16, and the last
            Rate::Second => 1,
            // The sheet falls on the table after the first two outputs, and lifts off at one of the other nine.
            Rate::Event if channel.topic == "/toile/contacts" => 8,
            Rate::Event | Rate::Keyframe => 0,
        };
        assert_eq!(count, expected, "{}", channel.topic);
    }
}

#[test]
fn stop_flag_closes_the_file_and_keeps_the_last_state() {
    let directory = TempDir::new().expect("a directory");
    let path = directory.path().join("run.mcap");
    let stop = Arc::new(AtomicBool::new(false));
    let options = RunOptions {
        output: Some(path.clone()),
        stop: stop.clone(),
        ..RunOptions::default()
    };
    let summary = run(&scene(), options, &mut |progress| {
        stop.store(progress.step == 7, Ordering::Relaxed);
    });
    let summary = summary.expect("a stopped run is no error");
    assert!(summary.stopped && summary.steps == 7);
    assert_whole(&path);
    let times = Recording::open(&path).expect("opens").times();
    assert_eq!(times.last(), Some(&0.035));
}

/// The file has an index, and its checksums are right.
pub fn assert_whole(path: &Path) {
    let bytes = fs::read(path).expect("read");
    let summary = mcap::Summary::read(&bytes)
        .expect("readable")
        .expect("has a summary");
    let stats = summary.stats.expect("statistics");
    let stream = mcap::MessageStream::new(&bytes).expect("an MCAP file");
    let messages: Vec<_> = stream.map(|m| m.expect("an undamaged message")).collect();
    assert_eq!(stats.message_count, messages.len() as u64);
}

pub fn error_of(path: &Path) -> NodeError {
    let options = RunOptions {
        output: Some(path.to_path_buf()),
        ..RunOptions::default()
    };
    run(&scene(), options, &mut |_| {}).expect_err("the run fails")
}

#[test]
fn paths_that_cannot_be_written_say_so() {
    let directory = TempDir::new().expect("a directory");
    let file = directory.path().join("file");
    fs::write(&file, "mine").expect("write");
    let taken = directory.path().join("directory.mcap");
    fs::create_dir(&taken).expect("create");
    for path in [file.join("run.mcap"), taken] {
        let error = error_of(&path);
        assert!(matches!(error, NodeError::File { .. }), "{error}");
        let parent = path.parent().expect("has one").display().to_string();
        assert!(error.to_string().contains(&parent), "{error}");
    }
    assert_eq!(fs::read_to_string(&file).expect("read"), "mine");
    let missing = Recording::open(&directory.path().join("none.mcap")).map(|_| ());
    assert!(
        missing
            .expect_err("missing")
            .to_string()
            .contains("none.mcap")
    );
    let foreign = Recording::open(&file).map(|_| ()).expect_err("not MCAP");
    assert!(matches!(foreign, NodeError::Unreadable { .. }), "{foreign}");
}

#[test]
fn a_directory_of_other_things_is_not_made_a_bag() {
    let directory = TempDir::new().expect("a directory");
    let mine = directory.path().join("mine");
    fs::create_dir(&mine).expect("create");
    record(&mine);
    record(&mine);
    let error = error_of(directory.path());
    assert!(error.to_string().contains("holds other files"), "{error}");
    assert_eq!(directory.path().read_dir().expect("list").count(), 1);
}

#[test]
fn a_bag_directory_has_metadata_that_agrees() {
    let directory = TempDir::new().expect("a directory");
    let bag = directory.path().join("drape");
    let summary = record(&bag);
    assert_eq!(summary.recording, Some(bag.join("drape_0.mcap")));
    let yaml = fs::read_to_string(bag.join("metadata.yaml")).expect("read");
    for line in [
        "  version: 5\n",
        "nanoseconds: 100000000\n",
        "    - drape_0.mcap\n",
    ] {
        assert!(yaml.contains(line), "{line:?} not in {yaml}");
    }
    let bytes = fs::read(bag.join("drape_0.mcap")).expect("read");
    let messages = mcap::MessageStream::new(&bytes)
        .expect("an MCAP file")
        .count();
    assert!(yaml.contains(&format!("  message_count: {messages}\n")));
    assert_eq!(Recording::open(&bag).expect("opens").times().len(), 11);
}

#[test]
fn viewer_assets_are_written() {
    let directory = TempDir::new().expect("a directory");
    let target = directory.path().join("layouts");
    let [blueprint, layout] = toile::node::viewers::write(&target).expect("written");
    assert!(fs::read(blueprint).expect("read").starts_with(b"RRF"));
    let layout = fs::read_to_string(layout).expect("read");
    let layout: serde_json::Value = serde_json::from_str(&layout).expect("JSON");
    let topics = layout["configById"]["3D!toile"]["topics"]
        .as_object()
        .expect("topics");
    for topic in topics.keys() {
        assert!(
            channels::ALL.iter().any(|c| c.topic == topic),
            "{topic} is not published"
        );
    }
}
