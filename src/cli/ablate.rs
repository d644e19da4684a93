//! `toile explain --ablate`: the scene once more with each optional piece of its physics toggled.

use serde_json::{Value, json};

use super::CliError;
use super::explained::Trial;
use super::output::{significant, table};
use crate::scene::{Scene, ablations};

/// What a toggle did.
pub(super) struct Ablated {
    name: String,
    /// Largest change of what is observed, over the largest value without the toggle \[-\].
    change: f64,
    /// CPU time over that without the toggle \[-\].
    cost: f64,
    /// The same in evaluations of the forces, which are counted, not timed \[-\].
    evaluations: f64,
    died: Option<String>,
}

/// Runs every toggle.
pub(super) fn run(scene: &Scene, base: &Trial) -> Result<Vec<Ablated>, CliError> {
    let mut done = vec![];
    for ablation in ablations(scene) {
        let trial = Trial::run(&ablation.scene, &ablation.name)?;
        let (ours, theirs) = (&trial.work, &base.work);
        done.push(Ablated {
            name: ablation.name,
            change: change(&trial.observed, &base.observed),
            cost: trial.cpu / base.cpu.max(f64::MIN_POSITIVE),
            evaluations: ours.evaluations as f64 / theirs.evaluations.max(1) as f64,
            died: trial.died,
        });
    }
    Ok(done)
}

/// Largest difference at any step that both took, over the largest value of the base.
fn change(ours: &[Vec<f64>], base: &[Vec<f64>]) -> f64 {
    let all = |a: &[Vec<f64>]| a.iter().flatten().map(|v| v.abs()).fold(0.0, f64::max);
    let apart = ours.iter().zip(base).flat_map(|(a, b)| a.iter().zip(b));
    apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / all(base).max(f64::MIN_POSITIVE)
}

/// As a table.
pub(super) fn text(ablated: &[Ablated]) -> String {
    let head = [
        "  toggled",
        "observed changes by",
        "CPU time",
        "evaluations",
        "",
    ];
    let mut rows = vec![head.map(str::to_string).to_vec()];
    rows.extend(ablated.iter().map(|a| {
        vec![
            format!("  {}", a.name),
            format!("{} %", significant(1e2 * a.change, 3)),
            format!("x {}", significant(a.cost, 3)),
            format!("x {}", significant(a.evaluations, 3)),
            a.died
                .clone()
                .map_or(String::new(), |died| format!("stopped: {died}")),
        ]
    }));
    format!("\none piece of physics toggled at a time\n{}", table(&rows))
}

/// As JSON.
pub(super) fn json(ablated: &[Ablated]) -> Value {
    ablated
        .iter()
        .map(|a| {
            json!({
                "toggled": a.name,
                "change": a.change,
                "cpu": a.cost,
                "evaluations": a.evaluations,
                "died": a.died,
            })
        })
        .collect()
}
