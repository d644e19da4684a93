//! A scene with one piece of its physics toggled, to see what that piece is worth.

use super::layers::{LayerContact, LayersSpec};
use super::needs::{Term, needs};
use super::spec::{AirSpec, Scene};
use crate::fabric::{PoissonCoupling, TwistRigidity};

/// What is switched on where a scene has none: the paper's damping, and air at rest on a plate moving at about 1 m/s.
const DAMPING: f64 = 0.1;
const FLUID_DAMPING: f64 = 0.7;

/// A scene that differs from another in one piece of physics.
#[derive(Clone, Debug, PartialEq)]
pub struct Ablation {
    /// What was changed, as in `drag off`.
    pub name: String,
    /// The scene with the change.
    pub scene: Scene,
}

/// Every optional piece of a scene's physics toggled, one at a time: terms off that are on, and on that are off, where
/// a scene says enough to do so; the fabric's two choices of law the other way.
pub fn ablations(scene: &Scene) -> Vec<Ablation> {
    let needed = |wanted: Term| needs(scene).iter().any(|(term, _)| *term == wanted);
    let mut all = vec![];
    let mut toggle = |name: String, change: &dyn Fn(&mut Scene)| {
        let mut scene = scene.clone();
        change(&mut scene);
        all.push(Ablation { name, scene });
    };
    for term in Term::ALL {
        let on = needed(term);
        let name = format!("{term} {}", if on { "off" } else { "on" });
        match term {
            // A sheet without a membrane is no sheet, one without supports is another scene, and where nothing is
            // said of weight or obstacles there is nothing to switch on.
            Term::Stretch | Term::Support => {}
            Term::Bend => toggle("bend a thousandth".to_string(), &soften),
            Term::Gravity if on => toggle(name, &|scene| {
                scene.gravity = [0.0; 3];
                scene.load.clear();
            }),
            Term::Damping if on => toggle(name, &|scene| scene.damping = 0.0),
            Term::Damping => toggle(name, &|scene| scene.damping = DAMPING),
            Term::Drag if on => toggle(name, &without_air),
            Term::Drag => toggle(name, &in_still_air),
            Term::Contact if on && !scene.obstacle.is_empty() => toggle(name, &without_obstacles),
            Term::Friction if on && !scene.obstacle.is_empty() => toggle(name, &|scene| {
                scene.obstacle.values_mut().for_each(|o| {
                    (o.friction, o.friction_static) = (0.0, None);
                });
            }),
            Term::Layers if on => toggle(name, &|scene| touch(scene, LayerContact::Off)),
            Term::Layers if scene.method.method().knows_layers() => {
                toggle(name, &|scene| touch(scene, LayerContact::On));
            }
            Term::Gravity | Term::Contact | Term::Friction | Term::Layers => {}
        }
    }
    toggle(
        match scene.fabric.twist {
            TwistRigidity::Geometric => "twist none".to_string(),
            TwistRigidity::None => "twist geometric".to_string(),
        },
        &|scene| {
            scene.fabric.twist = match scene.fabric.twist {
                TwistRigidity::Geometric => TwistRigidity::None,
                TwistRigidity::None => TwistRigidity::Geometric,
            };
        },
    );
    toggle(
        match scene.fabric.poisson {
            PoissonCoupling::None => "poisson symmetrised".to_string(),
            PoissonCoupling::Symmetrised => "poisson none".to_string(),
        },
        &|scene| {
            scene.fabric.poisson = match scene.fabric.poisson {
                PoissonCoupling::None => PoissonCoupling::Symmetrised,
                PoissonCoupling::Symmetrised => PoissonCoupling::None,
            };
        },
    );
    all
}

/// Bending is what gives a sheet its folds, so it is made small, not nothing.
fn soften(scene: &mut Scene) {
    if let Ok(fabric) = scene.fabric.resolve() {
        scene.fabric.rigidity_warp = Some(1e-3 * fabric.rigidity_warp);
        scene.fabric.rigidity_weft = Some(1e-3 * fabric.rigidity_weft);
    }
}

/// Explicit from here on: what commands could bring is left out, too.
fn without_air(scene: &mut Scene) {
    let accepted = scene.accept.take().unwrap_or_default();
    scene.accept = Some(keep_obstacles(accepted, scene));
    scene.air = None;
}

fn keep_obstacles(accepted: Vec<super::Accept>, scene: &Scene) -> Vec<super::Accept> {
    let obstacles = super::Accept::Obstacles;
    let kept = accepted.contains(&obstacles) || !scene.obstacle.is_empty();
    if kept { vec![obstacles] } else { vec![] }
}

fn in_still_air(scene: &mut Scene) {
    scene.air = Some(AirSpec {
        fluid_damping: FLUID_DAMPING,
        velocity: [0.0; 3],
        region: None,
        rise: 0.0,
        start: 0.0,
        hold: None,
    });
}

fn touch(scene: &mut Scene, contact: LayerContact) {
    let spec = scene.layers.unwrap_or_default();
    scene.layers = Some(LayersSpec { contact, ..spec });
}

fn without_obstacles(scene: &mut Scene) {
    scene.obstacle.clear();
    scene.accept = Some(vec![]);
}
