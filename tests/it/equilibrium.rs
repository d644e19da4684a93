//! The scheme `equilibrium`: it ends on the residual, at a minimum, or says why not.

use std::f64::consts::TAU;

use crate::lab::{built_in, reading, scene, simulation};
use nalgebra::{Rotation2, Vector2};
use toile::scene::{Override, library, parse};
use toile::sim::{Probe, Simulation};

const STILL: &[&str] = &["method.scheme=equilibrium", "duration=5e-3"];

/// The same place as motion that has died down, in one step.
#[test]
fn verify_equilibrium_is_where_motion_ends() {
    let all = [STILL, &["sheet.triangles=600", "method.tolerance=1e-9"]].concat();
    let scene = built_in("three-edges", &all);
    assert_eq!(scene.steps(), 1);
    let mut still = simulation(&scene);
    let report = still.step().unwrap().clone();
    assert!(report.converged && report.residual <= 1e-9, "{report:?}");
    assert_eq!(report.energies.kinetic, 0.0);
    let found = still.equilibrium().unwrap();
    assert!(
        found.saddles == 0 && found.lowest_frequency > 1.0,
        "{found:?}"
    );
    let mut moving = crate::lab::run(&built_in("three-edges", &["sheet.triangles=600"]));
    moving.step().unwrap();
    for name in ["free_edge", "centre"] {
        let [a, b] = [&still, &moving].map(|s| reading(s, name));
        assert!(
            (a / b - 1.0).abs() < 1e-4,
            "{name}: {a} at rest, {b} after motion"
        );
    }
}

/// A strip on its clamp, higher than it can stand, upright to the last bit.
fn upright() -> Simulation {
    simulation(&scene(
        "name = \"upright\"\ndescription = \"A strip stands\"\nduration = 1.0\n\
         sheet = { outline = { kind = \"rectangle\", length = 0.1, width = 0.02 }, edge = 5e-3, \
         rotation = [0.0, -90.0, 0.0] }\n\
         fabric = { name = \"F1\" }\n\
         method = { scheme = \"equilibrium\", tolerance = 1e-9 }\n\
         [support]\nfoot = { kind = \"clamp\", region = { kind = \"x-min\" } }\n",
    ))
}

/// Upright is a state of rest, too, but a saddle; it must not be the answer.
#[test]
fn a_saddle_is_left() {
    let mut strip = upright();
    let lowest = |s: &Simulation| {
        let heights = s.state().positions.iter().map(|p| p.z);
        heights.fold(f64::INFINITY, f64::min)
    };
    let foot = lowest(&strip);
    strip.step().unwrap();
    let found = strip.equilibrium().unwrap();
    assert!(
        found.saddles > 0 && found.lowest_frequency > 0.5,
        "{found:?}"
    );
    assert!(lowest(&strip) < foot - 0.02, "it still stands");
}

/// A strip on its clamp over a smooth rod that is thinner than an iteration is long.
fn over_a_rod(method: &str, rod: &str) -> Simulation {
    let text = format!(
        "name = \"over-a-rod\"\ndescription = \"A strip lies on a rod\"\nduration = 2.0\ndamping = 3.0\n\
         sheet = {{ outline = {{ kind = \"rectangle\", length = 0.1, width = 0.025 }}, triangles = 800, \
         position = [0.05, 0.0, 0.0] }}\n\
         fabric = {{ name = \"F1\" }}\nmethod = {{ {method} }}\n\
         [support.clamp]\nkind = \"clamp\"\nregion = {{ kind = \"x-min\" }}\n\
         [obstacle.rod]\nshape = {{ kind = \"capsule\", radius = 5e-3, length = 0.1 }}\nfriction = 0.0\n\
         rotation = [90.0, 0.0, 0.0]\n{rod}\n\
         [observe.tip]\nregion = {{ kind = \"x-max\" }}\naxis = \"z\"\n"
    );
    simulation(&scene(&text))
}

const RESTS: &str = "scheme = \"equilibrium\", tolerance = 1e-8, dt = 0.01";

/// Where motion ends, too; past the rod the tip would hang 93 mm down.
#[test]
fn verify_a_thin_obstacle_is_not_jumped_over() {
    let below = "position = [0.03, 0.0, -0.008]";
    let mut still = over_a_rod(RESTS, below);
    let touch = still.step().unwrap().contacts;
    let mut moving = over_a_rod("scheme = \"bdf2\", dt = 0.01", below);
    for _ in 0..200 {
        moving.step().unwrap();
    }
    let [at_rest, in_the_end] = [&still, &moving].map(|s| reading(s, "tip"));
    println!("tip at {at_rest} at rest, at {in_the_end} after motion");
    assert!(touch > 0 && -0.07 < at_rest && at_rest < -0.06);
    assert!((at_rest / in_the_end - 1.0).abs() < 2e-3);
}

/// A rod that would be through the sheet at the end of a step is told, not taken for one that never met it; in steps short
/// enough it lifts the sheet.
#[test]
fn an_obstacle_that_passes_the_sheet_in_a_step_is_an_error() {
    let rises = |over: f64| {
        let rod = format!(
            "motion = {{ times = [0.0, {over}], positions = [[0.03, 0.0, -0.02], [0.03, 0.0, 0.02]] }}"
        );
        let mut strip = over_a_rod(RESTS, &rod);
        let steps = (over / 0.01).round() as usize;
        let ended = (0..steps).try_for_each(|_| strip.step().map(|_| ()));
        (ended, strip)
    };
    let (ended, strip) = rises(0.01);
    let told = ended.unwrap_err().to_string();
    assert!(
        told.contains("through the sheet") && told.contains("method.dt"),
        "{told}"
    );
    assert_eq!(reading(&strip, "tip"), 0.0);
    let (ended, strip) = rises(0.2);
    ended.unwrap();
    let highest = strip
        .state()
        .positions
        .iter()
        .map(|x| x.z)
        .fold(0.0, f64::max);
    assert!((highest - 0.025).abs() < 1e-3, "{highest}");
}

/// Nothing holds it, so it never comes to rest; on which mesh is said where there are several.
#[test]
fn what_cannot_rest_is_an_error() {
    let all = [STILL, &["sheet.triangles=40"]].concat();
    let mut falling = simulation(&built_in("free-fall", &all));
    let before = falling.state().digest();
    let error = falling.step().unwrap_err().to_string();
    assert!(error.contains("no state of rest was found"), "{error}");
    assert_eq!(falling.state().digest(), before);
    let set = ["sheet.triangles=200", "method.coarsest=50"];
    let mut falling = simulation(&built_in("free-fall", &[STILL, &set].concat()));
    let coarse = falling.model().scene.on_mesh(50);
    let triangles = simulation(&coarse).model().mesh.faces.len();
    let error = falling.step().unwrap_err().to_string();
    let said = format!("one of the mesh of {triangles} triangles");
    assert!(error.contains(&said), "{error}");
}

/// The same bits on any number of threads, and after a resume.
#[test]
fn equilibrium_is_reproducible() {
    let mut all = STILL.to_vec();
    all.extend([
        "sheet.triangles=400",
        "perturbation.seed=3",
        "duration=0.02",
        "method.tolerance=1e-6",
    ]);
    let scene = built_in("drape-table", &all);
    let run = |threads| {
        let mut simulation = Simulation::new(&scene, threads).unwrap();
        simulation.step().unwrap_or_else(|e| panic!("{e}"));
        simulation
    };
    let (one, two) = (run(1), run(2));
    assert_eq!(one.state().digest(), two.state().digest());
    let mut resumed = simulation(&scene);
    resumed.resume(one.state().clone()).unwrap();
    let mut whole = one;
    assert_eq!(resumed.step().unwrap(), whole.step().unwrap());
}

/// A strip on its clamp that hangs over a smooth ball.
const OVER_A_BALL: &str = r#"
name = "over-a-ball"
description = "A clamped strip hangs over a smooth ball"
duration = 5e-3
sheet = { outline = { kind = "rectangle", length = 0.1, width = 0.025 }, triangles = 800, position = [0.05, 0.0, 0.0] }
fabric = { name = "F1" }
method = { scheme = "equilibrium", tolerance = 1e-8 }
[support.clamp]
kind = "clamp"
region = { kind = "x-min" }
[obstacle.ball]
shape = { kind = "sphere", radius = 0.03 }
position = [0.05, 0.0, -0.035]
[observe.tip]
region = { kind = "x-max" }
axis = "z"
"#;

/// Where there is one state of rest only, it does not matter on which meshes it is looked for first.
#[test]
fn verify_coarser_meshes_lead_to_the_same_rest() {
    let sagging = [STILL, &["sheet.triangles=800", "method.tolerance=1e-8"]].concat();
    let scenes = [
        (built_in("three-edges", &sagging), "centre"),
        (scene(OVER_A_BALL), "tip"),
    ];
    for (mut scene, key) in scenes {
        let mut rest = |coarsest| {
            scene.method.coarsest = coarsest;
            let mut simulation = simulation(&scene);
            simulation.step().unwrap_or_else(|e| panic!("{key}: {e}"));
            let tests = simulation.report().work.tests;
            (
                reading(&simulation, key),
                tests,
                simulation.report().contacts,
            )
        };
        let (alone, nested) = (rest(None), rest(Some(100)));
        println!("{key}: {alone:?}, over coarser meshes {nested:?}");
        assert!(
            (alone.0 / nested.0 - 1.0).abs() < 1e-6,
            "{key}: {alone:?}, {nested:?}"
        );
        assert_eq!(
            nested.1,
            alone.1 + 3,
            "{key}: each of 100, 200, 400 comes to rest"
        );
        assert_eq!(nested.2 > 0, key == "tip");
    }
}

/// From flat, every mesh takes other folds; from a coarser one it keeps them.
#[test]
fn verify_folds_are_kept_as_the_mesh_is_refined() {
    let around = |k: u32| Rotation2::new(f64::from(k) * TAU / 36.0) * Vector2::new(0.125, 0.0);
    let rim: Vec<_> = (0..36).map(around).collect();
    let heights = |triangles: usize, coarsest| {
        let mut scene = built_in("drapemeter", &["fabric.name=F5"]).on_mesh(triangles);
        scene.method.coarsest = coarsest;
        let mut drape = simulation(&scene);
        drape.step().unwrap_or_else(|e| panic!("{e}"));
        let height = |p: &Vector2<f64>| {
            let probe = Probe::at(&drape.model().mesh, &[*p]);
            probe.read(&drape.state().positions).z
        };
        rim.iter().map(height).collect::<Vec<f64>>()
    };
    let apart = |coarsest| {
        let (coarse, fine) = (heights(1400, coarsest), heights(2800, coarsest));
        let squares = coarse.iter().zip(&fine).map(|(a, b)| (a - b).powi(2));
        (squares.sum::<f64>() / 36.0).sqrt()
    };
    let (flat, kept) = (apart(None), apart(Some(350)));
    println!(
        "rim of 2,800 triangles from that of 1,400: {flat:.4} m from flat, {kept:.4} m nested"
    );
    assert!(kept < 2.5e-3 && flat > 2.0 * kept);
}

#[test]
fn coarser_meshes_are_for_states_of_rest() {
    for (set, parts) in [
        (
            ["method.coarsest=100", "method.scheme=bdf2"],
            ["method.coarsest = 100", "needs method.scheme = equilibrium"],
        ),
        (
            ["method.coarsest=10", "method.scheme=equilibrium"],
            ["method.coarsest = 10", "from 50 to"],
        ),
    ] {
        let set = set.map(|s| Override::parse(s).unwrap());
        let text = library::text("three-edges").unwrap();
        let refusal = parse(text, &set).unwrap_err().to_string();
        assert!(parts.iter().all(|part| refusal.contains(part)), "{refusal}");
    }
}
