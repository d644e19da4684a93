//! A scene that says nothing of layers: its sheet touches itself all the same, where the method can.

use toile::scene::{Scene, parse};
use toile::sim::Simulation;

use crate::lab::simulation;
use crate::layers::{crossed, held, scene_of_a_fall};
use crate::scene::sets;

/// The strip that falls and folds onto itself, with nothing said of layers.
fn fall(set: &[&str]) -> Scene {
    let fixed = ["sheet.edge=8e-3", "duration=0.5", "output.rate=50"];
    let mut scene = scene_of_a_fall(&[&fixed[..], set].concat());
    scene.layers = None;
    scene
}

/// What a run came to: steps in which layers touched, most crossings, steps flagged, attempts repeated.
#[derive(Debug, Default)]
struct Seen {
    touched: u64,
    crossings: u64,
    flagged: u64,
    rejected: u64,
}

fn run(scene: &Scene) -> (Seen, Simulation) {
    let (mut simulation, mut seen) = (simulation(scene), Seen::default());
    for _ in 0..scene.steps() {
        let report = simulation.step().unwrap_or_else(|e| panic!("{e}"));
        seen.touched += u64::from(report.layer_contacts > 0);
        seen.crossings = seen.crossings.max(report.crossings);
        seen.flagged += u64::from(report.neglected == ["layers"]);
        seen.rejected += report.work.rejected;
    }
    println!("{}: {seen:?}", scene.method.method().name());
    (seen, simulation)
}

/// With nothing said, what falls on itself stays apart; with layers off it passes through, and reports say so.
#[test]
fn a_sheet_that_falls_on_itself_does_not_cross_itself() {
    for scheme in ["central-difference", "bdf2", "generalised-alpha"] {
        let set = [
            &format!("method.scheme={scheme}")[..],
            "method.dt=0.004166666666666667",
        ];
        let (seen, simulation) = run(&fall(&set));
        assert_eq!((seen.crossings, seen.flagged), (0, 0), "{scheme}");
        assert_eq!(crossed(&simulation), 0, "{scheme}");
        assert!(seen.touched > 0, "{scheme}: nothing touches");
        let mut off = fall(&set);
        off.layers = Some(toile::scene::LayersSpec::OFF);
        let (seen, simulation) = run(&off);
        assert!(seen.crossings > 0 && seen.flagged > 0, "{scheme}: {seen:?}");
        assert!(simulation.model().layers.is_none());
    }
}

/// An implicit step at whose start no layers are near is looked at when it is solved: those that met are solved again.
#[test]
fn layers_that_meet_within_an_implicit_step_are_found_afterwards() {
    let set = ["method.scheme=bdf2", "method.dt=0.02"];
    let scene = held(&[&set[..], &["output.rate=50", "duration=0.4"]].concat());
    let mut simulation = simulation(&scene);
    let mut unforeseen = 0;
    for _ in 0..scene.steps() {
        let far = !simulation.report().layers_near;
        let report = simulation.step().unwrap_or_else(|e| panic!("{e}")).clone();
        assert_eq!(crossed(&simulation), 0, "{} s", report.time);
        unforeseen += u64::from(far && report.layer_contacts > 0 && report.work.rejected > 0);
    }
    assert!(unforeseen > 0, "nothing met unforeseen");
}

/// Methods that know no layers leave them out and say so where they are needed; told to have them, they are refused.
#[test]
fn methods_that_know_no_layers_flag_them() {
    for solver in ["quasi-newton", "xpbd"] {
        let scheme = match solver {
            "xpbd" => "method.scheme=backward-euler",
            _ => "method.scheme=bdf2",
        };
        let text = fall(&["method.scheme=bdf2", "method.dt=0.005"]).to_toml();
        let set = [
            &format!("method.solver={solver}")[..],
            scheme,
            "duration=0.4",
        ];
        let unsaid = parse(&text, &sets(&set)).unwrap().0;
        let (seen, simulation) = run(&unsaid);
        assert!(simulation.model().layers.is_none(), "{solver}");
        assert!(seen.flagged > 0, "{solver}: {seen:?}");
        parse(&text, &sets(&[&set[..], &["layers.contact=off"]].concat())).unwrap();
        let told = parse(&text, &sets(&[&set[..], &["layers.friction=0.3"]].concat()));
        let message = told.unwrap_err().to_string();
        assert!(message.contains("or set layers.contact = off"), "{message}");
    }
}
