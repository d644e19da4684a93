//! The scheme `equilibrium`: it ends on the residual, at a minimum, or says why not.

use crate::lab::{built_in, reading, scene, simulation};
use toile::sim::Simulation;

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

/// Nothing holds it, so it never comes to rest.
#[test]
fn what_cannot_rest_is_an_error() {
    let all = [STILL, &["sheet.triangles=40"]].concat();
    let mut falling = simulation(&built_in("free-fall", &all));
    let before = falling.state().digest();
    let error = falling.step().unwrap_err().to_string();
    assert!(error.contains("no state of rest was found"), "{error}");
    assert_eq!(falling.state().digest(), before);
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
