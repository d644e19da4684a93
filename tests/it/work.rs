//! Work is counted, not timed: a change that makes a scene dearer fails here, on any machine.
//!
//! The counts are exact for a build and a processor. Where a change moves them on purpose, run with `--nocapture`,
//! look at what it costs, and pin the new ones with the reason.

use toile::scene::Scheme;
use toile::sim::{StepReport, Work};

use crate::lab::{built_in, simulation};

/// Work of all steps of a built-in scene that does not touch itself.
fn work(name: &str, set: &[&str]) -> Work {
    let scene = built_in(name, set);
    let mut simulation = simulation(&scene);
    let mut sum = Work::default();
    for _ in 0..scene.steps() {
        let StepReport { work, .. } = simulation.step().unwrap();
        sum += *work;
    }
    println!("{name} {set:?}: {sum:?}");
    // Each report searches the sheet once, whether the scene has layers or not; each implicit substep once more, to see
    // that none met. The explicit scheme looks ahead, and at short runs of substeps while they go on.
    let looks = sum.layer_searches - scene.steps();
    match (scene.touches_itself(), scene.method.scheme) {
        (None, _) => assert_eq!(looks, 0, "{name}"),
        (Some(_), Scheme::CentralDifference) => assert!(looks >= scene.steps(), "{name}"),
        (Some(_), _) => assert_eq!(looks, sum.substeps, "{name}"),
    }
    Work {
        layer_searches: 0,
        layer_pairs: 0,
        ..sum
    }
}

/// A step that converges at once costs one factorisation and one solve an iteration, and one evaluation more.
#[test]
fn work_of_a_released_strip() {
    let sum = work("strip-release", &["sheet.triangles=60", "duration=0.05"]);
    assert_eq!(sum.solves, sum.iterations);
    assert_eq!(sum.factorisations, sum.iterations + sum.indefinite);
    assert_eq!(
        sum,
        Work {
            substeps: 50,
            rejected: 0,
            iterations: 100,
            evaluations: 150,
            factorisations: 100,
            indefinite: 0,
            constant: 0,
            tests: 0,
            solves: 100,
            halvings: 0,
            ..Work::default()
        }
    );
}

#[test]
fn work_of_a_pinned_square() {
    let set = [
        "sheet.triangles=200",
        "duration=0.05",
        "damping=0.1",
        "method.scheme=generalised-alpha",
    ];
    assert_eq!(
        work("four-edges", &set),
        Work {
            substeps: 10,
            rejected: 0,
            iterations: 29,
            evaluations: 39,
            factorisations: 29,
            indefinite: 0,
            constant: 0,
            tests: 0,
            solves: 29,
            halvings: 0,
            ..Work::default()
        }
    );
}

/// Contact, friction, and folds that snap: steps are repeated, tangents are indefinite. Implicit steps are parted where
/// they would carry the sheet far against the table.
#[test]
fn work_of_a_drape_over_a_table() {
    let set = ["sheet.triangles=200", "duration=0.1", "method.dt=0.005"];
    let implicit = [&set[..], &["method.scheme=bdf2"]].concat();
    assert_eq!(
        work("drape-table", &implicit),
        Work {
            substeps: 24,
            rejected: 0,
            iterations: 241,
            evaluations: 382,
            factorisations: 244,
            indefinite: 3,
            constant: 0,
            tests: 0,
            solves: 241,
            halvings: 117,
            ..Work::default()
        }
    );
    let explicit = work("drape-table", &set);
    let passes = Work {
        substeps: 880,
        evaluations: 880,
        ..Work::default()
    };
    assert_eq!(explicit, passes);
}

/// A state of rest is tested to be a minimum, which costs a factorisation that is no tangent of an iterate.
#[test]
fn work_of_a_drape_at_rest() {
    let sum = work("drapemeter", &["sheet.triangles=200"]);
    assert!(sum.tests > 0);
    assert_eq!(
        sum,
        Work {
            substeps: 31,
            rejected: 0,
            iterations: 31,
            evaluations: 67,
            factorisations: 54,
            indefinite: 22,
            constant: 0,
            tests: 1,
            solves: 36,
            halvings: 4,
            ..Work::default()
        }
    );
}
