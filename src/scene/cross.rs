//! What no key can say alone: values that must fit each other.

use nalgebra::Vector3;

use super::FabricError;
use super::check::refuse_key;
use super::error::{Problem, SceneError};
use super::layers::LayerContact;
use super::method::{Method, Scheme, Solver};
use super::quantity::short;
use super::ranges::{SPEED, TURN_RATE};
use super::spec::{Region, Scene};
use super::tree::Node;
use crate::contact::Motion;
use crate::sheet::Outline;

/// A conflict: the key to blame and why.
type Conflict = (String, Problem);

/// Checks a scene whose keys are each in range. `document` says where they were written.
pub(super) fn check(scene: &Scene, document: &Node) -> Result<(), SceneError> {
    let checks = [
        mesh_size,
        outline,
        fabric,
        held_and_loaded,
        refine,
        friction,
        motions,
        air,
        observations,
        method,
        step_tolerance,
        coarsest,
        times,
    ];
    for check in checks {
        check(scene).map_err(|(key, problem)| {
            let (node, exact) = document.find(&key);
            // A fabric knows the value it refuses; another key left to its default has none to show.
            let value = match &problem {
                Problem::Fabric(FabricError::Unphysical(reason)) => Some(short(reason.value)),
                _ => (exact && node.is_leaf()).then(|| node.shown()),
            };
            SceneError {
                value,
                ..refuse_key(node, &key, problem)
            }
        })?;
    }
    Ok(())
}

fn conflict(key: impl Into<String>, reason: impl Into<String>) -> Result<(), Conflict> {
    Err((key.into(), Problem::Conflict(reason.into())))
}

/// Most triangles that a scene may ask for.
const MOST_TRIANGLES: f64 = 2e6;

fn mesh_size(scene: &Scene) -> Result<(), Conflict> {
    let sheet = &scene.sheet;
    match (sheet.triangles, sheet.edge) {
        (None, None) => conflict(
            "sheet",
            "needs exactly one of triangles (how many) and edge (how long, m)",
        ),
        (Some(_), Some(_)) => conflict(
            "sheet.triangles",
            "give exactly one of sheet.triangles and sheet.edge, not both",
        ),
        (Some(_), None) => Ok(()),
        (None, Some(edge)) => {
            let (finest, coarsest) = (
                sheet.outline.equilateral_edge(MOST_TRIANGLES),
                sheet.outline.equilateral_edge(2.0),
            );
            if (finest..=coarsest).contains(&edge) {
                return Ok(());
            }
            let expected = format!(
                "from {} to {} m for this outline (2 million triangles to 2)",
                short(finest),
                short(coarsest)
            );
            Err(("sheet.edge".into(), Problem::OutOfRange { expected }))
        }
    }
}

fn outline(scene: &Scene) -> Result<(), Conflict> {
    match scene.sheet.outline {
        Outline::Annulus { outer, inner } | Outline::Sector { outer, inner, .. }
            if inner >= outer =>
        {
            conflict(
                "sheet.outline.inner",
                format!("must be less than sheet.outline.outer = {outer} m"),
            )
        }
        _ => Ok(()),
    }
}

fn fabric(scene: &Scene) -> Result<(), Conflict> {
    match scene.fabric.resolve() {
        Ok(_) => Ok(()),
        Err(error) => Err((format!("fabric.{}", error.field()), error.into())),
    }
}

fn held_and_loaded(scene: &Scene) -> Result<(), Conflict> {
    for (name, support) in &scene.support {
        region(scene, &support.region, &format!("support.{name}.region"))?;
    }
    for (name, load) in &scene.load {
        region(scene, &load.region, &format!("load.{name}.region"))?;
    }
    Ok(())
}

/// Checks a part of the sheet, named by its `key`.
fn region(scene: &Scene, region: &Region, key: &str) -> Result<(), Conflict> {
    let outline = &scene.sheet.outline;
    let refuse = |field: &str, reason: &str| conflict(format!("{key}{field}"), reason);
    match *region {
        Region::XMin | Region::XMax | Region::YMin | Region::YMax => {
            if !matches!(outline, Outline::Rectangle { .. }) {
                let reason =
                    "only a rectangle has this side; use boundary, box, disc, ring or point";
                return refuse(".kind", reason);
            }
        }
        Region::Box { min, max } => {
            let half = outline.half_extent();
            if !(0..2).all(|i| min[i] <= max[i]) {
                return refuse(".min", "must not exceed max in x or y");
            }
            if !(0..2).all(|i| min[i] <= half[i] && max[i] >= -half[i]) {
                return refuse("", "the box lies outside the sheet");
            }
        }
        Region::Ring { outer, inner } if inner > outer => {
            return refuse(".inner", &format!("must not exceed outer = {outer} m"));
        }
        Region::Point { at } if !outline.contains(&at) => {
            return refuse(".at", "the point lies outside the sheet");
        }
        Region::Point { .. } | Region::Boundary | Region::Disc { .. } | Region::Ring { .. } => {}
    }
    Ok(())
}

fn refine(scene: &Scene) -> Result<(), Conflict> {
    let sheet = &scene.sheet;
    let Some(refine) = &sheet.refine else {
        return Ok(());
    };
    region(scene, &refine.region, "sheet.refine.region")?;
    let (Some(edge), finest) = (sheet.edge, sheet.outline.equilateral_edge(MOST_TRIANGLES)) else {
        return Ok(());
    };
    if refine.factor * edge < finest {
        let expected = format!(
            "at least {} for sheet.edge = {} m (2 million triangles)",
            short(finest / edge),
            short(edge)
        );
        return Err((
            "sheet.refine.factor".into(),
            Problem::OutOfRange { expected },
        ));
    }
    Ok(())
}

/// What sticks holds no worse than what slides; `xpbd` knows one coefficient alone.
fn friction(scene: &Scene) -> Result<(), Conflict> {
    for (name, obstacle) in &scene.obstacle {
        let Some(sticking) = obstacle.friction_static else {
            continue;
        };
        let key = format!("obstacle.{name}.friction_static");
        if sticking < obstacle.friction {
            let sliding = short(obstacle.friction);
            let reason = format!("must be at least obstacle.{name}.friction = {sliding}");
            return conflict(key, reason);
        }
        if scene.method.solver == Solver::Xpbd {
            return conflict(
                key,
                "method.solver = xpbd has no static friction; leave it out",
            );
        }
    }
    Ok(())
}

/// A motion has a pose for each time, and no pose is reached faster than an obstacle may be moved.
fn motions(scene: &Scene) -> Result<(), Conflict> {
    for (name, obstacle) in &scene.obstacle {
        if let Some(motion) = &obstacle.motion {
            let key = format!("obstacle.{name}.motion");
            let lists = [
                ("positions", &motion.positions),
                ("rotations", &motion.rotations),
            ];
            series(&key, &motion.times, lists)?;
            swiftness(
                &key,
                &motion.through((obstacle.position, obstacle.rotation)),
            )?;
        }
    }
    for (name, support) in &scene.support {
        if let Some(motion) = &support.motion {
            let key = format!("support.{name}.motion");
            let lists = [
                ("displacements", &motion.displacements),
                ("rotations", &motion.rotations),
            ];
            series(&key, &motion.times, lists)?;
            swiftness(&key, &motion.about(&Vector3::zeros()))?;
        }
    }
    Ok(())
}

fn series(
    key: &str,
    times: &[f64],
    lists: [(&str, &Option<Vec<[f64; 3]>>); 2],
) -> Result<(), Conflict> {
    if !times.is_sorted_by(|a, b| a < b) {
        return conflict(format!("{key}.times"), "must rise");
    }
    if lists.iter().all(|(_, list)| list.is_none()) {
        let [one, other] = lists.map(|(name, _)| name);
        return conflict(key, format!("needs {one}, {other} or both"));
    }
    for (name, list) in lists {
        let found = list.as_ref().map_or(times.len(), Vec::len);
        if found != times.len() {
            let reason = format!("has {found} entries; must be {}, one a time", times.len());
            return conflict(format!("{key}.{name}"), reason);
        }
    }
    Ok(())
}

fn swiftness(key: &str, motion: &Motion) -> Result<(), Conflict> {
    let (speed, turn) = motion.fastest();
    for (found, most, unit) in [(speed, SPEED.max, "m/s"), (turn, TURN_RATE.max, "rad/s")] {
        if found > most {
            let reason = format!(
                "goes at up to {} {unit}; at most {} {unit}",
                short(found),
                short(most)
            );
            return conflict(format!("{key}.times"), reason);
        }
    }
    Ok(())
}

fn air(scene: &Scene) -> Result<(), Conflict> {
    match scene.air.and_then(|air| air.region) {
        Some(region) if !(0..3).all(|i| region.min[i] < region.max[i]) => {
            conflict("air.region.min", "must be less than max in x, y and z")
        }
        _ => Ok(()),
    }
}

fn observations(scene: &Scene) -> Result<(), Conflict> {
    for (name, observe) in &scene.observe {
        match (&observe.region, observe.points.is_empty()) {
            (None, true) => {
                return conflict(format!("observe.{name}"), "give it points or a region");
            }
            (Some(_), false) => {
                return conflict(format!("observe.{name}.region"), "goes without points");
            }
            (Some(part), true) => region(scene, part, &format!("observe.{name}.region"))?,
            (None, false) => {}
        }
        let outside = |point: &&[f64; 2]| !scene.sheet.outline.contains(point);
        if let Some([x, y]) = observe.points.iter().find(outside) {
            return conflict(
                format!("observe.{name}.points"),
                format!("the point [{x}, {y}] lies outside the sheet"),
            );
        }
    }
    Ok(())
}

fn method(scene: &Scene) -> Result<(), Conflict> {
    let layers = scene.layers.is_some_and(|l| l.contact == LayerContact::On);
    match scene.method.method() {
        Method {
            solver: Solver::QuasiNewton | Solver::Xpbd,
            ..
        } if layers => conflict(
            "method.solver",
            "layers need newton, or method.scheme = central-difference; or set layers.contact = off",
        ),
        Method { scheme, solver }
            if scene.sleep.is_some()
                && (scheme == Scheme::Equilibrium || solver == Solver::Xpbd) =>
        {
            conflict(
                "sleep",
                "needs a scheme in time that knows accelerations: not equilibrium, not xpbd",
            )
        }
        Method {
            scheme: Scheme::CentralDifference,
            solver: Solver::QuasiNewton | Solver::Xpbd,
        } => conflict(
            "method.solver",
            "central-difference solves no equations; leave method.solver out",
        ),
        Method {
            scheme,
            solver: Solver::Xpbd,
        } if scheme != Scheme::BackwardEuler => conflict(
            "method.solver",
            "xpbd goes with method.scheme = backward-euler alone",
        ),
        Method {
            scheme: Scheme::Equilibrium,
            solver: Solver::QuasiNewton,
        } => conflict(
            "method.solver",
            "equilibrium needs newton, whose tangent says whether a state is a minimum",
        ),
        _ => Ok(()),
    }
}

fn step_tolerance(scene: &Scene) -> Result<(), Conflict> {
    let spec = &scene.method;
    let method = spec.method();
    if spec.step_tolerance.is_none() || method.knows_its_error() {
        return Ok(());
    }
    let reason = format!(
        "{} estimates no error of a step; backward-euler, bdf2 and generalised-alpha do",
        method.name()
    );
    conflict("method.step_tolerance", reason)
}

fn coarsest(scene: &Scene) -> Result<(), Conflict> {
    match (scene.method.coarsest, scene.method.scheme) {
        (None, _) | (Some(_), Scheme::Equilibrium) => Ok(()),
        (Some(_), _) => conflict("method.coarsest", "needs method.scheme = equilibrium"),
    }
}

fn times(scene: &Scene) -> Result<(), Conflict> {
    let dt = scene.method.dt;
    if scene.duration < dt {
        return conflict(
            "duration",
            format!("must be at least one step: method.dt = {} s", short(dt)),
        );
    }
    if scene.method.substep.is_some_and(|substep| substep > dt) {
        let expected = format!("at most method.dt = {} s, the step it divides", short(dt));
        return Err(("method.substep".into(), Problem::OutOfRange { expected }));
    }
    // One part in a million: 1 / (1 / 3) is not 3.
    if scene.output.rate * dt > 1.0 + 1e-6 {
        let expected = format!(
            "at most 1/method.dt = {} Hz, one output per step",
            short(1.0 / dt)
        );
        return Err(("output.rate".into(), Problem::OutOfRange { expected }));
    }
    Ok(())
}
