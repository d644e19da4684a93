//! Scenes at the border: what is taken, how overrides act, what is remarked.

use toile::scene::{Override, Scene, Warning, library, parse};

/// A scene with every line numbered by its content; tests change one line of it.
pub const GOOD: &str = r#"name = "mine"
description = "A scene for tests"
duration = 1.0
damping = 0.1

[sheet]
outline = { kind = "rectangle", length = 0.2, width = 0.1 }
edge = 0.01

[fabric]
name = "F1"

[support.left]
kind = "clamp"
region = { kind = "x-min" }

[obstacle.table]
shape = { kind = "box", size = [0.1, 0.1, 0.1] }
friction = 0.3

[method]
scheme = "bdf2"
dt = 5e-3

[output]
rate = 100.0

[observe.tip]
points = [[0.1, 0.0]]
axis = "z"
"#;

pub fn with(line: &str, replacement: &str) -> String {
    assert!(GOOD.contains(line), "{line} is not in the scene");
    GOOD.replace(line, replacement)
}

pub fn sets(texts: &[&str]) -> Vec<Override> {
    texts
        .iter()
        .map(|text| Override::parse(text).unwrap())
        .collect()
}

pub fn good(text: &str, overrides: &[&str]) -> Scene {
    parse(text, &sets(overrides)).unwrap().0
}

#[test]
fn a_good_scene_is_taken_without_remarks() {
    let (scene, warnings) = parse(GOOD, &[]).unwrap();
    assert_eq!(scene.name, "mine");
    assert_eq!(scene.sheet.edge, Some(0.01));
    assert_eq!(scene.support["left"].axes, "xyz");
    assert_eq!(scene.gravity, [0.0, 0.0, -9.81]);
    assert_eq!(warnings, vec![]);
    assert_eq!((scene.steps(), scene.output_steps()), (200, 2));
}

#[test]
fn a_fabric_is_the_catalogue_with_single_constants_replaced() {
    let scene = good(GOOD, &["fabric.name=f5", "fabric.thickness=1e-3"]);
    let fabric = scene.fabric.resolve().unwrap();
    let base = toile::fabric::find("F5").unwrap();
    assert_eq!(fabric.name, "F5");
    assert_eq!(fabric.thickness, 1e-3);
    assert_eq!(fabric.young_warp, base.young_warp);
}

#[test]
fn a_default_output_rate_follows_a_longer_step() {
    let text = with("[output]\nrate = 100.0\n", "");
    assert_eq!(good(&text, &[]).output.rate, 100.0);
    assert_eq!(good(&text, &["method.dt=0.05"]).output.rate, 20.0);
}

#[test]
fn overrides_win_over_the_document_and_later_ones_over_earlier() {
    let scene = good(
        GOOD,
        &["damping=0", "obstacle.table.friction=0.5", "damping=0.2"],
    );
    assert_eq!(scene.damping, 0.2);
    assert_eq!(scene.obstacle["table"].friction, 0.5);
    let scene = good(GOOD, &["gravity=[0, 0, -1]", "perturbation.seed=7"]);
    assert_eq!(scene.gravity, [0.0, 0.0, -1.0]);
    assert_eq!(scene.perturbation.seed, 7);
    let ball = "obstacle.ball.shape={ kind = \"sphere\", radius = 0.02 }";
    assert_eq!(good(GOOD, &[ball]).obstacle.len(), 2);
}

#[test]
fn built_in_scenes_are_checked_and_survive_being_written() {
    assert_eq!(
        library::names().collect::<Vec<_>>(),
        [
            "drape-table",
            "drape-table-air",
            "free-fall",
            "cantilever",
            "four-edges",
            "three-edges",
            "held-point",
            "falling-sheet",
            "drape-table-part",
            "drape-podium",
            "drapemeter",
            "drapemeter-resting",
            "towel-fold",
            "strip-release",
            "fling"
        ]
    );
    for name in library::names() {
        let (scene, warnings) = parse(library::text(name).unwrap(), &[]).unwrap();
        assert_eq!(scene.name, name, "a scene is called like its file");
        assert_eq!(warnings, vec![], "{name}");
        assert_eq!(parse(&scene.to_toml(), &[]).unwrap().0, scene, "{name}");
        assert_eq!(scene.check(), Ok(vec![]), "{name}");
    }
    assert_eq!(library::text("drape"), None);
}

/// Fig. 5 to 7 of the paper: F1, F5 and F9 must start above the table, half a thickness at least.

#[test]
fn drape_table_starts_above_the_table_with_each_of_its_fabrics() {
    for name in ["F1", "F5", "F9"] {
        let set = format!("fabric.name={name}");
        let scene = good(library::text("drape-table").unwrap(), &[&set]);
        let half = 0.5 * scene.fabric.resolve().unwrap().thickness;
        let gap = scene.sheet.position[2] - half;
        assert!((0.0..2e-4).contains(&gap), "{name}: {gap}");
    }
}

/// Every key of the table at once: what the table allows, serde must take, and give back.

#[test]
fn every_key_survives_being_written() {
    let full = r#"
name = "full"
description = "Every key"
duration = 0.5
gravity = [0.1, 0.2, -9.0]
damping = 0.2
accept = ["air", "obstacles"]
[sheet]
outline = { kind = "annulus", outer = 0.3, inner = 0.1 }
triangles = 900
refine = { region = { kind = "ring", outer = 0.2, inner = 0.1 }, factor = 0.5 }
jitter = 0.2
mesh_seed = 3
warp_angle = 45
position = [0.0, 0.0, 1.0]
rotation = [10.0, 20.0, 30.0]
[fabric]
name = "felt"
areal_density = 0.3
thickness = 1e-3
young_warp = 1e6
young_weft = 2e6
shear_modulus = 5e5
rigidity_warp = 2e-5
rigidity_weft = 3e-5
poisson_warp = 0.3
poisson_weft = 0.4
twist = "none"
poisson = "symmetrised"
[support]
a = { kind = "pin", region = { kind = "boundary" }, axes = "xz", displacement = [0.0, 0.0, 0.01] }
b = { kind = "clamp", region = { kind = "box", min = [0.0, 0.0], max = [0.1, 0.1] } }
c = { kind = "clamp", region = { kind = "disc", diameter = 0.1 } }
d = { kind = "pin", region = { kind = "point", at = [0.1, 0.0] } }
[load]
hem = { region = { kind = "boundary" }, force = [0.0, 0.1, -0.2] }
[support.e]
kind = "pin"
region = { kind = "point", at = [0.0, 0.1] }
[support.e.motion]
law = "smooth"
times = [0.0, 1.0]
displacements = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.1]]
rotations = [[0.0, 0.0, 0.0], [0.0, 0.0, 45.0]]
[obstacle]
plane = { shape = { kind = "plane" }, position = [0.0, 0.0, -1.0], rotation = [0.0, 5.0, 0.0] }
ball = { shape = { kind = "sphere", radius = 0.1 }, linear_velocity = [0.1, 0.0, 0.0] }
plate = { shape = { kind = "disc", radius = 0.1 }, angular_velocity = [0.0, 0.0, 1.0] }
post = { shape = { kind = "cylinder", radius = 0.1, length = 0.2 }, friction = 0.2, friction_static = 0.3 }
pill = { shape = { kind = "capsule", radius = 0.1, length = 0.2 } }
[obstacle.jaw]
shape = { kind = "disc", radius = 0.1 }
[obstacle.jaw.motion]
law = "linear"
times = [0.0, 1.0]
positions = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.1]]
rotations = [[0.0, 0.0, 0.0], [0.0, 0.0, 45.0]]
[overlap]
rule = "refuse"
time = 0.1
speed = 0.2
[air]
fluid_damping = 0.5
velocity = [1.0, 0.0, -2.0]
region = { min = [-1.0, -1.0, -1.0], max = [1.0, 1.0, 1.0] }
rise = 0.1
start = 0.2
hold = 0.3
[layers]
contact = "off"
friction = 0.25
thickness = 2e-3
[perturbation]
amplitude = 1e-4
seed = 9223372036854775807
fade = 0.02
[method]
scheme = "generalised-alpha"
dt = 1e-3
tolerance = 1e-5
max_iterations = 20
substep = 1e-5
step_tolerance = 1e-4
solver = "newton"
limit = "ignore"
rho_infinity = 0.5
[output]
rate = 50
mesh_rate = 10
keyframe_interval = 0.5
[observe]
rim = { points = [[0.15, 0.0], [0.0, 0.15]], axis = "y" }
"#;
    let (scene, _) = parse(full, &[]).unwrap();
    assert_eq!(parse(&scene.to_toml(), &[]).unwrap().0, scene);
    for side in ["x-min", "x-max", "y-min", "y-max"] {
        good(&with("x-min", side), &[]);
    }
    for scheme in toile::scene::Scheme::ALL {
        let set = format!("method.scheme={}", scheme.name());
        assert_eq!(good(GOOD, &[&set]).method.scheme, scheme);
    }
}

#[test]
fn a_scene_made_by_the_program_is_checked_as_strictly() {
    let mut scene = good(GOOD, &[]);
    scene.method.dt = f64::NAN;
    let message = scene.check().unwrap_err().to_string();
    assert!(
        message.starts_with("method.dt = NaN: out of range"),
        "{message}"
    );
    let mut scene = good(GOOD, &[]);
    scene.perturbation.seed = u64::MAX;
    assert!(scene.check().is_err(), "TOML holds 63 bits");
}

#[test]
fn what_is_unwise_but_possible_is_remarked() {
    let (_, warnings) = parse(GOOD, &sets(&["sheet.edge=0.03"])).unwrap();
    assert!(
        matches!(warnings[..], [Warning::CoarseMesh { edge: 0.03, bending_length }] if (bending_length - 0.0235).abs() < 1e-3),
        "{warnings:?}"
    );
    let (_, warnings) = parse(GOOD, &sets(&["output.rate=70", "duration=0.123"])).unwrap();
    let texts: Vec<_> = warnings.iter().map(ToString::to_string).collect();
    assert!(
        texts[0].contains("outputs come at 66.666667 Hz"),
        "{texts:?}"
    );
    assert!(texts[1].contains("the run ends at 0.125 s"), "{texts:?}");
}

/// The scene that README.md shows a newcomer.
#[test]
fn the_scene_of_the_readme_is_taken_without_remarks() {
    let readme = include_str!("../../README.md");
    let mut blocks = readme
        .split("```toml\n")
        .map(|text| text.split("```").next().unwrap());
    let text = blocks.find(|text| text.contains("napkin")).unwrap();
    let (scene, warnings) = parse(text, &[]).unwrap();
    assert_eq!(scene.name, "napkin");
    assert_eq!(warnings, vec![]);
}
