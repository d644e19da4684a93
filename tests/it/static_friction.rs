//! Cloth that sticks holds up to the static cone and slides in the kinetic one.

use toile::scene::{Override, Scene, parse};
use toile::sim::Simulation;

use crate::lab::{scene, simulation};

/// A square on a plane in gravity that is tilted by a slope; the plane moves with a velocity.
fn square(scheme: &str, tan: f64, [sliding, sticking]: [f64; 2], velocity: f64) -> Scene {
    let (sin, cos) = tan.atan().sin_cos();
    scene(&format!(
        "name = \"slope\"\ndescription = \"A square on a slope\"\nduration = 1.0\n\
         gravity = [{}, 0.0, {}]\n[sheet]\noutline = {{ kind = \"rectangle\", length = 0.05, width = 0.05 }}\n\
         triangles = 16\nposition = [0.0, 0.0, 0.000244]\n[fabric]\nname = \"F1\"\n\
         [obstacle.plane]\nshape = {{ kind = \"plane\" }}\nfriction = {sliding}\nfriction_static = {sticking}\n\
         linear_velocity = [{velocity:.3}, 0.0, 0.0]\n\
         [method]\nscheme = \"{scheme}\"\ndt = 2e-3\n[output]\nrate = 1.0\n",
        9.81 * sin,
        -9.81 * cos
    ))
}

fn speed(simulation: &Simulation) -> f64 {
    let all = &simulation.state().velocities;
    all.iter().map(|v| v.x).sum::<f64>() / all.len() as f64
}

/// Speeds of the middle after each step.
fn speeds(scene: &Scene, steps: usize) -> Vec<f64> {
    let mut simulation = simulation(scene);
    let mut all = vec![];
    for _ in 0..steps {
        simulation.step().unwrap_or_else(|e| panic!("{e}"));
        all.push(speed(&simulation));
    }
    all
}

const SCHEMES: [&str; 2] = ["bdf2", "central-difference"];

/// One per cent inside the static cone it stays, though the kinetic one is smaller; one per cent outside it slides with the
/// pull that kinetic friction leaves.
#[test]
fn verify_a_sheet_breaks_away_at_the_static_cone() {
    for scheme in SCHEMES {
        let held = speeds(&square(scheme, 0.4, [0.3, 0.404], 0.0), 400);
        let creep = held[200..].iter().map(|v| v.abs()).fold(0.0, f64::max);
        println!("{scheme}: creeps with {creep:.1e} m/s");
        assert!(creep < 1e-6, "{scheme}: {creep}");
        let broken = speeds(&square(scheme, 0.4, [0.3, 0.396], 0.0), 400);
        let pull = 9.81 * (f64::sin(0.4f64.atan()) - 0.3 * f64::cos(0.4f64.atan()));
        let found = (broken[399] - broken[299]) / 0.2;
        println!("{scheme}: slides with {found:.4} m/s² of {pull:.4}");
        assert!((found / pull - 1.0).abs() < 0.01, "{scheme}: {found}");
    }
}

/// What slides is braked by kinetic friction alone until it has stopped; then it holds what only static friction can.
#[test]
fn verify_a_sheet_that_slides_is_not_held_by_the_static_cone() {
    for scheme in SCHEMES {
        let velocity = 0.2;
        let carried = speeds(&square(scheme, 0.0, [0.2, 0.6], velocity), 100);
        let found = (carried[39] - carried[9]) / 0.06;
        println!("{scheme}: taken along with {found:.4} m/s²");
        assert!(
            (found / (0.2 * 9.81) - 1.0).abs() < 0.02,
            "{scheme}: {found}"
        );
        let last = carried[99] / velocity - 1.0;
        assert!(
            last.abs() < 1e-4,
            "{scheme}: {last} off the plane's velocity"
        );
    }
}

#[test]
fn static_friction_is_not_less_than_kinetic() {
    let text = toile::scene::library::text("drape-table").expect("built in");
    let refused = |set: &[&str]| {
        let set: Vec<Override> = set.iter().map(|s| Override::parse(s).unwrap()).collect();
        parse(text, &set).expect_err("refused").to_string()
    };
    let less = refused(&["obstacle.table.friction_static=0.1"]);
    assert!(
        less.contains("obstacle.table.friction_static = 0.1"),
        "{less}"
    );
    assert!(
        less.contains("must be at least obstacle.table.friction = 0.3"),
        "{less}"
    );
    let most = refused(&["obstacle.table.friction_static=11"]);
    assert!(most.contains("from 0 to 10"), "{most}");
    let games = ["method.scheme=backward-euler", "method.solver=xpbd"];
    let games = refused(&[&games[..], &["obstacle.table.friction_static=0.9"]].concat());
    assert!(games.contains("xpbd has no static friction"), "{games}");
}
