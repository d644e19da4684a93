//! The mesh of a plan: refined with the explicit scheme at its limit, or at rest, until its error is small enough.

use super::course::CpuClock;
use super::mesh_error::{IRREGULAR_ORDER, MeshError, OnMesh};
use super::plan::{Ended, PlanError, Tolerance, Tried, at, moment, run};
use crate::scene::{Method, Scene, Scheme};

/// Fewest triangles.
const FEWEST: usize = 50;
/// Triangles that the scene asks for, over those that are tried first.
const FIRST: usize = 32;
/// Exponent of the cost of the explicit scheme by the number of triangles, at least.
const DEARER: f64 = 1.5;
/// What a mesh may be expected to cost, over the budget, before a scene is given up without trying what is between.
const HOPELESS: f64 = 8.0;
/// Share of the tolerance that the mesh may take; and where the next mesh would cost more than the budget, so that little is
/// left for the step.
const SPACE: f64 = 0.75;
const ALONE: f64 = 0.95;
/// Times the triangles from one mesh to the next: with fewer, what is left of the error is lost in the noise of random meshes.
const TIMES: usize = 2;

/// A mesh that was tried, with the readings on it.
pub(super) struct Level {
    pub tried: Tried,
    /// Triangles that it has.
    pub faces: usize,
    pub readings: Vec<Vec<f64>>,
}

/// Refines the mesh until its error is small enough; what was tried, and the error of the last.
pub(super) fn meshes(
    scene: &Scene,
    within: (Tolerance, f64),
    cpu: &mut CpuClock,
    tell: &mut dyn FnMut(&str),
) -> Result<(Vec<Level>, MeshError), PlanError> {
    let (tolerance, budget) = within;
    if scene.observe.is_empty() {
        return Err(PlanError::NothingObserved(scene.name.clone()));
    }
    let asked = scene.triangles().max(4 * FEWEST);
    let mut levels: Vec<Level> = vec![];
    let mut count = first(scene);
    loop {
        tell(&format!("mesh of {count} triangles"));
        let level = match level(scene, count, budget, cpu) {
            Ok(level) => level,
            // A mesh coarser than the scene's own may be too coarse for it.
            Err(Ended::Died(_)) if count < scene.triangles() => {
                count *= TIMES;
                continue;
            }
            Err(Ended::Died(message)) => return Err(PlanError::Died(message)),
            Err(Ended::TooDear(..)) => return last_resort(levels, within, is_at_rest(scene)),
        };
        let cost = level.tried.cpu;
        levels.push(level);
        let error = error_of(&levels);
        if let (Some(error), Some(level)) = (error, levels.last_mut()) {
            level.tried.error = Some(error.error);
            if error.error <= SPACE * tolerance.0 {
                return Ok((levels, error));
            }
        }
        let measured = error.filter(|e| e.order.is_some());
        let dearer = |times: f64, budgets: f64| cost * times.powf(DEARER) > budgets * budget;
        // Where even the elements' own order leads far beyond the budget, more runs tell nothing.
        let at_best = measured.map_or(1.0, |e| e.error / (SPACE * tolerance.0));
        let hopeless = 4 * count >= asked && dearer(at_best, HOPELESS);
        if dearer(TIMES as f64, 1.0) || hopeless {
            return last_resort(levels, within, is_at_rest(scene));
        }
        count *= TIMES;
    }
}

/// Whether each step of a scene ends at rest.
pub(super) fn is_at_rest(scene: &Scene) -> bool {
    scene.method.scheme == Scheme::Equilibrium
}

/// The scene with each mesh on which it comes to rest begun on those that are tried before it.
pub(super) fn nested(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.method.coarsest.get_or_insert(first(&scene));
    scene
}

/// Triangles of the mesh that is tried first.
fn first(scene: &Scene) -> usize {
    (scene.triangles() / FIRST).max(FEWEST)
}

/// Runs the explicit scheme on a mesh, or comes to rest on it.
fn level(scene: &Scene, count: usize, budget: f64, cpu: &mut CpuClock) -> Result<Level, Ended> {
    let (method, scene) = match is_at_rest(scene) {
        true => (Method::from(Scheme::Equilibrium), scene.on_mesh(count)),
        false => {
            let explicit = Method::from(Scheme::CentralDifference);
            (explicit, at(scene, explicit, moment(scene), count))
        }
    };
    let seen = run(&scene, budget, cpu)?;
    Ok(Level {
        tried: Tried {
            method,
            dt: seen.substep.unwrap_or(scene.method.dt),
            triangles: count,
            cpu: seen.cpu,
            work: seen.work,
            error: None,
        },
        faces: seen.faces,
        readings: seen.readings,
    })
}

fn error_of(levels: &[Level]) -> Option<MeshError> {
    let meshes = levels.iter().map(|level| OnMesh {
        triangles: level.faces,
        readings: &level.readings,
    });
    MeshError::of(&meshes.collect::<Vec<_>>())
}

/// The finest mesh that the budget allows, if it is good enough for the explicit scheme alone.
fn last_resort(
    levels: Vec<Level>,
    (tolerance, budget): (Tolerance, f64),
    at_rest: bool,
) -> Result<(Vec<Level>, MeshError), PlanError> {
    let (Some(error), Some(finest)) = (error_of(&levels), levels.last()) else {
        return Err(PlanError::TooDear { budget });
    };
    if error.error <= ALONE * tolerance.0 {
        return Ok((levels, error));
    }
    let order = error.order.unwrap_or(IRREGULAR_ORDER);
    let finer = (error.error / (SPACE * tolerance.0)).powf(2.0 / order);
    let finer = finer.max(TIMES as f64);
    Err(PlanError::TooFine {
        budget,
        triangles: finest.tried.triangles,
        cpu: finest.tried.cpu,
        tolerance,
        estimate: error.error,
        order,
        finer,
        dearer: finer.powf(DEARER),
        at_rest,
    })
}
