//! Parts of implicit steps as long as `method.step_tolerance` allows.

use nalgebra::Vector3;
use toile::scene::{Scene, Scheme, parse};
use toile::sim::{Simulation, Work};

use crate::commands::{add, plate, sheet};
use crate::lab::{built_in, simulation};
use crate::order::SOFT;
use crate::scene::{GOOD, sets};

const SCHEMES: [Scheme; 3] = [
    Scheme::BackwardEuler,
    Scheme::Bdf2,
    Scheme::GeneralisedAlpha,
];

/// A coarse strip with soft yarns, so that an order shows (see `order`), with these keys.
fn strip(set: &[&str]) -> Scene {
    built_in("strip-release", &[&SOFT[..], set].concat())
}

/// Places at five times of a run, and what it took.
fn swing(scene: &Scene) -> (Vec<Vector3<f64>>, Work) {
    let mut simulation = simulation(scene);
    let (mut places, mut work) = (vec![], Work::default());
    for step in 1..=scene.steps() {
        let report = simulation.step().unwrap();
        assert!(report.converged, "step {step} missed its tolerance");
        work += report.work;
        if step % (scene.steps() / 5) == 0 {
            places.extend(simulation.state().positions.iter());
        }
    }
    (places, work)
}

fn apart(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b).norm_squared()).sum();
    (squares / a.len() as f64).sqrt()
}

/// In place of a truth, steps so short that their error does not show.
fn truth() -> Vec<Vector3<f64>> {
    swing(&strip(&[
        "method.scheme=generalised-alpha",
        "method.rho_infinity=1.0",
        "method.tolerance=1e-6",
        "method.dt=3.125e-5",
    ]))
    .0
}

/// A part adds c dt^k to the error, so dt goes with the tolerance to the 1/k and the error of the run, a sum of T / dt
/// such, with its power 1 - 1/k: an eighth of the tolerance is a quarter of the error at second order, 1/2.8 at first.
/// Parts double and halve, so each step of the ratio is held to 1.6 times either way.
#[test]
fn the_error_falls_with_the_tolerance() {
    let exact = truth();
    for scheme in SCHEMES {
        let errors = ["1.6e-4", "2e-5", "2.5e-6"].map(|tolerance| {
            let set = [
                &format!("method.scheme={}", scheme.name())[..],
                "method.dt=0.03",
                &format!("method.step_tolerance={tolerance}"),
            ];
            apart(&swing(&strip(&set)).0, &exact)
        });
        let ratios = [errors[0] / errors[1], errors[1] / errors[2]];
        println!("{scheme:?}: errors {errors:.6?} m, ratios {ratios:.2?}");
        let order = if scheme == Scheme::BackwardEuler {
            2.0
        } else {
            3.0
        };
        let expected = 8f64.powf(1.0 - 1.0 / order);
        for ratio in ratios {
            let off = ratio / expected;
            assert!((1.0 / 1.6..1.6).contains(&off), "{scheme:?}: {ratios:.2?}");
        }
    }
}

/// A strip that is let go swings out in half a second, then hangs. Fixed steps have to be short to the end for the sake of
/// the beginning.
#[test]
fn a_run_that_comes_to_rest_costs_less_than_with_equal_steps_of_the_same_error() {
    let calm = |set: &[&str]| {
        let all = [&["damping=3", "duration=0.8"], set].concat();
        swing(&strip(&all))
    };
    let exact = calm(&[
        "method.dt=1e-4",
        "method.scheme=generalised-alpha",
        "method.rho_infinity=1.0",
    ])
    .0;
    let (places, fixed) = calm(&["method.dt=4e-3"]);
    let by_fixed = apart(&places, &exact);
    let (places, controlled) = calm(&["method.dt=0.08", "method.step_tolerance=5e-6"]);
    let by_controlled = apart(&places, &exact);
    println!(
        "fixed: {by_fixed:.2e} m, {fixed:?}\ncontrolled: {by_controlled:.2e} m, {controlled:?}"
    );
    assert!(by_controlled < by_fixed, "{by_controlled} {by_fixed}");
    assert_eq!((fixed.substeps, fixed.solves), (200, 416));
    assert_eq!(
        (controlled.substeps, controlled.rejected, controlled.solves),
        (166, 2, 338)
    );
}

/// A step as long as a frame of a film, and the error of steps forty times shorter.
#[test]
fn a_long_step_is_parted_until_it_is_accurate() {
    let exact = truth();
    let set = ["method.dt=0.015", "method.step_tolerance=1e-6"];
    let (places, work) = swing(&strip(&set));
    let (error, alone) = (
        apart(&places, &exact),
        apart(&swing(&strip(&set[..1])).0, &exact),
    );
    println!("{error:.2e} m with control, {alone:.2e} m without, {work:?}");
    assert!(error < 5e-5 && alone > 40.0 * error, "{error} {alone}");
}

/// The key alone changes nothing: where no part misses the tolerance, they are as without it.
#[test]
fn a_tolerance_that_nothing_misses_changes_no_bit() {
    for scheme in SCHEMES {
        let set = |key: &str| sheet(scheme, &["damping=5.0", key]);
        let digests = ["method.step_tolerance=0.1", "damping=5.0"].map(|key| {
            let mut simulation = simulation(&set(key));
            add(&mut simulation, plate("low", -0.02, 0.5));
            (0..40)
                .map(|_| simulation.step().unwrap().digest)
                .collect::<Vec<_>>()
        });
        assert_eq!(digests[0], digests[1], "{scheme:?}");
    }
}

/// Over a plate 20 mm below: parts are long in the fall, short where the sheet lands at 0.4 m/s, and as long as before
/// within six steps; it bounces and lands again. All that decides is in the state, so that a run which goes on from any
/// step has the same bits.
#[test]
fn a_landing_takes_short_steps_and_resumes_with_the_same_bits() {
    for scheme in SCHEMES {
        let set = [
            "damping=5.0",
            "method.dt=8e-3",
            "method.step_tolerance=1e-5",
        ];
        let scene = sheet(scheme, &set);
        let mut whole = simulation(&scene);
        add(&mut whole, plate("low", -0.02, 0.5));
        let mut parts = vec![];
        for step in 0..40 {
            let kept = whole.state().clone();
            let mut resumed = simulation(&scene);
            resumed.resume(kept).unwrap();
            let report = whole.step().unwrap();
            assert_eq!(resumed.step().unwrap(), report, "{scheme:?}, step {step}");
            assert!(report.converged, "{scheme:?}, step {step}");
            parts.push(report.work.substeps);
        }
        println!("{scheme:?}: parts {parts:?}");
        let (falling, landing) = (parts[9], parts[10]);
        assert!(landing >= 4 * falling, "{scheme:?}: {parts:?}");
        let after = parts[11..17].iter().min().unwrap();
        assert!(*after <= falling, "{scheme:?}: {parts:?}");
    }
}

/// A tolerance below what a landing allows in the shortest part is missed, and the report says so; the run goes on.
#[test]
fn a_tolerance_that_the_shortest_part_misses_is_reported() {
    let set = ["method.dt=8e-3", "method.step_tolerance=1e-9"];
    let mut simulation: Simulation = simulation(&sheet(Scheme::BackwardEuler, &set));
    add(&mut simulation, plate("low", -2e-3, 0.5));
    let missed = (0..4).any(|_| !simulation.step().unwrap().converged);
    assert!(missed);
}

#[test]
fn methods_without_an_estimate_refuse_a_tolerance() {
    for (set, name) in [
        (
            vec!["method.scheme=central-difference"],
            "central-difference",
        ),
        (vec!["method.scheme=equilibrium"], "equilibrium"),
        (
            vec!["method.scheme=backward-euler", "method.solver=xpbd"],
            "xpbd",
        ),
    ] {
        let all = [&set[..], &["method.step_tolerance=1e-4"]].concat();
        let message = parse(GOOD, &sets(&all)).unwrap_err().to_string();
        let expected =
            format!("method.step_tolerance = 0.0001: {name} estimates no error of a step");
        assert!(message.contains(&expected), "{message}");
        assert!(parse(GOOD, &sets(&set)).is_ok());
    }
}
