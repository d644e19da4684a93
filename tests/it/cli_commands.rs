//! Commands to a run of the real binary: from a file, and while it goes.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};
use tempfile::TempDir;
use toile::node::Recording;
use toile::wire::inbound;
use toile::wire::messages::toile_msgs::ObstacleCommand;

use crate::cli::{assert_refusal, err, toile};

/// A small drape that others may change.
const DRAPE: [&str; 8] = [
    "run",
    "drape-table",
    "--set",
    "sheet.triangles=150",
    "--set",
    "accept=[\"obstacles\"]",
    "--duration",
    "0.2",
];

const COMMANDS: &str = r#"
[[command]]
step = 4
to = "/toile/cmd/obstacle"
message = { operation = 1, name = "table", set_twist = true, twist.linear.z = 0.1 }

[[command]]
step = 12
to = "/toile/cmd/obstacle"
[command.message]
operation = 0
name = "ball"
solid = { type = 2, dimensions = [0.02] }
friction = 0.2
pose.position = { x = 0.4, z = 0.1 }
pose.orientation.w = 1

[[command]]
step = 3
to = "/toile/set_simulation_state"
message.state.state = 2

[[command]]
step = 3
to = "/toile/set_simulation_state"
message.state.state = 1
"#;

fn run_with(dir: &Path, commands: &str) -> std::process::Output {
    fs::write(dir.join("commands.toml"), commands).unwrap();
    let options = ["--commands", "commands.toml", "-o", "a.mcap", "--json"];
    toile(dir, &[&DRAPE[..], &options].concat())
}

#[test]
fn a_run_takes_commands_from_a_file_at_their_steps() {
    let dir = TempDir::new().unwrap();
    let output = run_with(dir.path(), COMMANDS);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["commands"]["applied"], 4);
    let recording = Recording::open(&dir.path().join("a.mcap")).unwrap();
    let steps: Vec<_> = recording.commands().iter().map(|c| c.step).collect();
    assert_eq!(steps, [3, 3, 4, 12]);
    let last = recording.frame(recording.times().len() - 1).unwrap();
    let mut names: Vec<_> = last.obstacles.iter().map(|o| o.name.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["ball", "table"]);
    let ball = last.obstacles.iter().find(|o| o.name == "ball").unwrap();
    assert_eq!(ball.pose.translation.vector.x, 0.4);
    let table = last.obstacles.iter().find(|o| o.name == "table").unwrap();
    // From step 4 to 20 of 10 ms each, at 0.1 m/s.
    let z = table.pose.translation.vector.z;
    assert!((z - (-0.05 + 0.016)).abs() < 1e-9, "{z}");
    let output = toile(dir.path(), &["replay", "a.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
}

#[test]
fn a_bad_file_of_commands_is_one_line() {
    let dir = TempDir::new().unwrap();
    for (commands, parts) in [
        ("[[command]]\nstep = 1\n", &["line 1: ", "`to`"][..]),
        ("[[command]]\nstop = 1\n", &["line 2: ", "`stop`"]),
        (
            "[[command]]\nstep = 1\nto = \"/toile/cmd/wint\"\n",
            &["command 1: to = \"/toile/cmd/wint\"", "/toile/cmd/wind"],
        ),
        (
            "[[command]]\nstep = 1\nto = \"/toile/cmd/wind\"\nmessage.vector.w = 1.0\n",
            &["command 1: message.vector.w: there is no such field; there are x, y, z"],
        ),
        (
            "[[command]]\nstep = 1\nto = \"/toile/cmd/wind\"\nmessage.vector.x = \"1\"\n",
            &["message.vector.x = \"1\": must be a number"],
        ),
        (
            "[[command]]\nstep = 1\nto = \"/toile/cmd/wind\"\nmessage.vector.x = 1e9\n",
            &["command 1: message.", "out of range"],
        ),
    ] {
        let output = run_with(dir.path(), commands);
        assert_refusal(&output, 2, &[&["commands.toml: "], parts].concat());
        assert!(!dir.path().join("a.mcap").exists());
    }
    let output = toile(dir.path(), &[&DRAPE[..], &["--commands", "none"]].concat());
    assert_refusal(&output, 2, &["cannot open none"]);
}

/// What is written by hand is what a program would send.
#[test]
fn messages_are_composed_from_their_fields() {
    for inlet in inbound::ALL {
        inlet.compose(&json!({})).expect(inlet.name);
    }
    let inlet = inbound::find("/toile/cmd/obstacle").unwrap();
    let command = ObstacleCommand {
        operation: ObstacleCommand::REMOVE,
        name: "table".to_string(),
        ..ObstacleCommand::default()
    };
    let composed = inlet.compose(&json!({ "operation": 2, "name": "table" }));
    assert_eq!(
        composed.unwrap(),
        toile::wire::cdr::encode(&command).unwrap()
    );
}

/// The drape as a session that waits for steps, recorded in `a.mcap`.
#[cfg(feature = "iceoryx2")]
fn lockstep(dir: &TempDir, name: &str) -> std::process::Child {
    let run = [
        "-o", "a.mcap", "--shm", "--pace", "lockstep", "--name", name,
    ];
    let mut child = crate::cli::command(dir.path(), &[&DRAPE[..], &run].concat());
    child
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap()
}

/// Waits until the first state of a run is there.
#[cfg(feature = "iceoryx2")]
fn wait_for_run(dir: &TempDir, name: &str) {
    let watch = ["watch", "state", "--count", "1", "--timeout", "60"];
    let output = toile(dir.path(), &[&watch[..], &["--name", name]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
}

/// Commands of a live session over shared memory: the recording replays.
#[cfg(feature = "iceoryx2")]
#[test]
fn a_session_with_live_commands_replays() {
    let dir = TempDir::new().unwrap();
    let name = format!("session-{}", std::process::id());
    let child = lockstep(&dir, &name);
    let send = |args: &[&str]| {
        let output = toile(
            dir.path(),
            &[&["send"], args, &["--name", &name, "--timeout", "60"]].concat(),
        );
        assert_eq!(output.status.code(), Some(0), "{args:?}: {}", err(&output));
    };
    wait_for_run(&dir, &name);
    send(&["step", "5"]);
    send(&["obstacle", "move", "table", "--velocity", "0,0,0.1"]);
    send(&["step", "4"]);
    send(&[
        "obstacle",
        "add",
        "ball",
        "--sphere",
        "0.02",
        "--position",
        "0.4,0,0",
    ]);
    send(&["resume"]);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let said = crate::cli::out(&output);
    assert!(
        said.contains("5 applied, 0 rejected, 0 malformed, 0 dropped"),
        "{said}"
    );
    let recording = Recording::open(&dir.path().join("a.mcap")).unwrap();
    let steps: Vec<_> = recording.commands().iter().map(|c| c.step).collect();
    assert_eq!(steps, [0, 5, 5, 9, 9]);
    let output = toile(dir.path(), &["replay", "a.mcap", "--threads", "2"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
}

/// A triangle mesh goes from a file into a live session; broken files are refused before anything is sent.
#[cfg(feature = "iceoryx2")]
#[test]
fn a_mesh_is_sent_from_a_file() {
    const WEDGE: &str =
        "v 0 0 0\nv 40 0 0\nv 0 40 0\nv 0 0 40\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    let dir = TempDir::new().unwrap();
    std::fs::write(dir.path().join("wedge.obj"), WEDGE).unwrap();
    std::fs::write(dir.path().join("broken.obj"), "v 0 0 0\nf 1 2 3\n").unwrap();
    std::fs::write(dir.path().join("empty.stl"), "solid\nendsolid\n").unwrap();
    let name = format!("mesh-{}", std::process::id());
    let child = lockstep(&dir, &name);
    wait_for_run(&dir, &name);
    let send = |args: &[&str]| {
        let rest = ["--name", &name, "--timeout", "60"];
        toile(dir.path(), &[&["send"], args, &rest].concat())
    };
    let mesh = |file: &str, scale: &str| {
        let shape = ["--mesh", file, "--scale", scale];
        let place = ["--position", "0.4,0,0"];
        send(&[&["obstacle", "add", "wedge"], &shape[..], &place[..]].concat())
    };
    for (file, scale, code, said) in [
        ("broken.obj", "1", 2, "broken.obj"),
        ("empty.stl", "1", 2, "empty.stl"),
        ("none.stl", "1", 2, "none.stl"),
        ("wedge.obj", "0", 2, "--scale"),
        ("wedge.obj", "1e-3", 0, ""),
        ("wedge.obj", "1e-3", 1, "wedge"),
    ] {
        let output = mesh(file, scale);
        let told = err(&output);
        println!("{file}, {scale}: {told}");
        assert_eq!(output.status.code(), Some(code), "{file}, {scale}: {told}");
        assert!(told.contains(said), "{file}, {scale}: {told}");
    }
    assert_eq!(send(&["resume"]).status.code(), Some(0));
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let output = toile(dir.path(), &["replay", "a.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
}

/// A run that nobody has started yet ends at a signal like any other, its recording closed.
#[cfg(feature = "iceoryx2")]
#[test]
fn a_signal_ends_a_paused_run_with_its_recording_closed() {
    let dir = TempDir::new().unwrap();
    let name = format!("paused-{}", std::process::id());
    let run = [
        "-o",
        "a.mcap",
        "--shm",
        "--wait-for-start",
        "--json",
        "--name",
        &name,
    ];
    let mut child = crate::cli::command(dir.path(), &[&DRAPE[..], &run].concat());
    let child = child.stdout(std::process::Stdio::piped()).spawn().unwrap();
    wait_for_run(&dir, &name);
    let said = toile(dir.path(), &["send", "state", "--name", &name]);
    assert!(crate::cli::out(&said).contains("paused"), "{}", err(&said));
    crate::cli::kill(child.id(), signal_hook::consts::SIGTERM);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        (&summary["stopped"], &summary["steps"]),
        (&json!(true), &json!(0))
    );
    crate::recording::assert_whole(&dir.path().join("a.mcap"));
    let output = toile(dir.path(), &["replay", "a.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
}
