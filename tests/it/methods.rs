//! The solvers beside Newton: the same equations, the same answers, their own price and failures.

use toile::scene::{Method, Scene, Scheme, Solver};
use toile::sim::{Simulation, Work};

use crate::cli::{assert_refusal, err, out, toile};
use crate::lab::{built_in, reading, simulation};

/// A built-in scene with a method.
fn with(name: &str, method: Method, set: &[&str]) -> Scene {
    let (scheme, solver) = (
        format!("method.scheme={}", method.scheme.name()),
        format!("method.solver={}", method.solver.name()),
    );
    built_in(name, &[&[&*scheme, &*solver], set].concat())
}

fn named(name: &str) -> Method {
    Method::named(name).unwrap()
}

fn run(scene: &Scene) -> (Simulation, Work) {
    let mut simulation = simulation(scene);
    let mut work = Work::default();
    for _ in 0..scene.steps() {
        work += simulation.step().unwrap_or_else(|e| panic!("{e}")).work;
    }
    (simulation, work)
}

#[test]
fn consistency_of_names() {
    for method in Method::IN_TIME {
        assert_eq!(Method::named(&method.name()), Some(method));
    }
    assert_eq!(
        named("quasi-newton"),
        Method {
            scheme: Scheme::Bdf2,
            solver: Solver::QuasiNewton
        }
    );
    assert_eq!(
        named("xpbd"),
        Method {
            scheme: Scheme::BackwardEuler,
            solver: Solver::Xpbd
        }
    );
    let both = named("generalised-alpha+quasi-newton");
    assert_eq!(both.name(), "generalised-alpha+quasi-newton");
    assert_eq!(Method::named("quasi-newton+bdf2"), None);
}

/// Quasi-Newton solves what Newton solves, to the same tolerance, with one constant factorisation a step.
#[test]
fn verify_quasi_newton_takes_newtons_steps() {
    for (name, set) in [
        (
            "strip-release",
            [
                "sheet.triangles=100",
                "duration=0.05",
                "method.tolerance=1e-9",
            ],
        ),
        (
            "drape-table",
            [
                "sheet.triangles=200",
                "duration=0.02",
                "method.tolerance=1e-8",
            ],
        ),
    ] {
        let set = [&set[..], &["method.dt=1e-3", "method.max_iterations=400"]].concat();
        let (newton, _) = run(&with(name, named("bdf2"), &set));
        let (quasi, work) = run(&with(name, named("quasi-newton"), &set));
        let pairs = newton
            .state()
            .positions
            .iter()
            .zip(&quasi.state().positions);
        let apart = pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        println!("{name}: {apart:.1e} m apart, {work:?}");
        assert!(apart < 1e-6, "{name}: {apart} m apart");
        assert_eq!(work.factorisations, work.constant, "{name}: {work:?}");
        assert!(work.constant <= work.substeps + work.rejected);
        assert!(work.iterations > 0 && quasi.report().converged);
    }
}

/// Position-based dynamics goes to the same motion as its substeps shrink, at first order, and says that its
/// equations are not solved.
#[test]
fn verify_xpbd_converges_at_first_order() {
    let set = ["sheet.triangles=60", "duration=0.1", "method.dt=5e-3"];
    let tip = |scene: &Scene| {
        let (simulation, _) = run(scene);
        [reading(&simulation, "tip_x"), reading(&simulation, "tip_z")]
    };
    let exact = tip(&with("strip-release", named("central-difference"), &set));
    let errors = [1e-4, 5e-5, 2.5e-5].map(|substep| {
        let substep = format!("method.substep={substep}");
        let [x, z] = tip(&with(
            "strip-release",
            named("xpbd"),
            &[&set[..], &[&substep]].concat(),
        ));
        (x - exact[0]).hypot(z - exact[1])
    });
    println!("xpbd: {errors:.6?} m at 100, 50, 25 us");
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((0.5..2.2).contains(&order), "order {order} of {errors:?}");
    }
    assert!(errors[2] < 3e-3, "{errors:?}");
    let (coarse, _) = run(&with("strip-release", named("xpbd"), &set));
    let report = coarse.report();
    assert!(
        !report.converged && report.residual > 1e-3,
        "{}",
        report.residual
    );
}

/// The drape over the table with each: contact holds, friction takes energy out.
#[test]
fn consistency_of_contact_with_the_other_solvers() {
    for name in ["quasi-newton", "xpbd"] {
        let scene = with(
            "drape-table",
            named(name),
            &[
                "sheet.triangles=200",
                "duration=0.2",
                "method.dt=2e-3",
                "damping=1",
            ],
        );
        let (simulation, work) = run(&scene);
        let report = simulation.report();
        println!(
            "{name}: corner {:.4}, depth {:.1e}, {work:?}",
            reading(&simulation, "corner"),
            report.deepest_penetration
        );
        assert!(report.contacts > 0, "{name}");
        assert!(
            report.deepest_penetration < 0.2e-3,
            "{name}: {} m deep",
            report.deepest_penetration
        );
        assert!(
            (-0.06..-0.02).contains(&reading(&simulation, "corner")),
            "{name}"
        );
        assert!(report.energies.friction >= 0.0);
    }
}

/// Iterations that do not suffice are a typed error or a report that says so, never a silent answer.
#[test]
fn starvation_is_told() {
    let set = [
        "sheet.triangles=60",
        "method.max_iterations=1",
        "method.tolerance=1e-13",
    ];
    for name in [
        "backward-euler",
        "bdf2",
        "generalised-alpha",
        "quasi-newton",
    ] {
        let mut simulation = simulation(&with("strip-release", named(name), &set));
        let before = simulation.state().digest();
        let diverged = loop {
            if let Err(diverged) = simulation.step() {
                break diverged;
            }
        };
        assert!(diverged.residual > 1e-13, "{name}: {diverged}");
        assert!(
            diverged
                .to_string()
                .contains("method.max_iterations (now 1)"),
            "{diverged}"
        );
        assert_eq!(simulation.state().digest() == before, diverged.step == 1);
    }
    let mut simulation = simulation(&with("strip-release", named("xpbd"), &set));
    assert!(!simulation.step().unwrap().converged);
}

/// A run goes on from any step with the same bits, whatever the method.
#[test]
fn every_method_resumes_bit_for_bit() {
    for method in Method::IN_TIME {
        let set = ["sheet.triangles=100", "method.dt=2e-3", "damping=0.5"];
        let scene = with("drape-table", method, &set);
        let (mut whole, mut resumed) = (simulation(&scene), simulation(&scene));
        for _ in 0..6 {
            whole.step().unwrap();
        }
        resumed.resume(whole.state().clone()).unwrap();
        for step in 0..6 {
            let one = whole.step().unwrap().clone();
            let other = resumed.step().unwrap();
            assert_eq!(one, *other, "{} {step} steps after", method.name());
        }
    }
}

#[test]
fn the_command_line_takes_methods() {
    let dir = tempfile::tempdir().unwrap();
    let args = [
        "run",
        "strip-release",
        "--set",
        "sheet.triangles=60",
        "--duration",
        "0.01",
        "--json",
    ];
    for name in ["quasi-newton", "xpbd", "bdf2+quasi-newton"] {
        let output = toile(dir.path(), &[&args[..], &["--method", name]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", err(&output));
        let said: serde_json::Value = serde_json::from_str(&out(&output)).unwrap();
        assert_eq!(said["converged"], name != "xpbd");
        assert!(said["work"]["evaluations"].as_u64().unwrap() > 0);
    }
    for (name, parts) in [
        ("newmark", ["method.scheme", "newmark"]),
        ("bdf2+xpbd", ["method.solver", "backward-euler"]),
        (
            "central-difference+quasi-newton",
            ["method.solver", "no equations"],
        ),
        ("equilibrium+quasi-newton", ["method.solver", "minimum"]),
    ] {
        let output = toile(dir.path(), &[&args[..], &["--method", name]].concat());
        assert_refusal(&output, 2, &parts);
    }
    let list = out(&toile(dir.path(), &["list", "methods"]));
    assert!(
        list.contains("\nquasi-newton") && list.contains("\nxpbd"),
        "{list}"
    );
}
