//! Where a method converges, where it stays finite but is wrong, and where it loses the sheet: step x stiffness x mesh,
//! with the limit of the explicit scheme over it.

use super::course::{CpuClock, Watch};
use super::reference::Reference;
use super::rows::{Asked, Key, Row};
use super::work_precision::{ChartError, Problem};
use crate::scene::{Method, Scene, Scheme};
use crate::sim::{Model, stable_limit};

/// Membrane stiffness over that of the fabric \[-\].
pub const STIFFNESSES: [f64; 4] = [0.1, 1.0, 10.0, 100.0];
/// Steps \[s\], and those that only the explicit scheme takes, which pays little for them.
pub const STEPS: [f64; 7] = [1e-2, 5e-3, 2.5e-3, 1e-3, 5e-4, 2.5e-4, 1e-4];
const SMALL_STEPS: [f64; 2] = [5e-5, 2.5e-5];
/// Meshes, by their number of triangles.
pub const MESHES: [usize; 2] = [50, 200];
/// Error over the largest displacement up to which a run counts as right \[-\].
pub const RIGHT: f64 = 0.05;
/// Simulated time at most \[s\].
const DURATION: f64 = 0.1;

/// What became of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It ended within [`RIGHT`] of the truth of its own mesh.
    Right,
    /// It ended elsewhere.
    Wrong,
    /// It stopped, with a typed error.
    Lost,
}

impl Fate {
    /// Of a row.
    pub fn of(row: &Row) -> Self {
        match row.error() {
            Some(error) if error <= RIGHT => Self::Right,
            Some(_) => Self::Wrong,
            None => Self::Lost,
        }
    }
}

/// One stiffness and mesh of a scene.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Stiffness over that of the fabric \[-\].
    pub stiffness: f64,
    /// Triangles asked for.
    pub triangles: usize,
    /// Largest stable step of the explicit scheme, 2 / omega_max \[s\].
    pub limit: f64,
    /// The runs.
    pub problem: Problem,
}

/// All cells of a scene's chart.
pub fn cells(scene: &Scene) -> Result<Vec<Cell>, ChartError> {
    let whole = Problem::of(scene.clone())?;
    let mut cells = vec![];
    for triangles in MESHES {
        for stiffness in STIFFNESSES {
            cells.push(cell(&whole, stiffness, triangles)?);
        }
    }
    Ok(cells)
}

fn cell(whole: &Problem, stiffness: f64, triangles: usize) -> Result<Cell, ChartError> {
    let mut scene = whole.scene.on_mesh(triangles);
    let refused = |_| ChartError::NoReference(whole.scene.name.clone());
    let fabric = scene.fabric.resolve().map_err(refused)?;
    scene.fabric.young_warp = Some(stiffness * fabric.young_warp);
    scene.fabric.young_weft = Some(stiffness * fabric.young_weft);
    scene.fabric.shear_modulus = Some(stiffness * fabric.shear_modulus);
    let fabric = scene.fabric.resolve().map_err(refused)?;
    let limit = stable_limit(&Model::new(&scene, fabric));
    let count = (DURATION.min(scene.duration) / STEPS[0]).round().max(1.0) as u32;
    let problem = Problem {
        name: whole.name.clone(),
        points: whole.points.clone(),
        times: (1..=count).map(|k| f64::from(k) * STEPS[0]).collect(),
        steps: STEPS.to_vec(),
        meshes: vec![triangles],
        finest: triangles,
        budget: whole.budget,
        length: None,
        reference: None,
        scene,
    };
    Ok(Cell {
        stiffness,
        triangles,
        limit,
        problem,
    })
}

impl Cell {
    /// Keys of its runs.
    pub fn plan(&self) -> Vec<Key> {
        let mut keys = vec![];
        for method in Method::IN_TIME {
            let mut steps = STEPS.to_vec();
            if method.scheme == Scheme::CentralDifference {
                steps.extend(SMALL_STEPS);
            }
            keys.extend(steps.into_iter().map(|dt| self.key(method, dt)));
        }
        keys
    }

    /// The key of one run: its mesh names the stiffness, too.
    pub fn key(&self, method: Method, dt: f64) -> Key {
        let key = self.problem.key(method, Asked::Step(dt), self.triangles);
        Key {
            mesh: format!("{},stiffness={}", key.mesh, self.stiffness),
            ..key
        }
    }

    /// What is right here: the explicit scheme well within its limit.
    pub fn truth(&self, watch: &mut Watch) -> Result<Reference, ChartError> {
        self.problem.truth_on(self.triangles, watch)
    }

    /// One run.
    pub fn run(&self, key: &Key, truth: &Reference, cpu: &mut CpuClock, watch: &mut Watch) -> Row {
        let plain = self.problem.key(key.method, key.asked, self.triangles);
        Row {
            key: key.clone(),
            ..self.problem.run(&plain, (truth, None), cpu, watch)
        }
    }
}
