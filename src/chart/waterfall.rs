//! What each economy saves on a scene: the dearest way first, then one economy more at a time.

use super::course::CpuClock;
use super::mesh_error::apart;
use super::plan::{Ended, PlanError, Tolerance, at, moment, run, run_to_end};
use super::plan_meshes::{is_at_rest, meshes};
use crate::scene::{Method, Scene, Scheme, SleepSpec, Solver};

/// Longest implicit step \[s\].
const STEP: f64 = 1e-3;

/// A way to run the scene, with all economies before it.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// What is new.
    pub economy: String,
    /// Triangles asked for.
    pub triangles: usize,
    /// Scheme and solver.
    pub method: Method,
    /// CPU seconds per simulated second, one thread \[-\].
    pub cpu_rate: f64,
    /// Simulated time that it came to \[s\].
    pub simulated: f64,
    /// Largest error of what the scene observes, over its largest value \[-\]; none of a run that was left.
    pub error: Option<f64>,
}

/// Runs a scene in ever cheaper ways, each for `budget` \[CPU-s\] at most, on the scene's own mesh first and then on the
/// coarsest within the tolerance; errors are against central differences on twice the triangles of the finer of the two.
///
/// # Errors
/// As those of a plan: it observes nothing, has no time, no mesh is fine enough, or a run died.
pub fn waterfall(
    scene: &Scene,
    (tolerance, budget): (Tolerance, f64),
    cpu: &mut CpuClock,
    tell: &mut dyn FnMut(&str),
) -> Result<Vec<Bar>, PlanError> {
    if is_at_rest(scene) {
        return Err(PlanError::NoTime(scene.name.clone()));
    }
    // All ways solve the same equations.
    let scene = &scene.clone().without_unsaid_layers();
    let asked = scene.triangles();
    let (levels, _) = meshes(scene, (tolerance, budget), cpu, tell)?;
    let enough = levels.last().map_or(asked, |level| level.tried.triangles);
    let explicit = Method::from(Scheme::CentralDifference);
    let step = moment(scene) / (moment(scene) / STEP).ceil();
    tell("the reference");
    let finest = at(scene, explicit, moment(scene), 2 * asked.max(enough));
    let truth = run_to_end(&finest, cpu)?;
    let constant = Method {
        scheme: Scheme::Bdf2,
        solver: Solver::QuasiNewton,
    };
    let mut asleep = at(scene, explicit, moment(scene), enough);
    asleep.sleep = Some(SleepSpec::default());
    let ways = [
        (
            format!("bdf2, steps of {:.3} ms", 1e3 * step),
            at(scene, constant, step, asked),
        ),
        (
            "solver: a sparse factor of the tangent".to_string(),
            at(scene, Scheme::Bdf2.into(), step, asked),
        ),
        (
            "scheme: explicit, at its limit".to_string(),
            at(scene, explicit, moment(scene), asked),
        ),
        (
            format!("mesh: what {tolerance} needs"),
            at(scene, explicit, moment(scene), enough),
        ),
        ("sleep: nothing moves, nothing to do".to_string(), asleep),
    ];
    let mut bars = vec![];
    for (economy, way) in ways {
        tell(&economy);
        let (cpu_seconds, simulated, error) = match run(&way, budget, cpu) {
            Ok(seen) => {
                let error = apart(&seen.readings, &truth.readings);
                (seen.cpu, scene.duration, Some(error))
            }
            Err(Ended::TooDear(spent, time)) => (spent, time, None),
            Err(Ended::Died(message)) => return Err(PlanError::Died(message)),
        };
        bars.push(Bar {
            economy,
            triangles: way.sheet.triangles.unwrap_or(asked),
            method: way.method.method(),
            cpu_rate: cpu_seconds / simulated,
            simulated,
            error,
        });
    }
    Ok(bars)
}

/// As CSV, one way a row.
pub fn to_csv(bars: &[Bar]) -> String {
    let mut text = "economy,method,triangles,cpu_s_per_s,simulated_s,error\n".to_string();
    for bar in bars {
        let error = bar
            .error
            .map_or(String::new(), |error| format!("{error:e}"));
        text += &format!(
            "\"{}\",{},{},{},{},{error}\n",
            bar.economy,
            bar.method.name(),
            bar.triangles,
            bar.cpu_rate,
            bar.simulated
        );
    }
    text
}
