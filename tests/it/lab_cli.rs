//! `toile measure` and `toile identify` as a laboratory runs them.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

fn toile(dir: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_toile"));
    command.args(args).current_dir(dir).output().unwrap()
}

#[track_caller]
fn succeeds(dir: &Path, args: &[&str]) -> String {
    let output = toile(dir, args);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{args:?}: {said}");
    String::from_utf8(output.stdout).unwrap()
}

#[track_caller]
fn refuses(dir: &Path, args: &[&str], part: &str) {
    let output = toile(dir, args);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{args:?}: {said}");
    assert!(output.stdout.is_empty());
    assert!(
        said.starts_with("error: ") && said.matches('\n').count() == 1,
        "{said}"
    );
    assert!(said.contains(part), "`{part}` is not in: {said}");
}

/// From tests to a fabric, pasted into a scene that runs, and measured again: the tests come back.
#[test]
fn tests_become_a_fabric_that_gives_them_back() {
    let dir = TempDir::new().unwrap();
    let at = dir.path();
    let tests = succeeds(at, &["identify", "--example"]);
    std::fs::write(at.join("tests.toml"), tests).unwrap();
    let fabric = succeeds(at, &["identify", "tests.toml"]);
    assert!(
        fabric.contains("Peirce (19)-(20)") && fabric.contains("\n[fabric]\n"),
        "{fabric}"
    );
    std::fs::write(at.join("fabric.toml"), &fabric).unwrap();

    let scene = "name = \"napkin\"\ndescription = \"A sheet falls\"\nduration = 0.01\n\
                 sheet = { outline = { kind = \"disc\", diameter = 0.1 }, triangles = 60 }\n";
    std::fs::write(at.join("napkin.toml"), format!("{scene}{fabric}")).unwrap();
    succeeds(at, &["run", "napkin.toml"]);

    let measure = |args: &[&str]| -> Value {
        let fixed = [
            "measure",
            args[0],
            "--fabric",
            "fabric.toml",
            "--json",
            "--meshes",
            "1",
        ];
        let all: Vec<&str> = fixed.iter().chain(&args[1..]).copied().collect();
        serde_json::from_str(&succeeds(at, &all)).unwrap()
    };
    let reading = |report: &Value, name: &str| -> f64 {
        let readings = report["readings"].as_array().unwrap();
        let found = readings.iter().find(|r| r["name"] == name).unwrap();
        found["value"].as_f64().unwrap()
    };
    for (direction, modulus) in [("warp", 6.33e6), ("weft", 2.55e6), ("bias", 4.36e6)] {
        let report = measure(&["tensile", "--direction", direction]);
        let off = reading(&report, "modulus at no strain") / modulus - 1.0;
        assert!(off.abs() < 1e-5, "{direction}: {off}");
    }
    let report = measure(&["cantilever", "--direction", "weft", "-o", "report.svg"]);
    let off = reading(&report, "overhang") / 0.0521 - 1.0;
    assert!(off.abs() < 2e-3, "overhang: {off}");
    let svg = std::fs::read_to_string(at.join("report.svg")).unwrap();
    for part in [
        "<svg",
        "exact elastica",
        "cantilever: F1-measured, weft",
        "flexural rigidity",
    ] {
        assert!(svg.contains(part), "{part}");
    }
}

#[test]
fn a_reading_is_printed_with_its_units_mesh_and_residual() {
    let dir = TempDir::new().unwrap();
    let text = succeeds(dir.path(), &["measure", "cantilever", "--fabric", "F9"]);
    for part in [
        "cantilever: F9, warp",
        "flexural rigidity, exact",
        "µN·m",
        "±",
        "356 triangles, edges of 0.98",
        "of the weight",
        "at 41.5 degrees",
    ] {
        assert!(text.contains(part), "`{part}` is not in:\n{text}");
    }
}

#[test]
fn bad_input_is_one_line() {
    let dir = TempDir::new().unwrap();
    let at = dir.path();
    let measure = |rest: &[&'static str]| [&["measure", "tensile", "--fabric"][..], rest].concat();
    refuses(
        at,
        &measure(&["F13"]),
        "--fabric F13: neither of the catalogue (F1, F2",
    );
    refuses(
        at,
        &measure(&["F1", "--set", "damping=1"]),
        "only keys of the fabric",
    );
    refuses(
        at,
        &measure(&["F1", "--set", "fabric.thickness=9"]),
        "fabric.thickness",
    );
    refuses(
        at,
        &measure(&["F1", "--width", "0.001", "--edge", "0.01"]),
        "width = 0.001",
    );
    refuses(
        at,
        &["identify", "nowhere.toml"],
        "nowhere.toml: cannot be read",
    );
    std::fs::write(at.join("half.toml"), "name = \"x\"\nareal_density = 0.1\n").unwrap();
    refuses(at, &["identify", "half.toml"], "missing field");
    let tests = succeeds(at, &["identify", "--example"]);
    let stiff = tests.replace("young_bias = 4.36e6", "young_bias = 4e7");
    std::fs::write(at.join("stiff.toml"), stiff).unwrap();
    refuses(
        at,
        &["identify", "stiff.toml"],
        "young_bias = 40000000: must be below",
    );
}

/// The drapemeter on the command line: every state of the report, and its picture.
#[test]
fn a_drape_is_printed_with_its_states() {
    let dir = TempDir::new().unwrap();
    let args = [
        "measure",
        "drapemeter",
        "--fabric",
        "F9",
        "--triangles",
        "300",
        "--seeds",
        "2",
        "-o",
        "shadow.svg",
    ];
    let said = succeeds(dir.path(), &args);
    assert!(said.starts_with("drapemeter: F9\n"), "{said}");
    assert!(said.contains("drape coefficient, 16 rays (21)"), "{said}");
    assert!(
        said.contains("every state is a minimum of the energy"),
        "{said}"
    );
    assert!(
        said.contains("disc of 250 mm on a plate of 150 mm, clamped between two plates"),
        "{said}"
    );
    let svg = std::fs::read_to_string(dir.path().join("shadow.svg")).unwrap();
    assert!(svg.contains("shadow, seed"));
    let picture: Vec<&str> = args
        .iter()
        .map(|a| if *a == "shadow.svg" { "shadow.png" } else { a })
        .collect();
    succeeds(dir.path(), &picture);
    let png = std::fs::read(dir.path().join("shadow.png")).unwrap();
    assert_eq!(&png[1..4], b"PNG");
    for (more, part) in [
        (
            ["--specimen", "0.14"],
            "specimen = 0.14: must be at least 0.1575 m",
        ),
        (["--friction", "-1"], "friction = -1: must be from 0 to 10"),
    ] {
        let args = ["measure", "drapemeter", "--fabric", "F9"];
        refuses(dir.path(), &[&args[..], &more].concat(), part);
    }
    refuses(
        dir.path(),
        &["measure", "drapemeter", "--all"],
        "--all needs -o DIR",
    );
    refuses(
        dir.path(),
        &["measure", "tensile", "--all", "-o", "x"],
        "--all is for the drapemeter",
    );
}

/// An audit that was broken off goes on where it was, and draws table and chart at the end.
#[test]
fn an_audit_goes_on_where_it_was_broken_off() {
    let dir = TempDir::new().unwrap();
    let at = dir.path();
    let args = [
        "measure",
        "drapemeter",
        "--all",
        "--triangles",
        "700",
        "--seeds",
        "1",
        "-o",
        "audit",
    ];
    let table = succeeds(at, &args);
    assert!(table.contains("| F10* | 25 (6) | 28 (6) |"), "{table}");
    let path = at.join("audit/drapemeter.csv");
    let whole = std::fs::read_to_string(&path).unwrap();
    assert_eq!(whole.lines().count(), 1 + 24);
    let kept: Vec<&str> = whole.lines().take(20).collect();
    std::fs::write(&path, kept.join("\n") + "\n").unwrap();
    succeeds(at, &args);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), whole);
    assert!(at.join("audit/drapemeter.svg").is_file());
}
