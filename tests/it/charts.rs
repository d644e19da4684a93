//! The work-precision chart: nothing that failed is left out, what is in its CSV is not run again.

use toile::chart::plot::{self, CROSS_GLYPH, Caption};
use toile::chart::png_of_svg;
use toile::chart::reference::Reference;
use toile::chart::rows::{self, Asked, Key, Outcome, Row};
use toile::chart::work_precision::{ChartError, Problem};
use toile::scene::{Scheme, library, parse};

fn row(scheme: Scheme, asked: Asked, outcome: Outcome) -> Row {
    Row {
        key: Key {
            scene: "strip-release".into(),
            fabric: "F1".into(),
            mesh: "triangles=600".into(),
            scheme,
            asked,
        },
        triangles: 604,
        dt: 1.0 / 3.0 * 1e-3,
        tolerance: 1e-6,
        outcome,
        cpu: 0.1 + 0.2,
        simulated: 0.3,
        steps: 900,
        substeps: 901,
        rejected: 1,
        iterations: 2700,
        factorisations: 2699,
    }
}

fn rows_with_failures() -> Vec<Row> {
    let died = |message: &str| Outcome::Died {
        time: 0.08,
        message: message.into(),
    };
    vec![
        row(
            Scheme::Bdf2,
            Asked::Step(1e-3),
            Outcome::Done { error: 7.25e-4 },
        ),
        row(
            Scheme::BackwardEuler,
            Asked::Step(1e-3),
            Outcome::Done { error: 0.031 },
        ),
        row(
            Scheme::GeneralisedAlpha,
            Asked::Step(5e-3),
            died("step 16, \"worst\" at 3; halve it"),
        ),
        row(
            Scheme::CentralDifference,
            Asked::Limit(1),
            died("not finite"),
        ),
    ]
}

fn caption() -> Caption {
    Caption {
        scene: "strip-release".into(),
        title: "a <title>".into(),
        subtitle: "F1".into(),
        error_over: "length".into(),
        uncertainty: 1.3e-4,
        source: "a chain".into(),
    }
}

#[test]
fn consistency_rows_survive_csv() {
    let rows = rows_with_failures();
    let text = rows::to_csv(&rows);
    assert_eq!(text.lines().count(), 5);
    assert_eq!(rows::from_csv(&text).unwrap(), rows);
    let damaged = text.replace("7.25e-4", "small");
    let refusal = rows::from_csv(&damaged).unwrap_err().to_string();
    assert_eq!(refusal, "line 2: column error is `small`");
    assert!(rows::from_csv("a,b\n1,2\n").is_err());
}

/// Each failed run is one cross in each panel, with its step and the time at which it died.
#[test]
fn verify_failed_runs_are_crosses() {
    let svg = plot::chart(&caption(), &rows_with_failures()).unwrap();
    assert_eq!(svg.matches(CROSS_GLYPH).count(), 4);
    assert_eq!(svg.matches("5 ms, died at 0.08 s").count(), 2);
    let healthy = &rows_with_failures()[..2];
    let svg = plot::chart(&caption(), healthy).unwrap();
    assert_eq!(svg.matches(CROSS_GLYPH).count(), 0);
    let only_failures = &rows_with_failures()[2..];
    let svg = plot::chart(&caption(), only_failures).unwrap();
    assert_eq!(svg.matches(CROSS_GLYPH).count(), 4);
    assert!(png_of_svg(&svg, 1.0).unwrap().starts_with(b"\x89PNG"));
}

fn problem(name: &str) -> Result<Problem, ChartError> {
    Problem::of(parse(library::text(name).unwrap(), &[]).unwrap().0)
}

/// A row read back has the key under which it was planned, so that it is not run again.
#[test]
fn consistency_a_planned_run_is_found_in_its_csv() {
    let problem = problem("strip-release").unwrap();
    let plan = problem.plan();
    let rows: Vec<Row> = plan
        .iter()
        .map(|key| Row {
            key: key.clone(),
            ..rows_with_failures()[0].clone()
        })
        .collect();
    let back = rows::from_csv(&rows::to_csv(&rows)).unwrap();
    assert!(
        plan.iter()
            .all(|key| back.iter().any(|row| row.key == *key))
    );
    for scheme in Scheme::IN_TIME {
        assert!(
            plan.iter().any(|key| key.scheme == scheme),
            "{} is not run",
            scheme.name()
        );
    }
}

/// A run counts its own CPU time and steps, and its error is finite or it says when it died.
#[test]
fn consistency_a_run_becomes_a_row() {
    let mut problem = problem("strip-release").unwrap();
    problem.scene.sheet.triangles = Some(60);
    let reference = problem.reference.clone().unwrap();
    let plan = problem.plan();
    let key = plan.iter().find(|k| k.scheme == Scheme::Bdf2).unwrap();
    let (mut ticks, mut parts) = (0.0, vec![]);
    let mut clock = || {
        ticks += 0.5;
        ticks
    };
    let row = problem.run(key, &reference, &mut clock, &mut |part| parts.push(part));
    assert_eq!(row.key, *key);
    assert_eq!(row.cpu, 0.5 * row.steps as f64);
    assert!(parts.windows(2).all(|p| p[0] < p[1]));
    match row.outcome {
        Outcome::Done { error } => {
            assert!(error.is_finite());
            assert!((row.simulated - 0.3).abs() < 1e-12 && row.steps == 30);
        }
        Outcome::Died { time, .. } => assert!(time < 0.3),
    }
}

#[test]
fn consistency_references_survive_csv() {
    let reference = Reference::strip_release().unwrap();
    assert_eq!(reference.times.len(), 12);
    assert!((reference.displacements[9].z + 0.0745004).abs() < 1e-12);
    assert!(reference.uncertainty < 1.4e-5);
    assert_eq!(Reference::from_csv(&reference.to_csv()).unwrap(), reference);
    assert!(problem("free-fall").is_err());
}
