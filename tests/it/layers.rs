//! The sheet against itself: what starts apart stays apart, and what a scene leaves out is told.

use toile::contact::layers::crossings;
use toile::scene::{LayersSpec, Scene};
use toile::sim::{Energies, Simulation};

use crate::lab::{built_in, simulation};

/// Edges through faces, among all pairs of faces whose boxes overlap.
pub fn crossed(simulation: &Simulation) -> usize {
    let (mesh, positions) = (&simulation.model().mesh, &simulation.state().positions);
    let bounds = |f: u32| {
        let [a, b, c] = mesh.faces[f as usize].map(|v| positions[v as usize]);
        (a.inf(&b).inf(&c), a.sup(&b).sup(&c))
    };
    let all: Vec<_> = (0..mesh.faces.len() as u32).map(bounds).collect();
    let overlap = |f: u32, g: u32| {
        let ((low, high), (other_low, other_high)) = (all[f as usize], all[g as usize]);
        (0..3).all(|k| low[k] <= other_high[k] && other_low[k] <= high[k])
    };
    let count = all.len() as u32;
    let pairs = (0..count).flat_map(|f| (f + 1..count).map(move |g| [f, g]));
    crossings(mesh, positions, pairs.filter(|[f, g]| overlap(*f, *g))).len()
}

/// All that the ledger holds \[J\].
pub fn total(e: &Energies) -> f64 {
    e.kinetic + e.stretch + e.bend + e.gravity + e.contact + e.damping + e.friction
        - e.supports
        - e.air
}

pub fn held(set: &[&str]) -> Scene {
    let mut all = vec!["sheet.triangles=500", "duration=0.6"];
    all.extend(set);
    built_in("held-point", &all)
}

/// The paper's Fig. 9: with layers nothing crosses, the ledger closes, no strain runs away, at two outer steps and two
/// meshes.
#[test]
fn a_held_square_does_not_cross_itself() {
    for (triangles, dt) in [(500, 1.0 / 60.0), (500, 1.0 / 240.0), (1000, 1.0 / 60.0)] {
        let triangles = format!("sheet.triangles={triangles}");
        let dt = format!("method.dt={dt}");
        let name = format!("{triangles}, {dt}");
        let mut simulation = simulation(&held(&["output.rate=50", &triangles, &dt]));
        let (start, mut touched, mut strain, mut scale) =
            (total(&simulation.report().energies), 0, 0.0f64, 0.0f64);
        for step in 0..simulation.model().scene.steps() {
            let report = simulation
                .step()
                .unwrap_or_else(|e| panic!("{name}: {e}"))
                .clone();
            touched += report.layer_contacts;
            strain = strain.max(report.largest_strain);
            scale = scale.max(-report.energies.gravity);
            assert_eq!(report.crossings, 0, "{name}, step {step}");
            let off = (total(&report.energies) - start).abs();
            assert!(
                off < 0.02 * scale + 1e-6,
                "{name}, step {step}: the ledger is off by {off}"
            );
            if step % 4 == 0 {
                assert_eq!(crossed(&simulation), 0, "{name}, step {step}");
            }
        }
        assert!(touched > 5, "{name}: {touched} contacts");
        assert!(strain < 0.1, "{name}: strain {strain}");
        assert!(simulation.report().neglected.is_empty());
    }
}

/// Steps longer than a fold takes to fall on another, which nothing at their start foretells: layers that met in one are
/// found when it is over, and it is taken again with an eye on them.
#[test]
fn layers_that_meet_within_a_step_are_found_afterwards() {
    for triangles in [300, 500] {
        let name = format!("sheet.triangles={triangles}");
        let mut simulation = simulation(&held(&["output.rate=5", "method.dt=0.2", &name]));
        let mut again = 0;
        for _ in 0..3 {
            let report = simulation.step().unwrap().clone();
            again += report.work.rejected;
            let (at, strain) = (report.time, report.largest_strain);
            assert_eq!(crossed(&simulation), 0, "{name}, {at} s");
            assert!(strain < 0.1, "{name}, {at} s: strain {strain}");
        }
        assert!(again > 0, "{name}: nothing met unforeseen");
    }
}

/// Without layers the same square passes through itself, and every report from then on says that it should not.
#[test]
fn leaving_layers_out_is_told() {
    let mut simulation = simulation(&held(&["layers.contact=off"]));
    let mut told = None;
    for step in 0..simulation.model().scene.steps() {
        let report = simulation.step().unwrap().clone();
        let flagged = report.neglected == ["layers"];
        assert!(flagged || report.neglected.is_empty());
        if flagged && told.is_none() {
            told = Some(step);
        }
        assert!(
            flagged || crossed(&simulation) == 0,
            "step {step}: crossed, not told"
        );
    }
    assert!(
        told.is_some_and(|step| step > 5),
        "{told:?}: told from the start, or never"
    );
    assert!(crossed(&simulation) > 0, "the scene does not cross itself");
}

/// A run with layers goes on from a kept state with the same bits.
#[test]
fn layers_resume_with_the_same_bits() {
    let scene = held(&["layers={ friction = 0.4 }"]);
    let mut whole = simulation(&scene);
    let mut touched = 0;
    while touched == 0 {
        touched = whole.step().unwrap().layer_contacts;
        assert!(whole.report().step < 60, "nothing touches");
    }
    let mut resumed = simulation(&scene);
    resumed.resume(whole.state().clone()).unwrap();
    for _ in 0..3 {
        assert_eq!(whole.step().unwrap(), resumed.step().unwrap());
    }
}

/// A square that falls flat on a table, folded once already: in the air it touches nothing, then lies on itself. At two outer
/// steps and two meshes, explicit and implicit.
#[test]
fn a_sheet_falls_on_itself() {
    for (scheme, edge, dt) in [
        ("central-difference", 8e-3, 1.0 / 60.0),
        ("central-difference", 6e-3, 1.0 / 240.0),
        ("bdf2", 8e-3, 1.0 / 240.0),
        ("bdf2", 6e-3, 1.0 / 240.0),
    ] {
        let name = format!("{scheme}, edge {edge}, dt {dt}");
        let sets = [
            format!("method.scheme={scheme}"),
            format!("method.dt={dt}"),
            format!("sheet.edge={edge}"),
        ];
        let mut set: Vec<&str> = sets.iter().map(String::as_str).collect();
        set.extend(["duration=0.5", "output.rate=50"]);
        let scene = scene_of_a_fall(&set);
        let mut simulation = simulation(&scene);
        let (mut touched, mut strain, mut gap) = (0, 0.0f64, f64::INFINITY);
        for step in 0..scene.steps() {
            let report = simulation.step().unwrap_or_else(|e| panic!("{name}: {e}"));
            touched += report.layer_contacts;
            strain = strain.max(report.largest_strain);
            gap = gap.min(report.layer_gap);
            assert_eq!(report.crossings, 0, "{name}, step {step}");
        }
        assert_eq!(crossed(&simulation), 0, "{name}");
        let nearest = gap / simulation.model().fabric.thickness;
        println!(
            "{name}: nearest {nearest:.3} thicknesses, strain {strain:.4}, {touched} contacts"
        );
        assert!(touched > 0 && strain < 0.1, "{name}: {touched}, {strain}");
    }
}

/// Where the sheet does not touch itself, layers change not a bit, whatever the scheme and whether the scene says a word of
/// them: they are searched for, and that is all.
#[test]
fn layers_that_do_not_touch_change_nothing() {
    for (name, scheme, set) in [
        ("drape-table", "central-difference", "duration=0.2"),
        ("fling", "generalised-alpha", "duration=0.1"),
        ("held-point", "central-difference", "duration=0.12"),
        ("four-edges", "bdf2", "duration=0.1"),
        ("drape-table", "backward-euler", "duration=0.1"),
    ] {
        let scheme = format!("method.scheme={scheme}");
        let with = built_in(name, &[&scheme, set, "sheet.triangles=600"]);
        let scene = |layers| Scene {
            layers,
            ..with.clone()
        };
        let said = [Some(LayersSpec::default()), Some(LayersSpec::OFF), None];
        let mut runs = said.map(|layers| simulation(&scene(layers)));
        assert!(runs[0].model().layers.is_some() && runs[1].model().layers.is_none());
        for step in 0..with.steps() {
            let [on, off, unsaid] = runs.each_mut().map(|run| run.step().unwrap().clone());
            assert_eq!(on.layer_contacts, 0, "{name}, step {step}");
            assert_eq!(on.digest, off.digest, "{name}, {scheme}, step {step}");
            assert_eq!(on.digest, unsaid.digest, "{name}, {scheme}, step {step}");
        }
    }
}

/// A strip that stands on its short side falls and folds onto itself.
pub fn scene_of_a_fall(set: &[&str]) -> Scene {
    let mut all = vec!["layers={ friction = 0.3 }", "fabric.name=F1"];
    all.extend([
        "sheet.outline={ kind = \"rectangle\", length = 0.2, width = 0.04 }",
        "sheet.position=[0.0, 0.0, 0.1]",
        "support.hand.region={ kind = \"x-min\" }",
        "obstacle.floor.shape={ kind = \"plane\" }",
        "obstacle.floor.position=[0.0, 0.0, -0.001]",
        "observe.top.points=[[0.1, 0.0]]",
        "observe.top_aside.points=[[0.1, 0.0]]",
    ]);
    all.extend(set);
    built_in("falling-sheet", &all)
}

/// A start that crosses itself: the run goes on, reports it, and gains no energy.
#[test]
fn an_entangled_start_is_reported_and_gains_nothing() {
    for scheme in ["central-difference", "bdf2"] {
        let scheme = format!("method.scheme={scheme}");
        let scene = held(&[
            &scheme,
            "sheet.triangles=600",
            "gravity=[0.0, 0.0, 0.0]",
            "layers={ friction = 0.2 }",
        ]);
        let mut simulation = simulation(&scene);
        let mut state = simulation.state().clone();
        // One corner is drawn through the middle of a quarter of the square.
        for (position, p) in state
            .positions
            .iter_mut()
            .zip(&simulation.model().mesh.outline)
        {
            let far = ((p.x + p.y) / 2f64.sqrt()).max(0.0);
            let angle = (far / 0.02).min(4.2);
            let turned = nalgebra::Vector2::new(0.02 * angle.sin(), 0.02 * (1.0 - angle.cos()));
            let along = (far - 0.02 * angle).max(0.0);
            let way = turned + nalgebra::Vector2::new(angle.cos(), angle.sin()) * along;
            let shift = (way.x - far) / 2f64.sqrt();
            *position += nalgebra::Vector3::new(shift, shift, way.y);
        }
        simulation.resume(state).unwrap();
        let start = simulation.report().clone();
        assert!(start.crossings > 0, "the start does not cross");
        let before = total(&start.energies);
        for step in 0..10 {
            let report = simulation
                .step()
                .unwrap_or_else(|e| panic!("{scheme}: {e}"));
            assert!(report.largest_strain.is_finite(), "step {step}");
            let gained = total(&report.energies) - before;
            let scale = before.abs().max(1e-6);
            assert!(
                gained < 0.02 * scale,
                "{scheme}, step {step}: gained {gained} of {before}"
            );
        }
        println!(
            "{scheme}: {} crossings at first, {} now",
            start.crossings,
            simulation.report().crossings
        );
    }
}
