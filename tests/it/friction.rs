//! Coulomb friction on obstacles: the incline, and the cloth that must stay on its table.

use nalgebra::Vector3;
use toile::scene::Scene;
use toile::sim::Simulation;

use crate::lab::{built_in, run, scene, simulation};

/// Angle of the incline \[rad\].
pub const SLOPE: f64 = 0.3;

/// A square lying on a plane, gravity tilted by [`SLOPE`].
pub fn incline(scheme: &str, friction: f64, duration: f64) -> Scene {
    let (sin, cos) = SLOPE.sin_cos();
    scene(&format!(
        "name = \"incline\"\ndescription = \"A square on a slope\"\nduration = {duration}\n\
         gravity = [{}, 0.0, {}]\n[sheet]\noutline = {{ kind = \"rectangle\", length = 0.05, width = 0.05 }}\n\
         triangles = 100\nposition = [0.0, 0.0, 0.000235]\n[fabric]\nname = \"F1\"\n\
         [obstacle.plane]\nshape = {{ kind = \"plane\" }}\nfriction = {friction}\n\
         [method]\nscheme = \"{scheme}\"\ndt = 2e-3\n",
        9.81 * sin,
        -9.81 * cos
    ))
}

fn mean(list: &[Vector3<f64>]) -> Vector3<f64> {
    list.iter().sum::<Vector3<f64>>() / list.len() as f64
}

fn middle(simulation: &Simulation) -> Vector3<f64> {
    mean(&simulation.state().positions)
}

/// Below the cone the sheet slides with g (sin - mu cos).
#[test]
fn verify_a_sheet_slides_down_a_steep_slope() {
    for scheme in ["central-difference", "bdf2"] {
        let friction = 0.5 * SLOPE.tan();
        let mut simulation = simulation(&incline(scheme, friction, 0.3));
        let mut speeds = vec![];
        for _ in 0..150 {
            simulation.step().unwrap();
            speeds.push(mean(&simulation.state().velocities).x);
        }
        let acceleration = (speeds[149] - speeds[74]) / (75.0 * 2e-3);
        let expected = 9.81 * (SLOPE.sin() - friction * SLOPE.cos());
        let error = acceleration / expected - 1.0;
        println!("{scheme}: {acceleration:.4} m/s², {error:.1e} off");
        assert!(error.abs() < 0.01, "{scheme}: {acceleration} {expected}");
    }
}

/// Inside the cone it stays: once it has settled it does not creep.
#[test]
fn verify_a_sheet_sticks_on_a_gentle_slope() {
    for scheme in ["central-difference", "bdf2"] {
        let mut simulation = simulation(&incline(scheme, 1.2 * SLOPE.tan(), 1.0));
        let mut x = vec![];
        for _ in 0..500 {
            simulation.step().unwrap();
            x.push(middle(&simulation).x);
        }
        let (settling, creep) = (x[249], (x[499] - x[249]) / 0.5);
        println!("{scheme}: moved {settling:.1e} m, then {creep:.1e} m/s");
        assert!(settling.abs() < 2e-4 && creep.abs() < 1e-6, "{scheme}");
    }
}

/// Flapping cloth on a table opens and closes its contacts all the time; the friction must hold it all the same.
#[test]
fn the_draped_cloth_stays_on_its_table() {
    let set = ["sheet.triangles=400", "duration=1.5", "damping=0"];
    let simulation = run(&built_in("drape-table", &set));
    let drift = middle(&simulation).xy().norm();
    println!("drift of the middle: {:.2} mm", drift * 1e3);
    assert!(drift < 5e-3, "{drift}");
}
