//! All that stays constant in a run.

use std::collections::BTreeMap;

use nalgebra::{Rotation3, Vector2, Vector3};

use crate::contact::layers::Tiles;
use crate::contact::{Features, Motion, Obstacle, Velocity};
use crate::fabric::Fabric;
use crate::physics::Potential;
use crate::physics::bend::Bend;
use crate::physics::contact::ContactLaw;
use crate::physics::damping::Damping;
use crate::physics::gravity::Gravity;
use crate::physics::layers::LayerLaw;
use crate::physics::stretch::Stretch;
use crate::physics::support::Support;
use crate::scene::{Axis, Scene, Scheme, Solver, Term, needs};
use crate::sheet::{Mesh, MeshOptions, generate_graded};

use super::air::Air;
use super::carry::Carried;
use super::command::AirRegion;
use super::dofs::Dofs;
use super::perturbation::perturbation;
use super::probe::Probe;
use super::regions::{loads, supports};

/// Mesh, fabric and terms of a run.
#[derive(Clone, Debug)]
pub struct Model {
    /// The scene as checked.
    pub scene: Scene,
    /// The fabric in SI constants.
    pub fabric: Fabric,
    /// The sheet.
    pub mesh: Mesh,
    /// Lumped masses \[kg\], shape \[vertices\].
    pub masses: Vec<f64>,
    /// Weight of the sheet, the scale of residuals \[N\]; without gravity, the weight it would have on earth.
    pub weight: f64,
    /// Membrane energy.
    pub stretch: Stretch,
    /// Bending energy.
    pub bend: Bend,
    /// Weight.
    pub gravity: Gravity,
    /// Potential of the weight at the unperturbed start \[J\]: the ledger counts from there.
    pub start_gravity: f64,
    /// Viscous damping.
    pub damping: Damping,
    /// Whether air acts on the sheet, or a command may let it.
    pub drag: bool,
    /// What holds the sheet.
    pub supports: Vec<Support>,
    /// What moving supports carry along.
    pub carried: Vec<Carried>,
    /// Motions that the scene prescribes for obstacles, by name.
    pub motions: BTreeMap<String, Motion>,
    /// Static friction coefficients by the name of the obstacle, where they are others than those of sliding.
    pub static_friction: BTreeMap<String, f64>,
    /// The contact law, if the scene has obstacles or commands may add some.
    pub contact: Option<ContactLaw>,
    /// Length of the longest edge of the flat mesh \[m\].
    pub longest_edge: f64,
    /// Incidence for contact detection.
    pub features: Features,
    /// The law of layer on layer, if the sheet may touch itself.
    pub layers: Option<LayerLaw>,
    /// Where the sheet may come near to itself.
    pub tiles: Tiles,
    /// Numbering of the unknowns.
    pub dofs: Dofs,
    /// What each reading averages along which axis, from where.
    pub readings: Vec<Reading>,
}

/// A reading as a mean over vertices.
#[derive(Clone, Debug)]
pub struct Reading {
    /// Name in the scene.
    pub name: String,
    /// What is averaged.
    pub probe: Probe,
    /// World axis.
    pub axis: usize,
    /// Mean coordinate at the unperturbed start \[m\].
    pub start: f64,
}

impl Model {
    /// Builds mesh and terms of a checked scene.
    pub fn new(scene: &Scene, fabric: Fabric) -> Self {
        let mesh = mesh(scene);
        let masses: Vec<f64> = mesh
            .vertex_areas
            .iter()
            .map(|a| a * fabric.areal_density)
            .collect();
        let mut gravity = Gravity::new(&masses, scene.gravity.into());
        gravity.load(&loads(scene, &mesh));
        let mass: f64 = masses.iter().sum();
        let weight = if gravity.total() > 0.0 {
            gravity.total()
        } else {
            mass * 9.81
        };
        let membrane = fabric.membrane();
        let stiffness = (membrane.c11 * membrane.c22).sqrt();
        let supports: Vec<Support> = supports(scene, &mesh);
        let needs = needs(scene);
        let needed = |wanted| needs.iter().any(|(term, _)| *term == wanted);
        let contact = needed(Term::Contact).then(|| {
            let law = ContactLaw::new(weight, stiffness, fabric.thickness);
            match (scene.method.scheme, scene.method.solver) {
                (Scheme::CentralDifference, _) | (_, Solver::Xpbd) => law,
                _ => law.stiffening(),
            }
        });
        let spec = scene.layers.unwrap_or_default();
        let thickness = spec.thickness.unwrap_or(fabric.thickness);
        let area = mesh.area() / masses.len() as f64;
        let layers = needed(Term::Layers).then(|| LayerLaw::new(thickness, area, spec.friction));
        let (turn, shift) = placement(scene);
        let start_gravity = (0..masses.len())
            .map(|v| {
                let p = mesh.outline[v];
                gravity.value(v, &[turn * Vector3::new(p.x, p.y, 0.0) + shift])
            })
            .sum();
        let mut model = Self {
            start_gravity,
            carried: vec![],
            motions: motions(scene),
            static_friction: static_friction(scene),
            stretch: Stretch::new(&mesh, membrane),
            bend: Bend::new(&mesh, fabric.bending()),
            gravity,
            damping: Damping::new(scene.damping, &mesh.vertex_areas),
            contact,
            layers,
            tiles: Tiles::new(&mesh, thickness),
            drag: needed(Term::Drag),
            features: Features::new(&mesh),
            longest_edge: (0..mesh.edges.len())
                .map(|e| mesh.edge_length(e))
                .fold(0.0, f64::max),
            dofs: Dofs::new(&mesh, &supports),
            readings: readings(scene, &mesh),
            scene: scene.clone(),
            fabric,
            mesh,
            masses,
            weight,
            supports,
        };
        let (start, vertices) = (model.start(), model.masses.len());
        model.carried = Carried::all(scene, &model.supports, &start, vertices);
        model
    }

    /// Nodes (vertex positions \[m\], then edge slopes) at the start: flat, placed, perturbed, supports displaced.
    pub fn start(&self) -> Vec<Vector3<f64>> {
        let (turn, shift) = placement(&self.scene);
        let sheet_to_world = |p: &Vector2<f64>| turn * Vector3::new(p.x, p.y, 0.0) + shift;
        let normal = turn * Vector3::z();
        let mut nodes: Vec<Vector3<f64>> = self
            .mesh
            .outline
            .iter()
            .zip(perturbation(
                &self.scene.perturbation,
                &self.mesh,
                &self.supports,
            ))
            .map(|(p, rise)| sheet_to_world(p) + normal * rise)
            .collect();
        for support in &self.supports {
            for &v in &support.vertices {
                let flat = sheet_to_world(&self.mesh.outline[v as usize]) + support.displacement;
                for axis in 0..3 {
                    if support.axes[axis] {
                        nodes[v as usize][axis] = flat[axis];
                    }
                }
            }
        }
        let yarns = Rotation3::from_axis_angle(
            &Vector3::z_axis(),
            self.scene.sheet.warp_angle.to_radians(),
        );
        nodes.extend((0..self.mesh.edges.len()).map(|e| {
            let n = self.mesh.edge_normal(e);
            turn * (yarns * Vector3::new(n.x, n.y, 0.0))
        }));
        self.place_supports(&mut nodes, 0.0);
        nodes
    }

    /// The obstacles at the start, in the order of their names.
    pub fn obstacles(&self) -> Vec<Obstacle> {
        self.scene
            .obstacle
            .iter()
            .map(|(name, spec)| {
                let constant = Velocity {
                    linear: spec.linear_velocity.into(),
                    angular: spec.angular_velocity.into(),
                };
                let motion = self.motions.get(name).map(|motion| motion.at(0.0));
                let (pose, velocity) = motion.unwrap_or((spec.pose(), constant));
                Obstacle {
                    name: name.clone(),
                    shape: spec.shape.clone(),
                    pose,
                    velocity,
                    friction: spec.friction,
                    scripted: spec.motion.is_some(),
                    ..Obstacle::default()
                }
            })
            .collect()
    }
}

impl Model {
    /// Friction coefficient of an obstacle for cloth that does not slide on it.
    pub fn sticking(&self, body: &Obstacle) -> f64 {
        match self.static_friction.get(&body.name) {
            Some(friction) => friction.max(body.friction),
            None => body.friction,
        }
    }

    /// The air at the start.
    pub fn air(&self) -> Air {
        let Some(spec) = &self.scene.air else {
            return Air::default();
        };
        Air {
            fluid_damping: spec.fluid_damping,
            region: spec.region.map(|region| AirRegion {
                min: region.min.into(),
                max: region.max.into(),
            }),
            to: spec.velocity.into(),
            delay: spec.start,
            rise: spec.rise,
            hold: spec.hold,
            ..Air::default()
        }
    }
}

fn static_friction(scene: &Scene) -> BTreeMap<String, f64> {
    let specs = scene.obstacle.iter();
    specs
        .filter_map(|(name, spec)| Some((name.clone(), spec.friction_static?)))
        .collect()
}

fn motions(scene: &Scene) -> BTreeMap<String, Motion> {
    let specs = scene.obstacle.iter();
    specs
        .filter_map(|(name, spec)| Some((name.clone(), spec.motion()?)))
        .collect()
}

fn rotation(degrees: &[f64; 3]) -> Rotation3<f64> {
    let [roll, pitch, yaw] = degrees.map(f64::to_radians);
    Rotation3::from_euler_angles(roll, pitch, yaw)
}

fn placement(scene: &Scene) -> (Rotation3<f64>, Vector3<f64>) {
    (rotation(&scene.sheet.rotation), scene.sheet.position.into())
}

fn mesh(scene: &Scene) -> Mesh {
    let sheet = &scene.sheet;
    let size = |longest: f64, p: &Vector2<f64>| match &sheet.refine {
        None => longest,
        Some(refine) => refine.size(&sheet.outline, longest, p),
    };
    let edge = match (sheet.edge, sheet.triangles) {
        (Some(edge), _) => edge,
        (None, count) => sheet.outline.edge_for_graded(count.unwrap_or(1000), size),
    };
    let options = MeshOptions {
        edge,
        jitter: sheet.jitter,
        seed: sheet.mesh_seed,
        warp_angle: sheet.warp_angle.to_radians(),
    };
    generate_graded(&sheet.outline, &options, &|p| size(edge, p))
}

fn readings(scene: &Scene, mesh: &Mesh) -> Vec<Reading> {
    let (turn, shift) = placement(scene);
    let place = |p: &Vector2<f64>| turn * Vector3::new(p.x, p.y, 0.0) + shift;
    let flat: Vec<Vector3<f64>> = mesh.outline.iter().map(place).collect();
    let reading = |(name, spec): (&String, &crate::scene::ObserveSpec)| {
        let probe = match &spec.region {
            Some(region) => Probe::over(mesh, region),
            None => {
                let points: Vec<_> = spec.points.iter().map(|p| Vector2::from(*p)).collect();
                Probe::at(mesh, &points)
            }
        };
        let axis = match spec.axis {
            Axis::X => 0,
            Axis::Y => 1,
            Axis::Z => 2,
        };
        Reading {
            name: name.clone(),
            start: probe.read(&flat)[axis],
            probe,
            axis,
        }
    };
    scene.observe.iter().map(reading).collect()
}
