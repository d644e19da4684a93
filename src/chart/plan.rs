//! The cheapest method, step and mesh that keep what a scene observes within a tolerance, found by trying them.
//!
//! The mesh comes first, with the explicit scheme at its limit, whose error in time is far below any tolerance here:
//! triangles are doubled until what they change is small enough. That run then is the truth in time of its mesh, and
//! every implicit method is tried against it, from long steps to short, while it is cheaper than the best so far; first
//! on a mesh of a quarter of the triangles, where one that is far dearer is left.

use super::course::CpuClock;
use crate::scene::{Method, Scene, Scheme, Solver};
use crate::sim::{Simulation, Work};

/// Moments of a run at which its readings are compared.
const MOMENTS: u32 = 20;
/// Halvings of the longest step, a moment's distance, that are tried.
const HALVINGS: u32 = 9;
/// Fewest triangles.
const FEWEST: usize = 50;
/// Triangles that the scene asks for, over those that are tried first.
const FIRST: usize = 32;
/// Exponent of the cost of the explicit scheme by the number of triangles, at least.
const DEARER: f64 = 1.5;
/// What a method may cost on a mesh of a quarter of the triangles, over the explicit scheme there, to be tried on the mesh
/// itself; and what it may cost there in any case \[CPU-s\].
const DEARER_THERE: f64 = 2.0;
const LEAST_LOOK: f64 = 0.05;
/// What a mesh may be expected to cost, over the budget, before a scene is given up without trying what is between.
const HOPELESS: f64 = 8.0;
/// Share of the tolerance that the mesh may take.
const SPACE: f64 = 0.75;

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

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// Nothing to hold to the tolerance.
    #[error("scene `{0}` observes nothing; give it an [observe.NAME]")]
    NothingObserved(String),
    /// It has no time.
    #[error(
        "scene `{0}` looks for an equilibrium, which has no step to plan; plan its transient with --set method.scheme=bdf2"
    )]
    NoTime(String),
    /// The mesh would have to be finer than is tried.
    #[error(
        "no mesh that runs in {budget} CPU seconds is within {tolerance}: {triangles} triangles are {:.1} % off by their \
         own estimate in {cpu:.1} s, and half of that takes twice as many; try a wider --tolerance, a shorter --duration \
         or a larger --budget", 1e2 * estimate
    )]
    TooFine {
        /// What a run may cost \[CPU-s\].
        budget: f64,
        /// Triangles of the finest mesh that was tried.
        triangles: usize,
        /// What it cost \[CPU-s\].
        cpu: f64,
        /// Asked for.
        tolerance: Tolerance,
        /// Estimated error of the finest mesh \[-\].
        estimate: f64,
    },
    /// A run that must not fail did.
    #[error("{0}")]
    Died(String),
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
    substep: Option<f64>,
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
    let (levels, space) = meshes(scene, (tolerance, budget), cpu, tell)?;
    let finest = &levels[levels.len() - 1];
    let screen = &levels[levels.len().saturating_sub(3)];
    let left = tolerance.0 - space;
    let mut best = Tried {
        error: Some(0.0),
        ..finest.tried.clone()
    };
    let mut methods = vec![best.clone()];
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
    let scene = match best.method.scheme {
        Scheme::CentralDifference => at(scene, best.method, moment(scene), best.triangles),
        _ => at(scene, best.method, best.dt, best.triangles),
    };
    Ok(Plan {
        scene,
        chosen: best,
        errors,
        meshes: levels.into_iter().map(|level| level.tried).collect(),
        methods,
    })
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

/// A mesh that was tried, with the readings on it.
pub(super) struct Level {
    pub tried: Tried,
    pub readings: Vec<Vec<f64>>,
}

/// Doubles triangles until their error is small enough; what was tried, and the error of the last. At second order half
/// the triangles are twice as far off, so what doubling changes is the error of the finer; half of what the doubling
/// before changed bounds it where two meshes happen to agree.
pub(super) fn meshes(
    scene: &Scene,
    (tolerance, budget): (Tolerance, f64),
    cpu: &mut CpuClock,
    tell: &mut dyn FnMut(&str),
) -> Result<(Vec<Level>, f64), PlanError> {
    if scene.observe.is_empty() {
        return Err(PlanError::NothingObserved(scene.name.clone()));
    }
    if scene.method.scheme == Scheme::Equilibrium {
        return Err(PlanError::NoTime(scene.name.clone()));
    }
    let asked = triangles(scene).max(4 * FEWEST);
    let explicit = Method::from(Scheme::CentralDifference);
    let mut levels: Vec<Level> = vec![];
    let mut change = f64::INFINITY;
    let mut count = (asked / FIRST).max(FEWEST);
    loop {
        tell(&format!("mesh of {count} triangles"));
        let too_fine = |levels: &[Level]| {
            let finest = levels.last().map(|level| &level.tried);
            PlanError::TooFine {
                budget,
                triangles: finest.map_or(0, |t| t.triangles),
                cpu: finest.map_or(0.0, |t| t.cpu),
                tolerance,
                estimate: finest.and_then(|t| t.error).unwrap_or(f64::INFINITY),
            }
        };
        let seen = match run(&at(scene, explicit, moment(scene), count), budget, cpu) {
            Ok(seen) => seen,
            Err(Ended::Died(message)) => return Err(PlanError::Died(message)),
            Err(Ended::TooDear(..)) => return Err(too_fine(&levels)),
        };
        let before = levels.last();
        let changed = before.map(|level| apart(&level.readings, &seen.readings));
        let error = changed.map(|changed| changed.max(0.5 * change));
        let tried = Tried {
            method: explicit,
            dt: seen.substep.unwrap_or_default(),
            triangles: count,
            cpu: seen.cpu,
            work: seen.work,
            error: error.filter(|e| e.is_finite()),
        };
        levels.push(Level {
            tried,
            readings: seen.readings,
        });
        if let Some(error) = error.filter(|e| *e <= SPACE * tolerance.0) {
            return Ok((levels, error));
        }
        // Half the error for twice the triangles: where that leads far beyond the budget, more runs tell nothing.
        let known = error.filter(|e| e.is_finite());
        let times = known.map_or(1.0, |e| e / (SPACE * tolerance.0));
        let hopeless = 4 * count >= asked && seen.cpu * times.powf(DEARER) > HOPELESS * budget;
        if seen.cpu * 2f64.powf(DEARER) > budget || hopeless {
            return Err(too_fine(&levels));
        }
        change = changed.unwrap_or(f64::INFINITY);
        count *= 2;
    }
}

/// Triangles that a scene asks for.
pub(super) fn triangles(scene: &Scene) -> usize {
    let equilateral = 3f64.sqrt() / 4.0 * scene.sheet.edge_length().powi(2);
    let by_edge = (scene.sheet.outline.area() / equilateral).round() as usize;
    scene.sheet.triangles.unwrap_or(by_edge)
}

/// From one moment of comparison to the next \[s\].
pub(super) fn moment(scene: &Scene) -> f64 {
    scene.duration / f64::from(MOMENTS)
}

/// A scene with another method, step and mesh, its outputs on its steps.
pub(super) fn at(scene: &Scene, method: Method, dt: f64, triangles: usize) -> Scene {
    let mut scene = scene.clone();
    scene.method = scene.method.with(method);
    scene.method.dt = dt;
    scene.method.substep = None;
    scene.method.step_tolerance = None;
    scene.sheet.triangles = Some(triangles);
    scene.sheet.edge = None;
    scene.output.rate = scene.output.rate.min(1.0 / dt);
    scene
}

/// Runs a scene to its end, unless it dies or costs more than `most` \[s\].
pub(super) fn run(scene: &Scene, most: f64, cpu: &mut CpuClock) -> Result<Seen, Ended> {
    let died = |message: String| Ended::Died(message);
    let mut simulation = Simulation::new(scene, 1).map_err(|refused| died(refused.to_string()))?;
    let between = (moment(scene) / scene.method.dt).round() as u64;
    let start = cpu();
    let mut seen = Seen {
        readings: vec![],
        cpu: 0.0,
        work: Work::default(),
        substep: simulation.substep(),
    };
    for step in 1..=u64::from(MOMENTS) * between {
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

/// Largest difference at any moment over the largest reading.
pub(super) fn apart(ours: &[Vec<f64>], truth: &[Vec<f64>]) -> f64 {
    let largest = truth.iter().flatten().map(|v| v.abs()).fold(0.0, f64::max);
    let pairs = ours.iter().flatten().zip(truth.iter().flatten());
    let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    worst / largest.max(f64::MIN_POSITIVE)
}

/// Error of a planned scene by a second look: half the step on twice the triangles. What that changes is at least half
/// of the error at first order in time, all of it at second order in space.
pub fn check(plan: &Plan, cpu: &mut CpuClock) -> Result<f64, PlanError> {
    let (chosen, scene) = (&plan.chosen, &plan.scene);
    let finer = at(
        scene,
        chosen.method,
        0.5 * scene.method.dt,
        2 * chosen.triangles,
    );
    let (ours, theirs) = (run_to_end(scene, cpu)?, run_to_end(&finer, cpu)?);
    Ok(apart(&ours.readings, &theirs.readings))
}
