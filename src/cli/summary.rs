//! What a run came to, for people and for programs.

use serde_json::{Map, Value, json};

use super::output;
use crate::node::{Orders, Pace, Peak, Summary};
use crate::scene::{Scene, Scheme, Warning, needs};
use crate::sim::{Energies, Work};

/// The closing summary on a terminal.
pub(super) fn text(scene: &Scene, run: &Summary) -> String {
    let work = &run.work;
    let rate = output::significant(run.time / run.wall_seconds.max(1e-9), 2);
    let mut rows = vec![
        ("physics", physics(scene)),
        ("simulated", simulated(scene, run)),
        ("work", counted(work)),
        ("energies [mJ]", stored(&run.energies)),
        ("exchanged [mJ]", exchanged(&run.energies)),
        (
            "largest strain",
            peak(&run.largest_strain, "%", |strain| {
                output::significant(1e2 * strain, 3)
            }),
        ),
    ];
    if !scene.obstacle.is_empty() {
        let depth = peak(&run.deepest_penetration, "mm", |depth| {
            format!("{:.4}", 1e3 * depth)
        });
        rows.push(("deepest penetration", depth));
    }
    if run.slept > 0 {
        rows.push(("asleep", format!("{} of {} steps", run.slept, run.steps)));
    }
    if let (Some(_), Some(from)) = (scene.touches_itself(), run.layers.from) {
        let (from, touched) = (output::significant(from, 3), run.layers.steps);
        let said = format!("from {from} s on, after {touched} of {} steps", run.steps);
        rows.push(("layers touch", said));
    }
    if run.crossings > 0 {
        let counts = format!("{} edges passed through faces at most", run.crossings);
        rows.push(("sheet crosses itself", counts));
    }
    for (term, time) in &run.neglected {
        let since = format!("{term}, needed from {} s on", output::significant(*time, 3));
        rows.push(("NEGLECTED", since));
    }
    for (name, value) in &run.readings {
        rows.push((name, format!("{:.3} mm", 1e3 * value)));
    }
    rows.push((
        "time",
        format!(
            "{:.2} s wall ({rate} x real time), {:.2} s CPU",
            run.wall_seconds, run.cpu_seconds
        ),
    ));
    rows.extend(told(run));
    let mut next = String::new();
    if let Some(path) = &run.recording {
        let (file, megabytes) = (path.display(), run.recording_bytes as f64 * 1e-6);
        rows.push(("recording", format!("{file}, {megabytes:.2} MB")));
        next = format!("next: toile show {file} -o shot.png\n");
    }
    let rows: Vec<_> = rows
        .into_iter()
        .map(|(name, value)| vec![format!("  {name}"), value])
        .collect();
    let (fabric, method) = (&scene.fabric.name, scene.method.scheme.name());
    let head = format!(
        "{}: {fabric} with {method}, dt {} s\n",
        scene.name, scene.method.dt
    );
    head + &output::table(&rows) + &next
}

/// Work counted; of factorisations, how many had a cause other than an iterate's tangent.
fn counted(work: &Work) -> String {
    let causes = [
        (work.indefinite, "not positive definite"),
        (work.constant, "constant"),
        (work.tests, "tests of rest"),
    ];
    let causes: Vec<_> = causes
        .iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, cause)| format!("{count} {cause}"))
        .collect();
    let causes = match causes.is_empty() {
        true => String::new(),
        false => format!(" ({})", causes.join(", ")),
    };
    format!(
        "{} substeps, {} iterations, {} evaluations, {} factorisations{causes}, {} halvings, {} attempts repeated \
         smaller",
        work.substeps,
        work.iterations,
        work.evaluations,
        work.factorisations,
        work.halvings,
        work.rejected
    )
}

/// What came in, came late, what was dropped; nothing of what there was not.
fn told(run: &Summary) -> Vec<(&'static str, String)> {
    let (orders, late) = (&run.orders, &run.lateness);
    let mut rows = vec![];
    if *orders != Orders::default() {
        let counts = format!(
            "{} applied, {} rejected, {} malformed, {} dropped, {} too late",
            orders.applied, orders.rejected, orders.malformed, orders.dropped, orders.late
        );
        rows.push(("commands", counts));
    }
    if let Pace::Factor(_) = run.pace {
        let counts = format!(
            "{}: {} of {} steps late, by {} ms at most; {} s given up",
            run.pace,
            late.overruns,
            run.steps,
            output::significant(1e3 * late.worst, 3),
            output::significant(late.slipped, 3)
        );
        rows.push(("pace", counts));
    }
    for live in &run.live {
        let failure = live.failure.as_ref();
        let failure = failure.map_or(String::new(), |reason| format!("; FAILED: {reason}"));
        let counts = format!(
            "{}: {} messages, {} dropped{failure}",
            live.name, live.carried, live.dropped
        );
        rows.push(("carrier", counts));
    }
    rows
}

/// The terms that the scene pays for.
fn physics(scene: &Scene) -> String {
    let terms: Vec<_> = needs(scene).iter().map(|(term, _)| term.name()).collect();
    terms.join(", ")
}

fn simulated(scene: &Scene, run: &Summary) -> String {
    let end = match run.stopped {
        true => format!(" (stopped before {} s)", scene.duration),
        false => String::new(),
    };
    let converged = match run.converged {
        true if scene.method.scheme == Scheme::Equilibrium => {
            "every step ended at rest, at a minimum of the energy"
        }
        true => "every step converged",
        false => "NOT every step converged",
    };
    format!("{:.4} s in {} steps{end}, {converged}", run.time, run.steps)
}

/// Largest value of a run and the last one.
fn peak(peak: &Peak, unit: &str, shown: impl Fn(f64) -> String) -> String {
    let (largest, end) = (shown(peak.largest), shown(peak.end));
    format!("{largest} {unit} ({end} {unit} at the end)")
}

/// Energies by name, in millijoules.
fn millijoules(terms: &[(&str, f64)]) -> String {
    let terms: Vec<_> = terms
        .iter()
        .map(|(name, joules)| format!("{name} {}", output::significant(1e3 * joules, 4)))
        .collect();
    terms.join(", ")
}

fn stored(energies: &Energies) -> String {
    millijoules(&[
        ("kinetic", energies.kinetic),
        ("stretch", energies.stretch),
        ("bend", energies.bend),
        ("gravity", energies.gravity),
        ("contact", energies.contact),
    ])
}

fn exchanged(energies: &Energies) -> String {
    let taken = millijoules(&[
        ("damping", energies.damping),
        ("friction", energies.friction),
    ]);
    let put = millijoules(&[("supports", energies.supports), ("air", energies.air)]);
    format!("out by {taken}; in by {put}")
}

/// The same as a JSON object, SI units throughout.
pub(super) fn json(scene: &Scene, warnings: &[Warning], run: &Summary) -> Value {
    let readings: Map<_, _> = run
        .readings
        .iter()
        .map(|(name, value)| (name.clone(), json!(value)))
        .collect();
    let warnings: Vec<_> = warnings.iter().map(ToString::to_string).collect();
    json!({
        "scene": scene.name,
        "fabric": scene.fabric.name,
        "method": scene.method.scheme.name(),
        "dt": scene.method.dt,
        "duration": scene.duration,
        "time": run.time,
        "steps": run.steps,
        "slept": run.slept,
        "physics": needs(scene).iter().map(|(term, _)| term.name()).collect::<Vec<_>>(),
        "stopped": run.stopped,
        "converged": run.converged,
        "work": run.work,
        "energies": run.energies,
        "readings": readings,
        "largest_strain": run.largest_strain,
        "deepest_penetration": run.deepest_penetration,
        "crossings": run.crossings,
        "layers": run.layers,
        "neglected": run.neglected.iter().map(|(term, time)| json!({ "term": term, "from": time })).collect::<Vec<_>>(),
        // Programs read JSON numbers as doubles, which do not hold 64 bits.
        "digest": format!("{:016x}", run.digest),
        "pace": run.pace.to_string(),
        "lateness": run.lateness,
        "commands": run.orders,
        "live": run.live,
        "wall_seconds": run.wall_seconds,
        "cpu_seconds": run.cpu_seconds,
        "recording": run.recording,
        "recording_bytes": run.recording_bytes,
        "warnings": warnings,
    })
}
