//! Which physics a scene pays for, and that the model pays for no other.

use toile::scene::{Term, library, needs};
use toile::sim::Model;

use crate::scene::{GOOD, good};

fn terms(text: &str, overrides: &[&str]) -> Vec<Term> {
    let needs = needs(&good(text, overrides));
    needs.into_iter().map(|(term, _)| term).collect()
}

#[test]
fn a_scene_needs_what_its_values_say() {
    use Term::{Bend, Contact, Damping, Friction, Gravity, Layers, Stretch, Support};
    assert_eq!(terms(GOOD, &["air.fluid_damping=0.1"]), Term::ALL);
    assert!(!terms(GOOD, &[]).contains(&Term::Drag));
    assert_eq!(
        terms(GOOD, &["damping=0", "gravity=[0, 0, 0]"]),
        [Stretch, Bend, Support, Contact, Friction, Layers]
    );
    assert_eq!(
        terms(GOOD, &["obstacle.table.friction=0", "accept=[]"]),
        [Stretch, Bend, Gravity, Damping, Support, Contact, Layers]
    );
    assert_eq!(
        terms(library::text("free-fall").unwrap(), &["layers.contact=off"]),
        [Stretch, Bend, Gravity, Damping]
    );
}

/// A sheet touches itself unless the scene says otherwise, it cannot, or the method cannot.
#[test]
fn a_scene_needs_layers_unless_it_says_otherwise() {
    let has = |set: &[&str]| terms(GOOD, set).contains(&Term::Layers);
    let round = "support.left.region={ kind = \"boundary\" }";
    let quasi = "method.solver=quasi-newton";
    let xpbd = ["method.solver=xpbd", "method.scheme=backward-euler"];
    assert!(has(&[]) && has(&["layers.friction=0.2"]) && has(&["layers.contact=on"]));
    assert!(has(&["method.scheme=central-difference"]));
    let rest = "method.scheme=equilibrium";
    assert!(!has(&[rest]) && has(&[rest, "layers.contact=on"]));
    assert!(!has(&["layers.contact=off"]) && !has(&["layers.friction=0.2", "layers.contact=off"]));
    assert!(!has(&[quasi]) && !has(&xpbd) && !has(&[quasi, "layers.contact=off"]));
    // Held all around it cannot, unless it may move along an axis, or the scene insists.
    assert!(!has(&[round]));
    assert!(has(&[round, "support.left.axes=xy"]) && has(&[round, "layers.contact=on"]));
}

/// What a command may bring has to be paid for from the start.
#[test]
fn a_scene_needs_what_it_accepts() {
    let reason = |text: &str, set: &[&str], wanted: Term| {
        let needs = needs(&good(text, set));
        let found = needs.into_iter().find(|(term, _)| *term == wanted);
        found.map(|(_, reason)| reason)
    };
    let free = library::text("free-fall").unwrap();
    assert_eq!(reason(free, &[], Term::Contact), None);
    let obstacles = ["accept=[\"obstacles\"]"];
    for (term, wanted) in [
        (
            Term::Contact,
            "accept has \"obstacles\": commands may add obstacles",
        ),
        (
            Term::Friction,
            "accept has \"obstacles\": commands may add obstacles with friction",
        ),
    ] {
        assert_eq!(reason(free, &obstacles, term).as_deref(), Some(wanted));
    }
    assert_eq!(reason(free, &obstacles, Term::Drag), None);
    let air = reason(free, &["accept=[\"air\"]"], Term::Drag);
    assert_eq!(
        air.unwrap(),
        "accept has \"air\": commands may let the air blow"
    );
    let smooth = reason(GOOD, &["obstacle.table.friction=0"], Term::Friction);
    assert!(
        smooth
            .unwrap()
            .starts_with("a scene with obstacles accepts more")
    );
}

#[test]
fn a_reason_quotes_the_scene() {
    let scene = good(
        GOOD,
        &[
            "obstacle.ball.shape={ kind = \"sphere\", radius = 0.02 }",
            "air.fluid_damping=0.03",
            "layers.friction=0.2",
        ],
    );
    let reasons: Vec<_> = needs(&scene)
        .into_iter()
        .map(|(_, reason)| reason)
        .collect();
    assert_eq!(
        reasons,
        [
            "fabric F1 has a membrane stiffness",
            "fabric F1 has a flexural rigidity",
            "gravity = [0, 0, -9.81] m/s²",
            "damping = 0.1 kg/(m²·s)",
            "air.fluid_damping = 0.03 kg/(m²·s)",
            "support.left",
            "obstacle.ball, obstacle.table",
            "obstacle.table.friction = 0.3",
            "the scene has layers: it may touch itself, layers.friction = 0.2",
        ]
    );
    let unsaid = needs(&good(GOOD, &[])).pop();
    assert_eq!(
        unsaid.unwrap().1,
        "it may fold onto itself, which layers.contact = \"off\" would ignore"
    );
}

#[test]
fn the_model_has_the_terms_that_the_scene_needs() {
    for name in library::names() {
        let scene = good(library::text(name).unwrap(), &["sheet.triangles=100"]);
        let needs = needs(&scene);
        let needed = |term| needs.iter().any(|(needed, _)| *needed == term);
        let model = Model::new(&scene, scene.fabric.resolve().unwrap());
        assert_eq!(model.contact.is_some(), needed(Term::Contact), "{name}");
        assert_eq!(!model.supports.is_empty(), needed(Term::Support), "{name}");
        assert_eq!(model.layers.is_some(), needed(Term::Layers), "{name}");
        assert_eq!(model.drag, needed(Term::Drag), "{name}");
        assert_eq!(model.gravity.total() > 0.0, needed(Term::Gravity), "{name}");
    }
}
