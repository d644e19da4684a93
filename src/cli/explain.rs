//! `toile explain`: the physics that a scene pays for, what it costs, and what it leaves out, measured on a short run.

use clap::Args;
use cpu_time::ProcessTime;
use serde_json::{Value, json};

use super::ablate;
use super::explained::{Cost, Trial, seconds};
use super::output::{self, significant, table};
use super::{CliError, source};
use crate::scene::{Override, Scene, Term, needs};
use crate::sim::{Neglect, stable_limit};

/// Simulated time of the run that is measured, unless the user says otherwise \[s\].
const SHORT: f64 = 0.2;

/// Arguments of `toile explain`.
#[derive(Args)]
pub(super) struct ExplainArgs {
    /// A built-in scene (see `toile list scenes`), a TOML file, or `-` for standard input.
    scene: String,
    /// Fabric of the catalogue, F1 to F12 (sets fabric.name).
    #[arg(long, value_name = "F")]
    fabric: Option<String>,
    /// Replace any key of the scene.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Simulated time of the runs that are measured, in seconds [default: the scene's, at most 0.2].
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    duration: Option<String>,
    /// Run the scene once more with each optional piece of its physics toggled: change of what it observes, and cost.
    #[arg(long)]
    ablate: bool,
    /// A JSON object instead of the tables.
    #[arg(long)]
    json: bool,
}

impl ExplainArgs {
    pub(super) fn run(&self) -> Result<(), CliError> {
        let scene = self.scene()?;
        let trial = Trial::run(&scene, "measuring")?;
        let explained = Explained {
            limit: stable_limit(trial.simulation.model()),
            costs: trial.costs(),
            neglects: trial.neglects.found(&trial.simulation),
            trial: &trial,
            scene: &scene,
        };
        let ablated = match self.ablate {
            true => ablate::run(&scene, &trial)?,
            false => vec![],
        };
        if self.json {
            let mut value = explained.json();
            if self.ablate {
                value["ablated"] = ablate::json(&ablated);
            }
            return output::print_json(&value);
        }
        let mut text = explained.text();
        if self.ablate {
            text += &ablate::text(&ablated);
        }
        output::print(&text)
    }

    fn scene(&self) -> Result<Scene, CliError> {
        let mut overrides = vec![];
        for set in &self.set {
            overrides.push(Override::parse(set)?);
        }
        let named = [("fabric.name", &self.fabric), ("duration", &self.duration)];
        for (key, value) in named {
            if let Some(value) = value {
                overrides.push(Override::parse(&format!("{key}={value}"))?);
            }
        }
        let (mut scene, _) = source::scene(&self.scene, &overrides)?;
        if self.duration.is_none() {
            scene.duration = scene.duration.min(SHORT);
        }
        Ok(scene)
    }
}

/// All that is said of a scene.
struct Explained<'a> {
    scene: &'a Scene,
    trial: &'a Trial,
    limit: f64,
    costs: Vec<Cost>,
    neglects: Vec<Neglect>,
}

impl Explained<'_> {
    fn text(&self) -> String {
        let trial = self.trial;
        let model = trial.simulation.model();
        let mut text = format!(
            "{}: {} with {}, {} triangles, {} s simulated in {} s of CPU time\n\nphysics that the scene pays for\n",
            self.scene.name,
            self.scene.fabric.name,
            self.scene.method.scheme.name(),
            output::thousands(model.mesh.faces.len()),
            output::trimmed(trial.simulation.report().time),
            significant(trial.cpu, 3),
        );
        if let Some(died) = &trial.died {
            text += &format!("  the run stopped: {died}\n");
        }
        let kept = needs(self.scene);
        let rows = kept
            .iter()
            .map(|(term, reason)| vec![format!("  {term}"), reason.clone(), self.share_of(*term)]);
        text += &table(&rows.collect::<Vec<_>>());
        text += "\nwhere the time goes (the time of one unit at the end of the run, times their number)\n";
        let rows = self.costs.iter().map(|cost| {
            vec![
                format!("  {}", cost.name),
                percent(cost.share),
                format!("{} x {}", cost.count, seconds(cost.unit)),
            ]
        });
        text += &table(&rows.collect::<Vec<_>>());
        text += "\nphysics left out, and the tolerance that would need it\n";
        let rows = self.neglects.iter().map(|n| {
            vec![
                format!("  {}", n.name),
                bound(n.ratio),
                n.measure.to_string(),
            ]
        });
        text += &table(&rows.collect::<Vec<_>>());
        text += &format!(
            "\nkinetic over strain energy at the end {}\nlargest stable step of the explicit scheme on this mesh, 2 / \
             omega_max: {}\n",
            significant(trial.neglects.inertia(), 2),
            seconds(self.limit)
        );
        text
    }

    /// Share of the time of all parts of a term.
    fn share_of(&self, term: Term) -> String {
        let mine: Vec<_> = self.costs.iter().filter(|c| c.term == Some(term)).collect();
        match mine.is_empty() {
            true => String::new(),
            false => percent(mine.iter().map(|c| c.share).sum()),
        }
    }

    fn json(&self) -> Value {
        let trial = self.trial;
        let kept: Vec<_> = needs(self.scene)
            .iter()
            .map(|(term, reason)| json!({"term": term.name(), "reason": reason}))
            .collect();
        let costs = self.costs.iter().map(|c| {
            json!({
                "part": c.name,
                "term": c.term.map(Term::name),
                "share": c.share,
                "count": c.count,
                "unit_seconds": c.unit,
            })
        });
        let neglected = self
            .neglects
            .iter()
            .map(|n| json!({"name": n.name, "ratio": n.ratio, "measure": n.measure}));
        json!({
            "scene": self.scene.name,
            "fabric": self.scene.fabric.name,
            "method": self.scene.method.scheme.name(),
            "triangles": trial.simulation.model().mesh.faces.len(),
            "simulated": trial.simulation.report().time,
            "cpu_seconds": trial.cpu,
            "died": trial.died,
            "work": trial.work,
            "kept": kept,
            "costs": costs.collect::<Vec<_>>(),
            "left_out": neglected.collect::<Vec<_>>(),
            "kinetic_over_strain": trial.neglects.inertia(),
            "explicit_limit": self.limit,
        })
    }
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 1e2 * share)
}

/// What a neglect ratio forbids.
fn bound(ratio: Option<f64>) -> String {
    match ratio {
        None => "none".to_string(),
        Some(ratio) if ratio >= 1.0 => "any".to_string(),
        Some(ratio) => format!("below {} %", significant(1e2 * ratio, 2)),
    }
}

/// CPU time of this process \[s\].
pub(super) fn cpu() -> f64 {
    ProcessTime::now().as_duration().as_secs_f64()
}
