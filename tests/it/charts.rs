//! The work-precision chart: nothing that failed is left out, what is in its CSV is not run again.

use toile::chart::peers::Peer;
use toile::chart::plot::{self, CROSS_GLYPH, Caption, LEFT_GLYPH};
use toile::chart::png_of_svg;
use toile::chart::reference::Reference;
use toile::chart::rows::{self, Asked, Key, Outcome, Parts, Row};
use toile::chart::stability::{self, Fate};
use toile::chart::stability_plot;
use toile::chart::work_precision::{ChartError, Problem};
use toile::scene::{Method, Scheme, library, parse};
use toile::sim::Work;

fn row(method: impl Into<Method>, asked: Asked, outcome: Outcome) -> Row {
    Row {
        key: Key {
            scene: "strip-release".into(),
            fabric: "F1".into(),
            mesh: "triangles=600".into(),
            method: method.into(),
            asked,
        },
        triangles: 604,
        dt: 1.0 / 3.0 * 1e-3,
        tolerance: 1e-6,
        outcome,
        cpu: 0.1 + 0.2,
        simulated: 0.3,
        steps: 900,
        starved: 4,
        work: Work {
            substeps: 901,
            rejected: 1,
            iterations: 2700,
            evaluations: 3700,
            factorisations: 2699,
            indefinite: 7,
            constant: 3,
            solves: 2700,
            halvings: 12,
            ..Work::default()
        },
        parts: Parts {
            algebra: Some(1.0 / 3.0 * 1e-6),
            time: Some(2e-3),
            space: None,
        },
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
        row(
            Scheme::Bdf2,
            Asked::Step(2.5e-4),
            Outcome::Unfinished { time: 0.04 },
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
        peers: vec![("another 4 ms".into(), 17.0, 0.1)],
    }
}

#[test]
fn consistency_rows_survive_csv() {
    let rows = rows_with_failures();
    let text = rows::to_csv(&rows);
    assert_eq!(text.lines().count(), 6);
    assert_eq!(rows::from_csv(&text).unwrap(), rows);
    let damaged = text.replace("7.25e-4", "small");
    let refusal = rows::from_csv(&damaged).unwrap_err().to_string();
    assert_eq!(refusal, "line 2: column error is `small`");
    assert!(rows::from_csv("a,b\n1,2\n").is_err());
}

/// Each failed run is one cross in each panel, with its step and the time at which it died; one that was left is shown,
/// too.
#[test]
fn verify_failed_runs_are_crosses() {
    let svg = plot::chart(&caption(), &rows_with_failures()).unwrap();
    assert_eq!(svg.matches(CROSS_GLYPH).count(), 4);
    assert_eq!(svg.matches("5 ms, died at 0.08 s").count(), 2);
    // One more in each panel says what it means.
    assert_eq!(svg.matches(LEFT_GLYPH).count(), 4);
    assert_eq!(svg.matches("0.25 ms, too dear, left at 0.04 s").count(), 2);
    let healthy = &rows_with_failures()[..2];
    let svg = plot::chart(&caption(), healthy).unwrap();
    assert_eq!(svg.matches(CROSS_GLYPH).count(), 0);
    let only_failures = &rows_with_failures()[2..];
    let svg = plot::chart(&caption(), only_failures).unwrap();
    assert_eq!(svg.matches(CROSS_GLYPH).count(), 4);
    assert!(png_of_svg(&svg, 1.0).unwrap().starts_with(b"\x89PNG"));
}

/// Another program's runs are points with their name; what they are compared by is the height.
#[test]
fn consistency_of_peers() {
    let svg = plot::chart(&caption(), &rows_with_failures()).unwrap();
    assert_eq!(svg.matches("another 4 ms").count(), 1);
    let peers = Peer::on("drape-table");
    assert_eq!(peers.len(), 6);
    let fall = Reference {
        times: vec![0.05, 0.1],
        displacements: vec![nalgebra::Vector3::zeros(); 2],
        uncertainty: 0.0,
        source: "none".into(),
    };
    for peer in &peers {
        let fallen = peer.distance(&fall);
        assert!((0.02..0.03).contains(&fallen), "{peer:?}: {fallen}");
    }
    assert!(Peer::on("strip-release").is_empty());
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
    for method in Method::IN_TIME {
        for triangles in &problem.meshes {
            let mesh = format!("triangles={triangles}");
            let runs = plan
                .iter()
                .filter(|key| key.method == method && key.mesh == mesh);
            assert!(runs.count() >= 2, "{} is not run", method.name());
        }
    }
}

/// Past its limit the explicit scheme dies, and stands on the chart as what it is.
#[test]
fn a_run_past_the_limit_dies_on_the_chart() {
    for name in ["strip-release", "drape-table"] {
        let mut problem = problem(name).unwrap();
        problem.meshes = vec![400];
        let plan = problem.plan();
        let past = plan.iter().find(|key| key.asked == Asked::Past(2)).unwrap();
        let reference = problem.truth_on(400, &mut |_| {}).unwrap();
        let row = problem.run(past, (&reference, None), &mut || 0.0, &mut |_| {});
        let Outcome::Died { time, message } = row.outcome else {
            panic!("{name} ended: {:?}", row.outcome);
        };
        assert!(time > 0.0 && time < problem.scene.duration, "{time}");
        assert!(message.contains("failed even at"), "{message}");
    }
}

/// A run counts its own CPU time and steps, and its error is finite or it says when it died.
#[test]
fn consistency_a_run_becomes_a_row() {
    let mut problem = problem("strip-release").unwrap();
    problem.meshes = vec![60];
    let reference = problem.reference.clone().unwrap();
    let own = problem.truth_on(60, &mut |_| {}).unwrap();
    let plan = problem.plan();
    let key = plan
        .iter()
        .find(|k| k.method == Scheme::Bdf2.into())
        .unwrap();
    let (mut ticks, mut parts) = (0.0, vec![]);
    let mut clock = || {
        ticks += 0.5;
        ticks
    };
    let row = problem.run(key, (&reference, Some(&own)), &mut clock, &mut |part| {
        parts.push(part);
    });
    assert_eq!(row.key, *key);
    assert_eq!(row.cpu, 0.5 * row.steps as f64);
    assert!(parts.windows(2).all(|p| p[0] < p[1]));
    match row.outcome {
        Outcome::Done { error } => {
            assert!(error.is_finite());
            let [algebra, time, space] =
                [row.parts.algebra, row.parts.time, row.parts.space].map(Option::unwrap);
            println!("{error}: algebra {algebra:e}, time {time:e}, space {space:e}");
            // What is apart from the reference is apart by time or by space; the algebra is the least.
            assert!(error <= time + space + 1e-12 && algebra < 0.1 * time);
            assert!((row.simulated - 0.3).abs() < 1e-12 && row.steps == 30);
        }
        Outcome::Died { time, .. } => assert!(time < 0.3),
        Outcome::Unfinished { .. } => panic!("it may cost anything"),
    }
    problem.budget = 4.9;
    let row = problem.run(key, (&reference, Some(&own)), &mut clock, &mut |_| {});
    assert_eq!(row.outcome, Outcome::Unfinished { time: 0.1 });
    assert_eq!((row.cpu, row.steps, row.parts), (5.0, 10, Parts::default()));
}

#[test]
fn consistency_references_survive_csv() {
    let reference = Reference::strip_release().unwrap();
    assert_eq!(reference.times.len(), 12);
    assert!((reference.displacements[9].z + 0.0745004).abs() < 1e-12);
    assert!(reference.uncertainty < 1.4e-5);
    assert_eq!(Reference::from_csv(&reference.to_csv()).unwrap(), reference);
    assert!(problem("drapemeter-resting").is_err());
}

/// The map of stability: right inside the explicit limit, lost outside, and every implicit scheme right at a millisecond.
#[test]
fn verify_the_map_of_stability() {
    let scene = parse(library::text("four-edges").unwrap(), &[]).unwrap().0;
    let cells = stability::cells(&scene).unwrap();
    let places = stability::STIFFNESSES.len() * stability::MESHES.len();
    assert_eq!(cells.len(), places);
    // Four times the frequency, half the step.
    let limit = |stiffness: f64| {
        cells
            .iter()
            .find(|c| c.stiffness == stiffness)
            .unwrap()
            .limit
    };
    let shorter = limit(1.0) / limit(100.0);
    assert!((shorter / 10.0 - 1.0).abs() < 0.1, "{shorter}");
    let cell = &cells[1];
    let truth = cell.truth(&mut |_| {}).unwrap();
    let fate = |method: Method, dt: f64| {
        let key = cell.key(method, dt);
        let row = cell.run(&key, &truth, &mut || 0.0, &mut |_| {});
        assert_eq!(row.key, key);
        (Fate::of(&row), row)
    };
    let explicit = Method::from(Scheme::CentralDifference);
    let mut rows = vec![];
    for dt in stability::STEPS {
        let (fate, row) = fate(explicit, dt);
        let expected = match dt {
            dt if dt > 1.03 * cell.limit => Fate::Lost,
            dt if dt < 0.97 * cell.limit => Fate::Right,
            _ => fate,
        };
        assert_eq!(
            fate, expected,
            "{dt} s against a limit of {} s: {:?}",
            cell.limit, row.outcome
        );
        rows.push(row);
    }
    assert!(
        rows.iter().any(|r| Fate::of(r) == Fate::Right),
        "{}",
        cell.limit
    );
    for scheme in [
        Scheme::BackwardEuler,
        Scheme::Bdf2,
        Scheme::GeneralisedAlpha,
    ] {
        let (fate, row) = fate(scheme.into(), 1e-3);
        assert_ne!(fate, Fate::Lost, "{}: {:?}", scheme.name(), row.outcome);
        rows.push(row);
    }
    let svg = stability_plot::map("a map", &cells, &rows).unwrap();
    let lost = rows.iter().filter(|r| Fate::of(r) == Fate::Lost).count();
    // One in the legend.
    assert_eq!(svg.matches(CROSS_GLYPH).count(), lost + 1);
    assert!(svg.contains("central-difference, 50 triangles"));
    assert!(png_of_svg(&svg, 1.0).unwrap().starts_with(b"\x89PNG"));
}
