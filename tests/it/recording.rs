//! A run through the real file and back: what is recorded can be read, whole, cut short, or on a bad disk.

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use tempfile::TempDir;
use toile::node::{Memory, NodeError, Recording, RunOptions, Summary, run, seal};
use toile::scene::Scene;
use toile::sim::Simulation;
use toile::wire::channels::{self, Rate};
use toile::wire::messages::sensor_msgs::PointCloud2;
use toile::wire::{cloud, markers};

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

fn scene() -> Scene {
    toml::from_str(SCENE).expect("the scene is well formed")
}

fn record(path: &Path) -> Summary {
    let options = RunOptions {
        output: Some(path.to_path_buf()),
        ..RunOptions::default()
    };
    run(&scene(), options, &mut |_| {}).expect("the run succeeds")
}

fn recorded() -> (TempDir, PathBuf) {
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

/// The simulation of the scene after some steps.
fn stepped(steps: usize) -> Simulation {
    let mut simulation = Simulation::new(&scene(), 1).expect("a checked scene");
    for _ in 0..steps {
        simulation.step().expect("steps");
    }
    simulation
}

/// FLOAT32 value of a named field of a point, read as a viewer does: by the field table.
fn value(cloud: &PointCloud2, point: usize, name: &str) -> f32 {
    let field = cloud
        .fields
        .iter()
        .find(|f| f.name == name)
        .expect("the field");
    assert_eq!((field.datatype, field.count), (7, 1));
    let at = point * cloud.point_step as usize + field.offset as usize;
    f32::from_le_bytes(cloud.data[at..at + 4].try_into().expect("4 bytes"))
}

#[test]
fn cloud_holds_positions_and_velocities_by_its_field_table() {
    let simulation = stepped(3);
    let state = simulation.state();
    let cloud = cloud::encode(state, 0.015);
    assert_eq!(cloud.header.frame_id, "world");
    assert_eq!(
        (cloud.header.stamp.sec, cloud.header.stamp.nanosec),
        (0, 15_000_000)
    );
    assert_eq!(
        (cloud.height, cloud.width as usize),
        (1, state.positions.len())
    );
    assert_eq!(cloud.data.len(), cloud.row_step as usize);
    for (i, (x, v)) in state.positions.iter().zip(&state.velocities).enumerate() {
        let read = ["x", "y", "z", "vx", "vy", "vz"].map(|name| value(&cloud, i, name));
        let truth = [x.x, x.y, x.z, v.x, v.y, v.z].map(|c| c as f32);
        assert_eq!(read, truth, "vertex {i}");
    }
}

#[test]
fn surface_runs_through_the_vertices_in_face_order() {
    let simulation = stepped(3);
    let (mesh, positions) = (&simulation.model().mesh, &simulation.state().positions);
    let surface = markers(mesh, positions, 0.015);
    let [marker] = &surface.markers[..] else {
        panic!("one marker");
    };
    assert_eq!(
        (marker.r#type, marker.header.frame_id.as_str()),
        (11, "world")
    );
    assert_eq!(marker.points.len(), 3 * mesh.faces.len());
    for (point, vertex) in marker.points.iter().zip(mesh.faces.iter().flatten()) {
        let truth = positions[*vertex as usize].map(|c| f64::from(c as f32));
        assert_eq!([point.x, point.y, point.z], [truth.x, truth.y, truth.z]);
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
        assert_eq!(message.channel.topic, packet.channel.topic);
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
            Rate::Once => 1,
            Rate::Output => 11, // steps 0, 2, ... 20
            Rate::Mesh => 4,    // steps 0, 8, 16, and the last
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
fn assert_whole(path: &Path) {
    let bytes = fs::read(path).expect("read");
    let summary = mcap::Summary::read(&bytes)
        .expect("readable")
        .expect("has a summary");
    let stats = summary.stats.expect("statistics");
    let stream = mcap::MessageStream::new(&bytes).expect("an MCAP file");
    let messages: Vec<_> = stream.map(|m| m.expect("an undamaged message")).collect();
    assert_eq!(stats.message_count, messages.len() as u64);
}

#[test]
fn a_file_cut_anywhere_still_explains_itself_and_can_be_sealed() {
    let (directory, path) = recorded();
    let bytes = fs::read(&path).expect("read");
    let whole = Recording::open(&path).expect("opens");
    let cut_path = directory.path().join("cut.mcap");
    let after_topology = bytes.len() / 4;
    for cut in (after_topology..bytes.len()).step_by(bytes.len() / 40) {
        fs::write(&cut_path, &bytes[..cut]).expect("write");
        let recording = Recording::open(&cut_path).expect("a cut file opens");
        assert_eq!(recording.scene(), whole.scene());
        assert_eq!(recording.faces(), whole.faces());
        let times = recording.times();
        assert_eq!(times, whole.times()[..times.len()]);
        if let Some(last) = times.len().checked_sub(1) {
            let (cut, full) = (recording.frame(last), whole.frame(last));
            assert_eq!(
                cut.expect("there").positions,
                full.expect("there").positions
            );
        }
        seal(&cut_path).expect("can be completed");
        assert_whole(&cut_path);
        assert_eq!(Recording::open(&cut_path).expect("opens").times(), times);
    }
    fs::write(&cut_path, &bytes).expect("write");
    seal(&cut_path).expect("a whole file");
    assert!(
        fs::read(&cut_path).expect("read") == bytes,
        "sealing a whole file changes nothing"
    );
}

#[test]
fn a_flipped_byte_is_noticed() {
    let (_directory, path) = recorded();
    let mut bytes = fs::read(&path).expect("read");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&path, &bytes).expect("write");
    let error = Recording::open(&path).map(|_| ()).expect_err("damaged");
    assert!(matches!(error, NodeError::Unreadable { .. }), "{error}");
    assert!(error.to_string().contains("at byte"), "{error}");
}

fn error_of(path: &Path) -> NodeError {
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

/// Where a child process records to; see [`records_where_told`].
const TOLD: &str = "TOILE_TEST_RECORD";

/// Not a test of its own: the process that others limit and kill. Says each step that it has taken.
#[test]
fn records_where_told() {
    let Some(path) = std::env::var_os(TOLD) else {
        return;
    };
    let options = RunOptions {
        output: Some(path.into()),
        ..RunOptions::default()
    };
    let mut long = scene();
    long.duration = 10.0;
    long.output.rate = 200.0;
    let result = run(&long, options, &mut |progress| {
        std::thread::sleep(Duration::from_millis(1));
        let _ = writeln!(std::io::stderr(), "step {}", progress.step);
    });
    if let Err(error) = result {
        let _ = writeln!(std::io::stderr(), "error {error}");
    }
}

/// This binary again, running only [`records_where_told`], after a shell command.
fn child(before: &str, path: &Path) -> Command {
    let mut command = Command::new("bash");
    let run = "exec \"$0\" --exact recording::records_where_told --nocapture";
    command
        .arg("-c")
        .arg(format!("{before} {run}"))
        .arg(std::env::current_exe().expect("a path"))
        .env(TOLD, path)
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    command
}

#[test]
fn kill_loses_at_most_a_tenth_of_a_second() {
    let directory = TempDir::new().expect("a directory");
    let path = directory.path().join("killed.mcap");
    let mut process = child("", &path).spawn().expect("starts");
    let lines = BufReader::new(process.stderr.take().expect("piped")).lines();
    let steps = lines.filter_map(|l| l.ok()?.strip_prefix("step ")?.parse::<u64>().ok());
    let last = steps.take(150).last().expect("steps are said");
    process.kill().expect("kill -9");
    process.wait().expect("ends");
    let times = Recording::open(&path).expect("opens").times();
    let recorded = (times.last().expect("states") / 0.005).round() as u64;
    // A step takes at least 1 ms of wall time here, so 0.1 s are at most 100 steps; the queue holds 4.
    assert!(recorded + 20 >= last, "said {last}, recorded {recorded}");
    seal(&path).expect("can be completed");
    assert_whole(&path);
}

#[test]
fn a_full_disk_ends_with_an_error_and_a_file_that_opens() {
    let directory = TempDir::new().expect("a directory");
    let path = directory.path().join("full.mcap");
    // No file may grow past 300 KiB: every write beyond fails, as on a full disk, the index's too.
    let limited = child("trap '' XFSZ; ulimit -f 300;", &path)
        .output()
        .expect("runs");
    let said = String::from_utf8_lossy(&limited.stderr).into_owned();
    let error = said
        .lines()
        .find(|l| l.starts_with("error "))
        .expect("an error");
    assert!(
        error.contains("no space left") && error.contains("full.mcap"),
        "{error}"
    );
    assert_whole(&path);
    assert!(Recording::open(&path).expect("opens").times().len() > 10);
}

#[test]
fn a_device_without_space_is_an_error() {
    let directory = TempDir::new().expect("a directory");
    let path = directory.path().join("run.mcap");
    if !Path::new("/dev/full").exists() || File::open("/dev/full").is_err() {
        return;
    }
    std::os::unix::fs::symlink("/dev/full", &path).expect("link");
    let error = error_of(&path);
    assert!(matches!(error, NodeError::DiskFull { .. }), "{error}");
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
