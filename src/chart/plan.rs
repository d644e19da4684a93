//! The cheapest method, step and mesh that keep what a scene observes within a tolerance, found by trying them.
//!
//! The mesh comes first, with the explicit scheme at its limit: it is refined until its error is small enough, by the
//! order with which that is seen to fall. Half the substep there is the truth in time of that mesh, and tells the error of
//! the limit, which is small unless the sheet whips. Every implicit method is tried against it, from long steps to short,
//! while it is cheaper than the best so far; first on a mesh of a quarter of the triangles, where one that is far dearer
//! is left. Where each step ends at rest, there is only the mesh to choose, only the end is looked at, and every mesh goes on
//! from the shape on the one before: else each might take other folds.

use super::course::CpuClock;
use super::mesh_error::{MeshError, apart, error_of_change};
pub use super::plan_error::PlanError;
use super::plan_meshes::{Level, is_at_rest, meshes, nested};
use crate::scene::{Method, Scene, Scheme, Solver};
use crate::sim::{Simulation, Work};

/// Moments of a run at which its readings are compared.
const MOMENTS: u32 = 20;
/// Halvings of the longest step, a moment's distance, that are tried.
const HALVINGS: u32 = 9;
/// What a method may cost on a mesh of a quarter of the triangles, over the explicit scheme there, to be tried on the mesh
/// itself; and what it may cost there in any case \[CPU-s\].
const DEARER_THERE: f64 = 2.0;
const LEAST_LOOK: f64 = 0.05;

/// A tolerance on what a scene observes, over the largest reading \[-\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance(pub f64);

impl std::str::FromStr for Tolerance {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (number, unit) = match text.strip_suffix('%') {
            Some(percent) => (percent.trim(), 1e-2),
            None => (text, 1.0),
        };
        let value = number.parse::<f64>().map(|n| n * unit).ok();
        let value = value.filter(|v| (1e-5..=0.5).contains(v));
        value
            .map(Self)
            .ok_or_else(|| "must be a share such as 1% or 0.01, from 0.001% to 50%".to_string())
    }
}

impl std::fmt::Display for Tolerance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} %", (1e6 * self.0).round() / 1e4)
    }
}

/// What was tried: a method on a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Tried {
    /// Scheme and solver.
    pub method: Method,
    /// Step; of the explicit scheme its substep \[s\].
    pub dt: f64,
    /// Triangles asked for.
    pub triangles: usize,
    /// CPU time of the whole run \[s\].
    pub cpu: f64,
    /// Its work.
    pub work: Work,
    /// Estimated error by the mesh or by the step, over the largest reading \[-\]; none if it died or was stopped, since
    /// it cost more than the best.
    pub error: Option<f64>,
}

/// The choice, and what led to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The scene with mesh, method and step chosen.
    pub scene: Scene,
    /// The choice.
    pub chosen: Tried,
    /// Estimated errors by the mesh and by the step \[-\].
    pub errors: [f64; 2],
    /// Order in the element size with which the mesh's error was seen to fall, 0.5 to 2, if it fell regularly \[-\].
    pub order: Option<f64>,
    /// Meshes, from coarse to fine.
    pub meshes: Vec<Tried>,
    /// Methods on the mesh that was chosen: of each the longest step that holds, or its last try.
    pub methods: Vec<Tried>,
}

/// The readings of a run at its moments.
pub(super) struct Seen {
    pub readings: Vec<Vec<f64>>,
    /// CPU time of its steps \[s\].
    pub cpu: f64,
    pub work: Work,
    pub substep: Option<f64>,
    /// Triangles of the mesh.
    pub faces: usize,
}

/// What ends a run early.
pub(super) enum Ended {
    Died(String),
    /// What it had cost \[CPU-s\] when it had come to a time \[s\].
    TooDear(f64, f64),
}

/// Finds the cheapest way that costs no more than `budget` \[CPU-s\]; `tell` hears what is being tried.
pub fn plan(
    scene: &Scene,
    (tolerance, budget): (Tolerance, f64),
    cpu: &mut CpuClock,
    tell: &mut dyn FnMut(&str),
) -> Result<Plan, PlanError> {
    if is_at_rest(scene) {
        let scene = nested(scene);
        let (levels, error) = meshes(&scene, (tolerance, budget), cpu, tell)?;
        return Ok(at_rest(&scene, levels, error));
    }
    let (mut levels, error) = meshes(scene, (tolerance, budget), cpu, tell)?;
    let (finest, space) = (levels.len() - 1, error.error);
    let mut methods = explicit(scene, &mut levels[finest], cpu, tell)?;
    let limit = levels[finest].tried.dt;
    let holds = |t: &&Tried| t.cpu <= budget && t.error.is_some_and(|e| e + space <= tolerance.0);
    let mut best = match methods.iter().find(holds) {
        Some(explicit) => explicit.clone(),
        None => {
            return Err(PlanError::TooSensitive {
                tolerance,
                triangles: methods[0].triangles,
                space,
                time: methods[1].error.unwrap_or(f64::INFINITY),
            });
        }
    };
    let (finest, screen) = (&levels[finest], &levels[finest.saturating_sub(2)]);
    let left = tolerance.0 - space;
    for method in candidates() {
        let most = (DEARER_THERE * screen.tried.cpu).max(LEAST_LOOK);
        let (tried, from) = longest(scene, method, (screen, 0), (left, most), cpu, tell);
        let Some(from) = from else {
            methods.extend(tried);
            continue;
        };
        let most = (left, best.cpu);
        let (tried, holds) = longest(scene, method, (finest, from), most, cpu, tell);
        methods.extend(tried.clone());
        if let (Some(tried), Some(_)) = (tried, holds) {
            best = tried;
        }
    }
    let errors = [space, best.error.unwrap_or(0.0)];
    let step = match best.method.scheme {
        Scheme::CentralDifference => moment(scene),
        _ => best.dt,
    };
    let mut scene = at(scene, best.method, step, best.triangles);
    if best.method.scheme == Scheme::CentralDifference && best.dt < limit {
        scene.method.substep = Some(best.dt);
    }
    Ok(Plan {
        scene,
        chosen: best,
        errors,
        order: error.order,
        meshes: levels.into_iter().map(|level| level.tried).collect(),
        methods,
    })
}

/// The last of some meshes on which a scene came to rest.
fn at_rest(scene: &Scene, levels: Vec<Level>, error: MeshError) -> Plan {
    let meshes: Vec<Tried> = levels.into_iter().map(|level| level.tried).collect();
    let chosen = meshes[meshes.len() - 1].clone();
    Plan {
        scene: scene.on_mesh(chosen.triangles),
        chosen,
        errors: [error.error, 0.0],
        order: error.order,
        meshes,
        methods: vec![],
    }
}

/// The explicit scheme on a mesh at its limit and at half of it, with their errors by their difference at second order;
/// the readings of the latter are the truth in time of the mesh.
fn explicit(
    scene: &Scene,
    mesh: &mut Level,
    cpu: &mut CpuClock,
    tell: &mut dyn FnMut(&str),
) -> Result<Vec<Tried>, PlanError> {
    let tried = &mesh.tried;
    tell(&format!("half the substep, {} triangles", tried.triangles));
    let mut halved = at(scene, tried.method, moment(scene), tried.triangles);
    halved.method.substep = Some(0.5 * tried.dt);
    let seen = run_to_end(&halved, cpu)?;
    let change = apart(&mesh.readings, &seen.readings);
    let limit = Tried {
        error: Some(4.0 / 3.0 * change),
        ..tried.clone()
    };
    let half = Tried {
        dt: 0.5 * tried.dt,
        cpu: seen.cpu,
        work: seen.work,
        error: Some(change / 3.0),
        ..tried.clone()
    };
    mesh.readings = seen.readings;
    Ok(vec![limit, half])
}

/// Tries a method on a mesh, from the step of so many halvings to shorter ones, until it holds what error is left for the
/// step, or costs more than the most \[CPU-s\]. Its last try, and the halvings with which it holds.
fn longest(
    scene: &Scene,
    method: Method,
    (mesh, from): (&Level, u32),
    (left, most): (f64, f64),
    cpu: &mut CpuClock,
    tell: &mut dyn FnMut(&str),
) -> (Option<Tried>, Option<u32>) {
    let triangles = mesh.tried.triangles;
    let mut last = None;
    for halving in from..=HALVINGS {
        let dt = moment(scene) / f64::from(1u32 << halving);
        let name = method.name();
        tell(&format!(
            "{name}, {triangles} triangles, {:.3} ms",
            1e3 * dt
        ));
        let (seen, spent) = match run(&at(scene, method, dt, triangles), most, cpu) {
            Ok(seen) => (Some(seen), 0.0),
            Err(Ended::TooDear(spent, _)) => (None, spent),
            Err(Ended::Died(_)) => continue,
        };
        let error = seen.as_ref().map(|s| apart(&s.readings, &mesh.readings));
        last = Some(Tried {
            method,
            dt,
            triangles,
            cpu: seen.as_ref().map_or(spent, |s| s.cpu),
            work: seen.as_ref().map_or(Work::default(), |s| s.work),
            error,
        });
        match error {
            Some(error) if error <= left => return (last, Some(halving)),
            Some(_) => {}
            None => break,
        }
    }
    (last, None)
}

/// The implicit methods; the explicit one is tried with the meshes.
fn candidates() -> impl Iterator<Item = Method> {
    let all = Method::IN_TIME.into_iter();
    all.filter(|m| m.scheme != Scheme::CentralDifference && m.solver != Solver::Xpbd)
}

/// From one moment of comparison to the next \[s\].
pub(super) fn moment(scene: &Scene) -> f64 {
    scene.duration / f64::from(MOMENTS)
}

/// A scene with another method, step and mesh, its outputs on its steps.
pub(super) fn at(scene: &Scene, method: Method, dt: f64, triangles: usize) -> Scene {
    let mut scene = scene.on_mesh(triangles);
    scene.method = scene.method.with(method);
    scene.method.dt = dt;
    scene.method.substep = None;
    scene.method.step_tolerance = None;
    scene.output.rate = scene.output.rate.min(1.0 / dt);
    scene
}

/// Runs a scene to its end, unless it dies or costs more than `most` \[s\].
pub(super) fn run(scene: &Scene, most: f64, cpu: &mut CpuClock) -> Result<Seen, Ended> {
    let died = |message: String| Ended::Died(message);
    let mut simulation = Simulation::new(scene, 1).map_err(|refused| died(refused.to_string()))?;
    let (moments, apart) = match is_at_rest(scene) {
        true => (1, scene.duration),
        false => (u64::from(MOMENTS), moment(scene)),
    };
    let between = (apart / scene.method.dt).round().max(1.0) as u64;
    let start = cpu();
    let mut seen = Seen {
        readings: vec![],
        cpu: 0.0,
        work: Work::default(),
        substep: simulation.substep(),
        faces: simulation.model().mesh.faces.len(),
    };
    for step in 1..=moments * between {
        let report = simulation
            .step()
            .map_err(|diverged| died(diverged.to_string()))?;
        seen.work += report.work;
        if step % between == 0 {
            seen.readings.push(report.readings.clone());
        }
        seen.cpu = cpu() - start;
        if seen.cpu > most {
            return Err(Ended::TooDear(seen.cpu, report.time));
        }
    }
    Ok(seen)
}

/// Runs a scene to its end, whatever that costs.
pub(super) fn run_to_end(scene: &Scene, cpu: &mut CpuClock) -> Result<Seen, PlanError> {
    run(scene, f64::INFINITY, cpu).map_err(|ended| match ended {
        Ended::Died(message) => PlanError::Died(message),
        Ended::TooDear(..) => PlanError::Died("a run without a limit was stopped".to_string()),
    })
}

/// A second look at a planned scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondLook {
    /// What half the step on twice the triangles changes, over the largest reading \[-\].
    pub change: f64,
    /// Error of the planned run that this tells of \[-\]: twice the change at first order in time or second in the element
    /// size, more where the mesh's error was seen to fall more slowly.
    pub error: f64,
}

/// Looks at a planned scene again, with half the step on twice the triangles.
///
/// # Errors
/// A run died.
pub fn check(plan: &Plan, cpu: &mut CpuClock) -> Result<SecondLook, PlanError> {
    let (chosen, scene) = (&plan.chosen, &plan.scene);
    let twice = 2 * chosen.triangles;
    let finer = match is_at_rest(scene) {
        true => scene.on_mesh(twice),
        false => at(scene, chosen.method, 0.5 * scene.method.dt, twice),
    };
    let (ours, theirs) = (run_to_end(scene, cpu)?, run_to_end(&finer, cpu)?);
    let change = apart(&ours.readings, &theirs.readings);
    let times = theirs.faces as f64 / ours.faces as f64;
    Ok(SecondLook {
        change,
        error: change * error_of_change(times, plan.order),
    })
}
