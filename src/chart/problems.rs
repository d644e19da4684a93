//! The scenes that are charted: what is looked at, when, and against what.

use nalgebra::Vector2;

use super::reference::Reference;
use super::work_precision::{ChartError, Problem};
use crate::scene::{Perturbation, Scene};
use crate::sheet::Outline;

/// Scenes of the work-precision chart when none is named.
pub const CHARTED: [&str; 5] = [
    "strip-release",
    "four-edges",
    "drapemeter",
    "fling",
    "drape-table",
];

/// Steps that divide 5 ms \[s\].
const STEPS: [f64; 5] = [5e-3, 2.5e-3, 1e-3, 0.5e-3, 0.25e-3];

/// Time until which the sheet over the table falls the same way on every mesh: then its corners buckle \[s\].
const BUCKLES: f64 = 0.07;

impl Problem {
    /// All charts of a scene: that of [`Problem::of`], and one that ends where the scene bifurcates, if it does.
    pub fn all_of(scene: Scene) -> Result<Vec<Self>, ChartError> {
        let whole = Self::of(scene)?;
        let mut all = vec![whole];
        if all[0].name == "drape-table" {
            let mut fall = all[0].clone();
            fall.name += "-fall";
            fall.times.retain(|t| *t < BUCKLES + 1e-9);
            fall.scene.duration = BUCKLES;
            all.push(fall);
        }
        Ok(all)
    }

    /// The chart that belongs to a scene, by its name; of any other scene what it observes. All methods solve the same
    /// equations: layers are among them only where the scene says so.
    pub fn of(scene: Scene) -> Result<Self, ChartError> {
        let scene = scene.without_unsaid_layers();
        match scene.name.as_str() {
            "strip-release" => Self::strip_release(scene),
            "four-edges" => Ok(Self::four_edges(scene)),
            "drapemeter" => Ok(Self::drapemeter(scene)),
            "fling" => Ok(Self::fling(scene)),
            "drape-table" => Ok(Self::drape_table(scene)),
            _ => Self::observed(scene),
        }
    }

    /// A horizontal strip is let go; its tip against an independent code.
    fn strip_release(mut scene: Scene) -> Result<Self, ChartError> {
        scene.duration = 0.3;
        scene.damping = 0.0;
        scene.gravity = [0.0, 0.0, -9.80665];
        scene.perturbation = Perturbation::default();
        let Outline::Rectangle { length, width } = scene.sheet.outline else {
            return Err(ChartError::NoReference(scene.name));
        };
        Ok(Self {
            points: [-1.0, -0.5, 0.0, 0.5, 1.0]
                .map(|s| 0.5 * Vector2::new(length, s * width))
                .to_vec(),
            reference: Some(Reference::strip_release()?),
            times: vec![],
            length: Some(length),
            steps: vec![10e-3, 5e-3, 2e-3, 1e-3, 0.5e-3],
            meshes: vec![600, 150],
            finest: 600,
            name: scene.name.clone(),
            budget: f64::INFINITY,
            scene,
        })
    }

    /// A square pinned along its boundary falls into its sag; its centre.
    fn four_edges(mut scene: Scene) -> Self {
        scene.damping = 0.1;
        scene.perturbation = Perturbation::default();
        Self {
            points: vec![Vector2::zeros()],
            meshes: vec![800, 200],
            finest: 3200,
            ..Self::made(scene, 0.1)
        }
    }

    /// A ring of F5 clamped inside is let go and begins to fold; four points of its rim. Their mean is the same
    /// whichever way the folds turn.
    fn drapemeter(mut scene: Scene) -> Self {
        scene.fabric.name = "F5".to_string();
        scene.perturbation.amplitude = 1e-4;
        let rim = 0.125;
        Self {
            points: vec![
                Vector2::new(rim, 0.0),
                Vector2::new(0.0, rim),
                Vector2::new(-rim, 0.0),
                Vector2::new(0.0, -rim),
            ],
            meshes: vec![5600, 1400],
            finest: 22_400,
            ..Self::made(scene, 0.1)
        }
    }

    /// The corners of the square over the table, before and while it buckles: their mean.
    fn drape_table(scene: Scene) -> Self {
        let corner = |x: f64, y: f64| Vector2::new(0.1 * x, 0.1 * y);
        Self {
            points: vec![
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
            ],
            meshes: vec![5750, 1400],
            finest: 23_000,
            ..Self::made(scene, 0.2)
        }
    }

    /// The far edge of the square that swings from two corners.
    fn fling(scene: Scene) -> Self {
        let edge = |y: f64| Vector2::new(0.1, y);
        Self {
            points: vec![edge(-0.1), edge(0.0), edge(0.1)],
            meshes: vec![5600, 1400],
            finest: 22_400,
            ..Self::made(scene, 0.2)
        }
    }

    /// The first reading of a scene, at twenty times.
    fn observed(scene: Scene) -> Result<Self, ChartError> {
        let Some(first) = scene.observe.values().next() else {
            return Err(ChartError::NoReference(scene.name));
        };
        let points = first.points.iter().map(|p| Vector2::from(*p)).collect();
        let equilateral = 3f64.sqrt() / 4.0 * scene.sheet.edge_length().powi(2);
        let triangles = (scene.sheet.outline.area() / equilateral).round() as usize;
        let duration = scene.duration;
        let meshes = vec![triangles / 4, triangles / 16];
        Ok(Self {
            points,
            meshes: meshes.into_iter().filter(|n| *n >= 20).collect(),
            finest: triangles,
            ..Self::made(scene, duration)
        })
    }

    /// A problem whose reference is to be made, looked at every 5 ms or twenty times.
    pub(super) fn made(mut scene: Scene, duration: f64) -> Self {
        let between = (duration / 20.0 / STEPS[0]).round().max(1.0) * STEPS[0];
        let count = (duration / between).round().max(1.0) as u32;
        scene.duration = f64::from(count) * between;
        Self {
            points: vec![],
            reference: None,
            times: (1..=count).map(|k| f64::from(k) * between).collect(),
            length: None,
            steps: STEPS.to_vec(),
            meshes: vec![],
            finest: 0,
            name: scene.name.clone(),
            budget: f64::INFINITY,
            scene,
        }
    }
}
