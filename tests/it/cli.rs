//! The real binary: exit codes, what goes to which stream, one line per error.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

pub fn toile(dir: &Path, args: &[&str]) -> Output {
    command(dir, args).output().unwrap()
}

pub fn command(dir: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_toile"));
    command.args(args).current_dir(dir).stdin(Stdio::null());
    command
}

pub fn out(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

pub fn err(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Refused with this exit code, nothing on standard output, and one line that holds all the parts.
#[track_caller]
fn refuses(code: i32, args: &[&str], parts: &[&str]) {
    let dir = TempDir::new().unwrap();
    let output = toile(dir.path(), args);
    assert_refusal(&output, code, parts);
    assert_eq!(
        dir.path().read_dir().unwrap().count(),
        0,
        "a refused run leaves nothing behind"
    );
}

#[track_caller]
pub fn assert_refusal(output: &Output, code: i32, parts: &[&str]) {
    let message = err(output);
    assert_eq!(output.status.code(), Some(code), "{message}");
    assert_eq!(out(output), "");
    assert_eq!(message.matches('\n').count(), 1, "one line: {message}");
    assert!(message.starts_with("error: "), "{message}");
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
}

/// A run of a moment: few triangles, few steps, nothing to touch.
pub const SHORT: [&str; 6] = [
    "run",
    "free-fall",
    "--set",
    "sheet.triangles=200",
    "--duration",
    "0.02",
];

#[test]
fn run_records_and_says_what_came_of_it() {
    let dir = TempDir::new().unwrap();
    let output = toile(dir.path(), &SHORT);
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    assert!(!err(&output).contains('\r'), "no bar without a terminal");
    let text = out(&output);
    for part in [
        "free-fall: F1 with bdf2, dt 0.005 s",
        "0.0200 s in 4 steps",
        "every step converged",
        "stretch, bend, gravity, damping, layers\n",
        "largest strain",
        "% at the end)",
        "s CPU",
        "free-fall.mcap, ",
        "next: toile show free-fall.mcap -o shot.png",
    ] {
        assert!(text.contains(part), "`{part}` is not in: {text}");
    }
    assert!(!text.contains("penetration"), "nothing to touch: {text}");
    let bytes = std::fs::read(dir.path().join("free-fall.mcap")).unwrap();
    assert_eq!(&bytes[..8], b"\x89MCAP0\r\n", "magic at the start");
    assert_eq!(
        &bytes[bytes.len() - 8..],
        b"\x89MCAP0\r\n",
        "and at the end"
    );
}

#[test]
fn run_as_json_is_one_object() {
    let dir = TempDir::new().unwrap();
    let options = [
        "--json",
        "-o",
        "a.mcap",
        "--fabric",
        "F9",
        "--method",
        "backward-euler",
        "--dt",
        "0.002",
        "--seed",
        "7",
        "--threads",
        "2",
    ];
    let output = toile(dir.path(), &[&SHORT[..], &options].concat());
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["scene"], "free-fall");
    assert_eq!(summary["fabric"], "F9");
    assert_eq!(summary["method"], "backward-euler");
    assert_eq!(summary["steps"], 10);
    assert_eq!(summary["recording"], "a.mcap");
    let size = dir.path().join("a.mcap").metadata().unwrap().len();
    assert_eq!(summary["recording_bytes"], size);
    assert_eq!(summary["digest"].as_str().unwrap().len(), 16);
    assert!(summary["energies"]["kinetic"].is_number());
    assert!(summary["largest_strain"]["end"].is_number());
}

#[test]
fn run_takes_a_file_and_standard_input() {
    let dir = TempDir::new().unwrap();
    let printed = toile(dir.path(), &["scene", "free-fall"]);
    std::fs::write(dir.path().join("mine.toml"), &printed.stdout).unwrap();
    let short = &SHORT[2..];
    let output = toile(dir.path(), &[&["run", "mine.toml"], short].concat());
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));

    let mut child = command(dir.path(), &[&["run", "-", "-o", "b.mcap"], short].concat())
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(&printed.stdout).unwrap();
    drop(stdin);
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert!(dir.path().join("b.mcap").exists());
}

#[test]
fn a_bad_scene_file_is_refused_with_its_line() {
    let dir = TempDir::new().unwrap();
    let printed = out(&toile(dir.path(), &["scene", "free-fall"]));
    let bad = printed.replace("triangles = 400", "triangels = 400");
    let line = 1 + bad
        .lines()
        .position(|l| l.starts_with("triangels"))
        .unwrap();
    std::fs::write(dir.path().join("bad.toml"), bad).unwrap();
    let at = format!("bad.toml: line {line}: sheet.triangels = 400: unknown key");
    let output = toile(dir.path(), &["run", "bad.toml"]);
    assert_refusal(&output, 2, &[&at, "did you mean `triangles`?"]);

    std::fs::write(dir.path().join("latin.toml"), b"name = \"\xe9\"").unwrap();
    let output = toile(dir.path(), &["run", "latin.toml"]);
    assert_refusal(&output, 2, &["latin.toml: it is not UTF-8 text"]);
    let output = toile(dir.path(), &["run", "."]);
    assert_refusal(&output, 2, &["cannot read scene ."]);
}

#[test]
fn bad_usage_is_one_line_and_exit_code_2() {
    refuses(2, &["run"], &["<SCENE>"]);
    refuses(2, &["rum"], &["rum"]);
    refuses(2, &["run", "free-fall", "--fabrik", "F1"], &["--fabrik"]);
    refuses(2, &["run", "free-fall", "--threads", "0"], &["--threads"]);
    refuses(2, &["list", "fabric"], &["fabric", "fabrics"]);
    refuses(
        2,
        &["run", "free-fal"],
        &[
            "free-fal is neither a file nor a built-in scene",
            "free-fall",
        ],
    );
    refuses(2, &["scene", "nope"], &["nope", "drape-table"]);
    refuses(2, &["show", "nope.mcap"], &["cannot open nope.mcap"]);
}

#[test]
fn a_refused_option_names_the_option_key_value_and_range() {
    let run = |rest: &[&'static str]| [&["run", "free-fall"], rest].concat();
    refuses(
        2,
        &run(&["--dt", "-1"]),
        &["--dt -1: method.dt = -1", "from 1e-7 to 1 s"],
    );
    refuses(
        2,
        &run(&["--duration", "nan"]),
        &["--duration nan: duration = NaN", "s"],
    );
    refuses(
        2,
        &run(&["--seed", "1.5"]),
        &["--seed 1.5: perturbation.seed = 1.5", "whole number"],
    );
    refuses(
        2,
        &run(&["--method", "rk4"]),
        &["--method rk4: method.scheme = \"rk4\"", "bdf2"],
    );
    refuses(
        2,
        &run(&["--fabric", "F0"]),
        &["--fabric F0: fabric.name = \"F0\"", "F12"],
    );
    refuses(
        2,
        &run(&["--set", "dampin=0"]),
        &["--set dampin=0", "`damping`"],
    );
    refuses(2, &run(&["--set", "damping"]), &["KEY=VALUE"]);
}

#[test]
fn a_file_that_cannot_be_written_is_exit_code_1() {
    let dir = TempDir::new().unwrap();
    std::fs::write(dir.path().join("taken"), "").unwrap();
    let output = toile(dir.path(), &[&SHORT[..], &["-o", "taken/a.mcap"]].concat());
    assert_refusal(&output, 1, &["taken"]);
    let output = toile(dir.path(), &[&SHORT[..], &["-o", "taken"]].concat());
    assert_refusal(&output, 1, &["taken", "does not end in .mcap"]);
}

#[test]
fn a_scene_says_what_it_needs() {
    let dir = TempDir::new().unwrap();
    let text = out(&toile(dir.path(), &["scene", "free-fall", "--needs"]));
    assert!(
        text.contains("damping   damping = 0.1 kg/(m²·s)\n"),
        "{text}"
    );
    assert!(text.contains("contact   left out"), "{text}");
    refuses(2, &["scene", "nope", "--needs"], &["nope", "drape-table"]);
}

#[test]
fn list_shows_everything_built_in() {
    let dir = TempDir::new().unwrap();
    for (what, some) in [
        ("scenes", ["drape-table", "cantilever"]),
        ("fabrics", ["F1 ", "F12 "]),
        ("methods", ["bdf2", "central-difference"]),
        ("messages", ["/toile/state", "sensor_msgs/msg/PointCloud2"]),
        ("commands", ["/toile/cmd/obstacle", "StepSimulation"]),
    ] {
        let text = out(&toile(dir.path(), &["list", what]));
        for part in some {
            assert!(text.contains(part), "`{part}` is not in: {text}");
        }
        let json = toile(dir.path(), &["list", what, "--json"]);
        let values: Value = serde_json::from_slice(&json.stdout).unwrap();
        // The table has a head, and nothing else that the JSON has not.
        assert_eq!(values.as_array().unwrap().len() + 1, text.lines().count());
    }
    let fabrics = toile(dir.path(), &["list", "fabrics", "--json"]);
    let fabrics: Value = serde_json::from_slice(&fabrics.stdout).unwrap();
    assert_eq!(fabrics[0]["rigidity_warp"], 25.21e-6, "SI");
}

#[test]
fn a_built_in_scene_is_printed_as_it_is() {
    let dir = TempDir::new().unwrap();
    for name in toile::scene::library::names() {
        let text = out(&toile(dir.path(), &["scene", name]));
        assert_eq!(Some(text.as_str()), toile::scene::library::text(name));
    }
}

#[test]
fn help_and_version_go_to_standard_output() {
    let dir = TempDir::new().unwrap();
    for (flag, part) in [("--help", "run"), ("--version", env!("CARGO_PKG_VERSION"))] {
        let output = toile(dir.path(), &[flag]);
        assert_eq!(output.status.code(), Some(0));
        assert!(out(&output).contains(part));
    }
}

/// Verbs of the README's summary of the command line are those of the binary, and each has help.
#[test]
fn the_readme_shows_every_verb() {
    let dir = TempDir::new().unwrap();
    let help = out(&toile(dir.path(), &["--help"]));
    let commands = help.split("Commands:\n").nth(1).unwrap();
    let commands = commands.split("\n\n").next().unwrap();
    let readme = include_str!("../../README.md");
    for line in commands.lines() {
        let verb = line.split_whitespace().next().unwrap();
        if verb != "help" {
            assert!(readme.contains(&format!("\ntoile {verb} ")), "{verb}");
            let output = toile(dir.path(), &[verb, "--help"]);
            assert_eq!(output.status.code(), Some(0), "{verb} --help");
        }
    }
}

/// The stop of a long run: the recording is closed, the summary says so.
#[test]
fn a_signal_ends_the_run_with_its_recording_closed() {
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        let dir = TempDir::new().unwrap();
        // The warning of the coarse mesh, printed once the handlers stand, says that a signal may come.
        let long = [
            "run",
            "free-fall",
            "--set",
            "sheet.triangles=100",
            "--duration",
            "50000",
            "--set",
            "output.rate=1",
            "--json",
        ];
        let mut child = command(dir.path(), &long)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut first = String::new();
        let mut stderr = BufReader::new(child.stderr.take().unwrap());
        stderr.read_line(&mut first).unwrap();
        assert!(first.starts_with("warning: the mesh's edges"), "{first}");
        kill(child.id(), signal);
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0));
        let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(summary["stopped"], true);
        assert!(summary["time"].as_f64().unwrap() < 50000.0);
        let bytes = std::fs::read(dir.path().join("free-fall.mcap")).unwrap();
        assert_eq!(&bytes[bytes.len() - 8..], b"\x89MCAP0\r\n");
    }
}

/// Sends a signal as a user would: with the system's own command.
pub fn kill(process: u32, signal: i32) {
    let status = Command::new("sh")
        .args(["-c", &format!("kill -{signal} {process}")])
        .status()
        .unwrap();
    assert!(status.success());
}
