//! `toile plan`: the cheapest method, step and mesh within a tolerance, on this machine.

use clap::Args;
use serde_json::{Value, json};

use super::chart::budget;
use super::explain::cpu;
use super::explained::seconds;
use super::output::{self, significant, table};
use super::progress::share_bar;
use super::{CliError, source};
use crate::chart::plan::{Plan, PlanError, Tolerance, Tried, plan};
use crate::scene::{Override, Scene};

/// Arguments of `toile plan`.
#[derive(Args)]
pub(super) struct PlanArgs {
    /// A built-in scene (see `toile list scenes`), a TOML file, or `-` for standard input.
    scene: String,
    /// Largest error of what the scene observes, at any time, over its largest value: 1% or 0.01.
    #[arg(long, value_name = "T")]
    tolerance: Tolerance,
    /// Replace any key of the scene.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Simulated time in seconds (sets duration).
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    duration: Option<String>,
    /// CPU seconds that the way may cost on this machine; a tolerance that takes more is refused.
    #[arg(long, value_name = "S", default_value = "60", value_parser = budget)]
    budget: f64,
    /// A JSON object instead of the lines.
    #[arg(long)]
    json: bool,
}

impl PlanArgs {
    pub(super) fn run(&self) -> Result<(), CliError> {
        let mut overrides = vec![];
        for set in &self.set {
            overrides.push(Override::parse(set)?);
        }
        if let Some(duration) = &self.duration {
            overrides.push(Override::parse(&format!("duration={duration}"))?);
        }
        let (scene, _) = source::scene(&self.scene, &overrides)?;
        let plan = find(&scene, (self.tolerance, self.budget))?;
        match self.json {
            true => output::print_json(&value(&plan, self.tolerance)),
            false => output::print(&(text(&plan, self.tolerance) + &self.next())),
        }
    }

    /// The command that runs the plan.
    fn next(&self) -> String {
        let mut next = format!("\nnext: toile run {}", self.scene);
        for set in &self.set {
            next += &format!(" --set '{}'", set.replace('\'', r"'\''"));
        }
        if let Some(duration) = &self.duration {
            next += &format!(" --duration {duration}");
        }
        let percent = significant(1e2 * self.tolerance.0, 2);
        next += &format!(" --tolerance {percent}% --budget {}\n", self.budget);
        next
    }
}

/// Makes a plan, with a bar that says what is being tried.
pub(super) fn find(scene: &Scene, within: (Tolerance, f64)) -> Result<Plan, CliError> {
    let bar = share_bar("planning");
    let made = plan(scene, within, &mut cpu, &mut |tried| {
        bar.set_message(tried.to_string());
        bar.tick();
    });
    bar.finish_and_clear();
    made.map_err(failed)
}

pub(super) fn failed(error: PlanError) -> CliError {
    match error {
        PlanError::NothingObserved(_) | PlanError::NoTime(_) => CliError::Input(error.to_string()),
        PlanError::TooFine { .. }
        | PlanError::TooDear { .. }
        | PlanError::TooSensitive { .. }
        | PlanError::Died(_) => CliError::Measure(error.to_string()),
    }
}

fn percent(share: f64) -> String {
    format!("{} %", significant(1e2 * share, 2))
}

fn step(tried: &Tried) -> String {
    seconds(tried.dt)
}

/// The plan in some lines.
fn text(plan: &Plan, tolerance: Tolerance) -> String {
    let chosen = &plan.chosen;
    let [space, time] = plan.errors;
    let falls = plan.order.map_or(String::new(), |order| {
        format!(" (order {} in the edge length)", significant(order, 2))
    });
    let rests = plan.methods.is_empty();
    let step_error = format!(", {} by the step", percent(time));
    let mut text = format!(
        "{} within {tolerance}: {} triangles, {} at {}, {} of CPU time\n  estimated error {} by the mesh{falls}{}\n\n\
         meshes, each {}\n",
        plan.scene.name,
        chosen.triangles,
        chosen.method.name(),
        step(chosen),
        seconds(chosen.cpu),
        percent(space),
        if rests { "" } else { &step_error },
        if rests {
            "at rest, from the shape on the one before"
        } else {
            "with central-difference at its limit"
        },
    );
    let rows = plan.meshes.iter().map(|t| {
        let error = t.error.map_or("not known yet".to_string(), percent);
        vec![
            format!("  {} triangles", t.triangles),
            error,
            seconds(t.cpu),
        ]
    });
    text += &table(&rows.collect::<Vec<_>>());
    if !rests {
        text += "\nmethods, each at the longest step that holds\n";
    }
    let rows = plan.methods.iter().map(|t| {
        let error = match t.error {
            Some(error) if error + space <= tolerance.0 => percent(error),
            Some(error) => format!("{}, too much", percent(error)),
            None => format!("dearer than the best, on {} triangles", t.triangles),
        };
        vec![
            format!("  {}", t.method.name()),
            step(t),
            error,
            seconds(t.cpu),
        ]
    });
    text + &table(&rows.collect::<Vec<_>>())
}

fn value(plan: &Plan, tolerance: Tolerance) -> Value {
    let tried = |t: &Tried| {
        json!({
            "method": t.method.name(),
            "dt": t.dt,
            "triangles": t.triangles,
            "cpu_seconds": t.cpu,
            "work": t.work,
            "error": t.error,
        })
    };
    json!({
        "scene": plan.scene.name,
        "tolerance": tolerance.0,
        "chosen": tried(&plan.chosen),
        "error_space": plan.errors[0],
        "error_time": plan.errors[1],
        "order_space": plan.order,
        "meshes": plan.meshes.iter().map(tried).collect::<Vec<_>>(),
        "methods": plan.methods.iter().map(tried).collect::<Vec<_>>(),
    })
}
