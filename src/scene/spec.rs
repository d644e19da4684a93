//! The scene document as data. SI units, REP-103 frames; keys are the TOML keys.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::layers::LayersSpec;
use super::load::LoadSpec;
use super::method::{MethodSpec, OutputSpec};
use super::motion::{ObstacleMotion, OverlapSpec, SupportMotion, placed};
use super::refine::Refine;
use super::sleep::SleepSpec;
use crate::contact::{Motion, Pose, Shape};
use crate::fabric::{PoissonCoupling, TwistRigidity};
use crate::sheet::Outline;

/// A scene as written. [`Scene::check`] has passed on every one that reaches the simulation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Name, also the stem of the recording.
    pub name: String,
    /// One line for `toile list scenes`.
    pub description: String,
    /// Simulated time \[s\].
    pub duration: f64,
    /// Gravitational acceleration \[m/s²\].
    #[serde(default = "standard_gravity")]
    pub gravity: [f64; 3],
    /// Viscous damping mu of equation (11) \[kg/(m²·s)\].
    #[serde(default)]
    pub damping: f64,
    /// Commands that a run takes. Left out, it takes those for what the scene has: obstacles, air.
    #[serde(default)]
    pub accept: Option<Vec<Accept>>,
    /// The sheet.
    pub sheet: SheetSpec,
    /// What it is made of.
    pub fabric: FabricSpec,
    /// Where it is held.
    #[serde(default)]
    pub support: BTreeMap<String, SupportSpec>,
    /// Dead loads by name.
    #[serde(default)]
    pub load: BTreeMap<String, LoadSpec>,
    /// What it can touch.
    #[serde(default)]
    pub obstacle: BTreeMap<String, ObstacleSpec>,
    /// What becomes of an obstacle that is put into the cloth.
    #[serde(default)]
    pub overlap: OverlapSpec,
    /// The air that acts on it; none if left out.
    #[serde(default)]
    pub air: Option<AirSpec>,
    /// Contact of the sheet with itself; left out, it has it where the method can ([`Scene::touches_itself`]).
    #[serde(default)]
    pub layers: Option<LayersSpec>,
    /// When a sheet at rest sleeps until something moves; never if left out.
    #[serde(default)]
    pub sleep: Option<SleepSpec>,
    /// A seeded disturbance of the flat start: a symmetric one is metastable.
    #[serde(default)]
    pub perturbation: Perturbation,
    /// How it is solved.
    #[serde(default)]
    pub method: MethodSpec,
    /// What is recorded, and how often.
    #[serde(default)]
    pub output: OutputSpec,
    /// The quantities that the scene is about.
    #[serde(default)]
    pub observe: BTreeMap<String, ObserveSpec>,
}

/// A kind of command that a run may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Accept {
    /// Adding, moving and removing obstacles.
    Obstacles,
    /// Another air flow.
    Air,
}

impl Accept {
    /// The word in a scene's key `accept`.
    pub fn name(self) -> &'static str {
        match self {
            Accept::Obstacles => "obstacles",
            Accept::Air => "air",
        }
    }
}

impl Scene {
    /// Whether a run takes commands of a kind: those that `accept` lists; without it, those for what there is.
    pub fn accepts(&self, kind: Accept) -> bool {
        match (&self.accept, kind) {
            (Some(list), _) => list.contains(&kind),
            (None, Accept::Obstacles) => !self.obstacle.is_empty(),
            (None, Accept::Air) => self.air.is_some(),
        }
    }

    /// Number of steps of the run: the duration in whole steps, at least one.
    pub fn steps(&self) -> u64 {
        ((self.duration / self.method.dt).round() as u64).max(1)
    }

    /// Steps from one output to the next: the nearest to the wanted rate, at least one.
    pub fn output_steps(&self) -> u64 {
        ((1.0 / (self.output.rate * self.method.dt)).round() as u64).max(1)
    }
}

fn standard_gravity() -> [f64; 3] {
    [0.0, 0.0, -9.81]
}

/// The sheet: outline, mesh size, where it starts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SheetSpec {
    /// Outline in the sheet's own x, y.
    pub outline: Outline,
    /// Wanted number of triangles; give this or `edge`.
    #[serde(default)]
    pub triangles: Option<usize>,
    /// Wanted edge length \[m\]; give this or `triangles`.
    #[serde(default)]
    pub edge: Option<f64>,
    /// Where the mesh is finer.
    #[serde(default)]
    pub refine: Option<Refine>,
    /// Random displacement of interior vertices as a fraction of the edge length, 0 to 0.3.
    #[serde(default)]
    pub jitter: f64,
    /// Seed of the unstructured mesh.
    #[serde(default)]
    pub mesh_seed: u64,
    /// Angle from sheet x to the warp \[degrees\]; 45 makes a bias specimen.
    #[serde(default)]
    pub warp_angle: f64,
    /// World position of the sheet's centre at the start \[m\].
    #[serde(default)]
    pub position: [f64; 3],
    /// Roll, pitch, yaw of the flat sheet at the start \[degrees\].
    #[serde(default)]
    pub rotation: [f64; 3],
}

impl SheetSpec {
    /// Edge length that the scene asks for, directly or about by the number of triangles \[m\].
    pub fn edge_length(&self) -> f64 {
        match (self.edge, self.triangles) {
            (Some(edge), _) => edge,
            (None, Some(triangles)) => self.outline.equilateral_edge(triangles as f64),
            (None, None) => self.outline.equilateral_edge(1.0),
        }
    }
}

/// A catalogue fabric by name, with single constants replaced if given; or all constants of one's own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FabricSpec {
    /// `F1` to `F12`, or a name of one's own with all the constants below.
    pub name: String,
    /// \[kg/m²\]
    #[serde(default)]
    pub areal_density: Option<f64>,
    /// \[m\]
    #[serde(default)]
    pub thickness: Option<f64>,
    /// \[Pa\]
    #[serde(default)]
    pub young_warp: Option<f64>,
    /// \[Pa\]
    #[serde(default)]
    pub young_weft: Option<f64>,
    /// \[Pa\]
    #[serde(default)]
    pub shear_modulus: Option<f64>,
    /// \[N·m\]
    #[serde(default)]
    pub rigidity_warp: Option<f64>,
    /// \[N·m\]
    #[serde(default)]
    pub rigidity_weft: Option<f64>,
    /// \[-\]
    #[serde(default)]
    pub poisson_warp: Option<f64>,
    /// \[-\]
    #[serde(default)]
    pub poisson_weft: Option<f64>,
    /// `geometric` (default) or `none`.
    #[serde(default)]
    pub twist: TwistRigidity,
    /// `none` (default) or `symmetrised`.
    #[serde(default)]
    pub poisson: PoissonCoupling,
}

/// How a region of the sheet is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SupportKind {
    /// Position prescribed, free to rotate.
    Pin,
    /// Position and slope prescribed.
    Clamp,
}

/// Part of the sheet in its own x, y.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Region {
    /// The side of smallest x.
    XMin,
    /// The side of largest x.
    XMax,
    /// The side of smallest y.
    YMin,
    /// The side of largest y.
    YMax,
    /// The whole boundary.
    Boundary,
    /// All within the box.
    Box {
        /// Smallest x, y \[m\].
        min: [f64; 2],
        /// Largest x, y \[m\].
        max: [f64; 2],
    },
    /// All within the circle about the sheet's centre.
    Disc {
        /// Diameter \[m\].
        diameter: f64,
    },
    /// All between two circles about the sheet's centre.
    Ring {
        /// Diameter of the outer circle \[m\].
        outer: f64,
        /// Diameter of the inner circle \[m\].
        inner: f64,
    },
    /// The vertex nearest to a point.
    Point {
        /// x, y \[m\].
        at: [f64; 2],
    },
}

/// A support: what is held, how, and where to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SupportSpec {
    /// Pin or clamp.
    pub kind: SupportKind,
    /// The part of the sheet it holds.
    pub region: Region,
    /// World axes held, any of `x`, `y`, `z`.
    #[serde(default = "all_axes")]
    pub axes: String,
    /// Displacement from the start, imposed at once \[m\].
    #[serde(default)]
    pub displacement: [f64; 3],
    /// How it moves; it stands still if left out.
    #[serde(default)]
    pub motion: Option<SupportMotion>,
}

fn all_axes() -> String {
    "xyz".to_string()
}

/// An obstacle at the start of the run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObstacleSpec {
    /// Its shape.
    pub shape: Shape,
    /// World position of its origin \[m\].
    #[serde(default)]
    pub position: [f64; 3],
    /// Roll, pitch, yaw \[degrees\].
    #[serde(default)]
    pub rotation: [f64; 3],
    /// \[m/s\]
    #[serde(default)]
    pub linear_velocity: [f64; 3],
    /// \[rad/s\]
    #[serde(default)]
    pub angular_velocity: [f64; 3],
    /// Coulomb friction coefficient \[-\].
    #[serde(default)]
    pub friction: f64,
    /// The same for cloth that does not slide \[-\], not less; `friction` if left out.
    #[serde(default)]
    pub friction_static: Option<f64>,
    /// How it moves from the start on, in place of the pose and the velocities above, until a command moves it.
    #[serde(default)]
    pub motion: Option<ObstacleMotion>,
}

impl ObstacleSpec {
    /// Where the obstacle is at the start, in the world.
    pub fn pose(&self) -> Pose {
        match self.motion() {
            Some(motion) => motion.at(0.0).0,
            None => placed(&self.position.into(), &self.rotation),
        }
    }

    /// The motion that the scene prescribes.
    pub fn motion(&self) -> Option<Motion> {
        let rest = (self.position, self.rotation);
        self.motion.as_ref().map(|motion| motion.through(rest))
    }
}

/// Air with a prescribed velocity: uniform in a region, zero outside, on a linear ramp in time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AirSpec {
    /// C of the force C (n·(u - v)) n per area \[kg/(m²·s)\].
    pub fluid_damping: f64,
    /// Velocity u after the ramp \[m/s\]; zero is air at rest, which brakes.
    #[serde(default)]
    pub velocity: [f64; 3],
    /// Where it blows; everywhere if left out.
    #[serde(default)]
    pub region: Option<AirBox>,
    /// Length of the ramp from zero \[s\]; zero is a jump.
    #[serde(default)]
    pub rise: f64,
    /// Time at which the ramp begins \[s\].
    #[serde(default)]
    pub start: f64,
    /// Time from there to the end of the flow, which then fades in `rise` \[s\]; endless if left out.
    #[serde(default)]
    pub hold: Option<f64>,
}

/// An axis-aligned box of the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AirBox {
    /// Smallest x, y, z \[m\].
    pub min: [f64; 3],
    /// Largest x, y, z \[m\].
    pub max: [f64; 3],
}

/// Seeded out-of-plane disturbance of the start: a smooth random field of the given amplitude.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Perturbation {
    /// Largest displacement along the sheet's normal \[m\].
    #[serde(default)]
    pub amplitude: f64,
    /// Seed of the field.
    #[serde(default)]
    pub seed: u64,
    /// Distance from supports over which it rises from nothing \[m\]. With none it ends at them in a jump, which a finer
    /// mesh makes sharper.
    #[serde(default)]
    pub fade: f64,
}

/// World axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// Forward.
    X,
    /// Left.
    Y,
    /// Up.
    Z,
}

/// A reading of the run: the mean displacement of some points, or of a region, of the sheet along one axis \[m\].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObserveSpec {
    /// Points in the sheet's x, y \[m\]; the reading is their mean.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub points: Vec<[f64; 2]>,
    /// In their place: a region, along boundary edges if it has some, else by area.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<Region>,
    /// Direction of the displacement.
    pub axis: Axis,
}
