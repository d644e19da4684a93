//! A run through the real file and back: what is recorded can be read, whole, cut short, or on a bad disk.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use tempfile::TempDir;
use toile::node::{Memory, NodeError, Recording, RunOptions, Summary, run, seal};
use toile::scene::Scene;
use toile::sim::Simulation;
use toile::wire::channels;

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
    let mut simulation = Simulation::new(&scene(), 1);
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
