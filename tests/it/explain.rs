//! `toile explain`: what is on and what it costs, what is off and how much it would have been.

use serde_json::Value;
use toile::scene::Term;
use toile::scene::ablations;
use toile::sim::{Neglects, Simulation, stable_limit};

use crate::cli::{err, out, toile};
use crate::lab::{built_in, simulation};

fn explain(args: &[&str]) -> Value {
    let dir = tempfile::tempdir().unwrap();
    let output = toile(dir.path(), &[&["explain"], args, &["--json"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", err(&output));
    serde_json::from_str(&out(&output)).unwrap()
}

fn ratio(value: &Value, name: &str) -> Option<f64> {
    let left_out = value["left_out"].as_array().unwrap();
    let found = left_out.iter().find(|n| n["name"] == name);
    found.unwrap_or_else(|| panic!("{name} is not left out: {left_out:?}"))["ratio"].as_f64()
}

/// The shares of all parts, the rest included, are the whole; what is on has a reason, what is off a ratio.
#[test]
fn consistency_shares_are_the_whole() {
    for method in ["bdf2", "central-difference"] {
        let method = format!("method.scheme={method}");
        let set = [
            "drape-table",
            "--set",
            "sheet.triangles=200",
            "--set",
            &method,
            "--duration",
            "0.05",
        ];
        let said = explain(&set);
        let shares = said["costs"]
            .as_array()
            .unwrap()
            .iter()
            .map(|c| c["share"].as_f64().unwrap());
        let sum: f64 = shares.sum();
        // Units are timed apart from the run, so their sum may pass the whole, not by much.
        assert!(
            (0.99..2.5).contains(&sum),
            "{method}: shares sum to {sum}: {said:#}"
        );
        let kept: Vec<_> = said["kept"]
            .as_array()
            .unwrap()
            .iter()
            .map(|t| t["term"].as_str().unwrap())
            .collect();
        assert_eq!(
            kept,
            [
                "stretch", "bend", "gravity", "damping", "contact", "friction", "layers"
            ]
        );
        let parts = said["costs"].as_array().unwrap();
        let looks = parts.iter().find(|c| c["term"] == "layers");
        let looks = looks.unwrap_or_else(|| panic!("{method}: layers cost nothing: {parts:?}"));
        assert!(looks["count"].as_u64().unwrap() > 5, "{method}: {looks}");
        assert_eq!(ratio(&said, "support"), None);
        assert!(said["explicit_limit"].as_f64().unwrap() > 1e-6);
    }
}

/// A sheet that falls freely, flat: air takes 1.17 rho v²/2 per area, 0.5 % of F1's weight at 0.12 m/s.
#[test]
fn verify_the_neglect_of_air_on_a_falling_sheet() {
    let scene = built_in("free-fall", &["damping=0", "sheet.triangles=50"]);
    let mut simulation = simulation(&scene);
    let mut neglects = Neglects::new();
    let mut last = 0.0;
    for _ in 0..20 {
        simulation.step().unwrap();
        neglects.look(&simulation);
        let found = neglects.found(&simulation);
        let drag = found
            .iter()
            .find(|n| n.name == "drag")
            .unwrap()
            .ratio
            .unwrap();
        let speed = simulation.state().velocities[0].norm();
        let expected = 0.5 * 1.2 * 1.17 * speed * speed / (0.198 * 9.81);
        assert!(
            (drag / expected - 1.0).abs() < 1e-9,
            "{drag} at {speed} m/s"
        );
        assert!(drag > last);
        last = drag;
        let damping = found
            .iter()
            .find(|n| n.name == "damping")
            .unwrap()
            .ratio
            .unwrap();
        assert!((damping / (0.1 * speed / (0.198 * 9.81)) - 1.0).abs() < 1e-9);
        // Flat: nothing is near anything else.
        assert_eq!(neglects.gap(), 1.0);
    }
}

/// Two halves of a sheet within a thickness of each other are seen.
#[test]
fn verify_layers_that_meet_are_seen() {
    let set = ["sheet.triangles=400", "duration=0.6", "fabric.name=F9"];
    let scene = built_in("held-point", &[&set[..], &["layers.contact=off"]].concat());
    let mut simulation = simulation(&scene);
    let mut neglects = Neglects::new();
    for _ in 0..scene.steps() {
        simulation.step().unwrap();
        neglects.look(&simulation);
    }
    println!("held-point: smallest gap {} thicknesses", neglects.gap());
    assert!(neglects.gap() < 1.0);
}

/// Each toggle changes one thing, and the run of it differs.
#[test]
fn consistency_toggles() {
    let scene = built_in("drape-table", &["sheet.triangles=100"]);
    let names: Vec<_> = ablations(&scene).into_iter().map(|a| a.name).collect();
    assert_eq!(
        names,
        [
            "bend a thousandth",
            "gravity off",
            "damping off",
            "drag on",
            "contact off",
            "friction off",
            "layers off",
            "twist none",
            "poisson symmetrised"
        ]
    );
    let start = Simulation::new(&scene, 1).unwrap();
    for ablation in ablations(&scene) {
        assert_ne!(ablation.scene, scene, "{}", ablation.name);
        let mut toggled = Simulation::new(&ablation.scene, 1)
            .unwrap_or_else(|e| panic!("{}: {e}", ablation.name));
        assert_eq!(toggled.model().mesh.faces, start.model().mesh.faces);
        toggled.step().unwrap();
    }
    let off = ablations(&scene)
        .into_iter()
        .find(|a| a.name == "contact off")
        .unwrap();
    assert!(
        Simulation::new(&off.scene, 1)
            .unwrap()
            .model()
            .contact
            .is_none()
    );
    let needs = toile::scene::needs(&off.scene);
    assert!(needs.iter().all(|(term, _)| *term != Term::Friction));
}

/// Without weight nothing falls: the largest change there is, and the cheapest run.
#[test]
fn verify_an_ablation_measures_change() {
    let said = explain(&[
        "strip-release",
        "--set",
        "sheet.triangles=60",
        "--duration",
        "0.05",
        "--ablate",
    ]);
    let ablated = said["ablated"].as_array().unwrap();
    let change = |name: &str| {
        let row = ablated
            .iter()
            .find(|a| a["toggled"] == name)
            .unwrap_or_else(|| panic!("{name}: {ablated:?}"));
        row["change"].as_f64().unwrap()
    };
    assert!((change("gravity off") - 1.0).abs() < 1e-6);
    assert!(change("poisson symmetrised") < 1e-2);
    assert!(change("damping on") > change("poisson symmetrised"));
}

/// The limit that is printed is the one that the explicit scheme substeps by.
#[test]
fn consistency_of_the_limit() {
    let scene = built_in("drape-table", &["sheet.triangles=200"]);
    let simulation = simulation(&scene);
    let limit = stable_limit(simulation.model());
    assert!((simulation.substep().unwrap() / limit - 0.85).abs() < 1e-12);
}
