//! `toile info`: what a recording holds.

use std::path::PathBuf;

use clap::Args;
use serde_json::{Value, json};

use super::{CliError, output};
use crate::node::{Inventory, Recording};
use crate::wire::messages::toile_msgs::AppliedCommand;

/// Commands that are listed; `--json` has all.
const MOST_COMMANDS: usize = 20;

/// Arguments of `toile info`.
#[derive(Args)]
pub(super) struct InfoArgs {
    /// The recording: an MCAP file or a bag directory.
    file: PathBuf,
    /// A JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

impl InfoArgs {
    pub(super) fn run(&self) -> Result<(), CliError> {
        let recording = Recording::open(&self.file)?;
        let inventory = Inventory::of(&self.file)?;
        match self.json {
            true => output::print_json(&object(&recording, &inventory)),
            false => output::print(&text(&recording, &inventory)),
        }
    }
}

fn text(recording: &Recording, inventory: &Inventory) -> String {
    let (about, scene) = (recording.about(), recording.scene());
    let times = recording.times();
    let end = match inventory.complete {
        true => "complete".to_string(),
        false => "cut short (`toile recover` completes it)".to_string(),
    };
    let method = scene.method.scheme.name();
    let rows = [
        (
            "scene",
            format!(
                "{}: {} with {method}, dt {} s, {} triangles",
                scene.name,
                scene.fabric.name,
                scene.method.dt,
                output::thousands(recording.faces().len())
            ),
        ),
        (
            "simulated",
            format!(
                "{:.4} of {} s in {} states",
                times.last().unwrap_or(&0.0),
                scene.duration,
                times.len()
            ),
        ),
        (
            "made by",
            format!(
                "toile {} on {}, pace {}",
                about.build, about.processor, about.pace
            ),
        ),
        (
            "file",
            format!(
                "{:.2} MB, {} chunks, {end}",
                inventory.bytes as f64 * 1e-6,
                inventory.chunks
            ),
        ),
    ];
    let rows: Vec<_> = rows
        .into_iter()
        .map(|(name, value)| vec![format!("  {name}"), value])
        .collect();
    format!(
        "{}\n{}\n{}{}",
        recording.path().display(),
        output::table(&rows),
        output::table(&topics(inventory)),
        commands(recording.commands())
    )
}

fn topics(inventory: &Inventory) -> Vec<Vec<String>> {
    let head = [
        "topic",
        "type",
        "messages",
        "first [s]",
        "last [s]",
        "kB each",
    ];
    let mut rows = vec![head.map(str::to_string).to_vec()];
    for topic in &inventory.topics {
        let mut row = vec![
            topic.topic.clone(),
            topic.r#type.clone(),
            topic.count.to_string(),
        ];
        if topic.count > 0 {
            row.push(output::trimmed(topic.first));
            row.push(output::trimmed(topic.last));
            let each = topic.bytes as f64 / topic.count as f64;
            row.push(format!("{:.1}", 1e-3 * each));
        }
        rows.push(row);
    }
    rows
}

fn commands(commands: &[AppliedCommand]) -> String {
    if commands.is_empty() {
        return String::new();
    }
    let head = ["after step", "command", "outcome"];
    let mut rows = vec![head.map(str::to_string).to_vec()];
    for command in commands.iter().take(MOST_COMMANDS) {
        let outcome = match command.accepted {
            true => "applied".to_string(),
            false => format!("rejected: {}", command.reason),
        };
        rows.push(vec![
            command.step.to_string(),
            command.channel.clone(),
            outcome,
        ]);
    }
    let mut text = format!("\n{}", output::table(&rows));
    if let Some(more) = commands.len().checked_sub(MOST_COMMANDS).filter(|n| *n > 0) {
        text += &format!("and {more} more; --json has all\n");
    }
    text
}

fn object(recording: &Recording, inventory: &Inventory) -> Value {
    let scene = recording.scene();
    let commands = recording.commands().iter();
    let commands: Vec<_> = commands
        .map(|c| {
            json!({
                "step": c.step,
                "channel": c.channel,
                "type": c.r#type,
                "accepted": c.accepted,
                "reason": c.reason,
            })
        })
        .collect();
    json!({
        "file": recording.path(),
        "about": recording.about(),
        "scene": scene,
        "triangles": recording.faces().len(),
        "states": recording.times().len(),
        "time": recording.times().last(),
        "last_step": recording.last_step(),
        "inventory": inventory,
        "commands": commands,
    })
}
