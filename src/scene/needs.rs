//! Which physics a scene pays for, and why: the one place that decides it.
//!
//! A term that is not needed is not assembled, has no place in the sparsity pattern, and costs nothing.

use std::fmt;

use super::quantity::short;
use super::spec::{Accept, ObstacleSpec, Scene};

/// A term of the equation of motion; each has its folder in `physics`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Term {
    /// Membrane strain.
    Stretch,
    /// Curvature.
    Bend,
    /// Weight and dead loads.
    Gravity,
    /// Viscous damping.
    Damping,
    /// Air on the faces.
    Drag,
    /// Pins and clamps.
    Support,
    /// Contact with obstacles.
    Contact,
    /// Coulomb friction on obstacles.
    Friction,
    /// Contact and friction of the sheet with itself.
    Layers,
}

/// Why a scene needs a term: the scene's own values in a few words.
pub type Reason = String;

impl Term {
    /// All terms, in the order in which they are assembled.
    pub const ALL: [Term; 9] = [
        Term::Stretch,
        Term::Bend,
        Term::Gravity,
        Term::Damping,
        Term::Drag,
        Term::Support,
        Term::Contact,
        Term::Friction,
        Term::Layers,
    ];

    /// The name of its folder in `physics`.
    pub fn name(self) -> &'static str {
        match self {
            Term::Stretch => "stretch",
            Term::Bend => "bend",
            Term::Gravity => "gravity",
            Term::Damping => "damping",
            Term::Drag => "drag",
            Term::Support => "support",
            Term::Contact => "contact",
            Term::Friction => "friction",
            Term::Layers => "layers",
        }
    }

    /// Why a checked scene needs the term; nothing if it does not.
    fn reason(self, scene: &Scene) -> Option<Reason> {
        let fabric = || format!("fabric {}", scene.fabric.name);
        match self {
            Term::Stretch => Some(format!("{} has a membrane stiffness", fabric())),
            Term::Bend => Some(format!("{} has a flexural rigidity", fabric())),
            Term::Gravity => {
                let [x, y, z] = scene.gravity.map(short);
                let weighs = scene.gravity != [0.0; 3];
                weighs
                    .then(|| format!("gravity = [{x}, {y}, {z}] m/s²"))
                    .or_else(|| list(scene.load.keys().map(|name| format!("load.{name}"))))
            }
            Term::Damping => {
                let mu = scene.damping;
                (mu > 0.0).then(|| format!("damping = {} kg/(m²·s)", short(mu)))
            }
            Term::Drag => {
                let blows = scene.air.filter(|air| air.fluid_damping > 0.0);
                blows
                    .map(|air| {
                        format!("air.fluid_damping = {} kg/(m²·s)", short(air.fluid_damping))
                    })
                    .or_else(|| commanded(scene, Accept::Air, "commands may let the air blow"))
            }
            Term::Support => list(scene.support.keys().map(|name| format!("support.{name}"))),
            Term::Contact => list(scene.obstacle.keys().map(|name| format!("obstacle.{name}")))
                .or_else(|| commanded(scene, Accept::Obstacles, "commands may add obstacles")),
            Term::Layers => {
                let friction = short(scene.touches_itself()?.friction);
                Some(match scene.layers {
                    Some(_) => format!(
                        "the scene has layers: it may touch itself, layers.friction = {friction}"
                    ),
                    None => "it may fold onto itself, which layers.contact = \"off\" would ignore"
                        .to_string(),
                })
            }
            Term::Friction => {
                let rough = scene.obstacle.iter().filter(|(_, o)| o.friction > 0.0);
                let of = |(name, o): (&String, &ObstacleSpec)| {
                    format!("obstacle.{name}.friction = {}", short(o.friction))
                };
                list(rough.map(of)).or_else(|| {
                    commanded(
                        scene,
                        Accept::Obstacles,
                        "commands may add obstacles with friction",
                    )
                })
            }
        }
    }
}

impl fmt::Display for Term {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The terms that a checked scene needs, in the order in which they are assembled, each with its reason.
pub fn needs(scene: &Scene) -> Vec<(Term, Reason)> {
    let need = |term: Term| Some((term, term.reason(scene)?));
    Term::ALL.into_iter().filter_map(need).collect()
}

/// The reason for what only a command can bring.
fn commanded(scene: &Scene, kind: Accept, reason: &str) -> Option<Reason> {
    let origin = match scene.accept {
        Some(_) => format!("accept has \"{}\"", kind.name()),
        None => format!("a scene with {} accepts more", kind.name()),
    };
    scene.accepts(kind).then(|| format!("{origin}: {reason}"))
}

/// The parts with commas between; nothing if there are none.
fn list(parts: impl Iterator<Item = String>) -> Option<String> {
    let parts: Vec<_> = parts.collect();
    (!parts.is_empty()).then(|| parts.join(", "))
}
