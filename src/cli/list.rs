//! `toile list`: what is built in.

use clap::{Args, ValueEnum};
use serde_json::{Value, json};

use super::{CliError, output};
use crate::fabric::{catalogue, units};
use crate::scene::{Scheme, Solver, library, parse};
use crate::wire::channels;
use crate::wire::inbound::{self, Inlet, InletKind};

/// Arguments of `toile list`.
#[derive(Args)]
pub(super) struct ListArgs {
    /// What to list.
    what: What,
    /// A JSON array instead of a table, SI units throughout.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum What {
    /// Built-in scenes.
    Scenes,
    /// The twelve fabrics of the catalogue.
    Fabrics,
    /// Time schemes, and solvers that take the place of Newton.
    Methods,
    /// Topics and message types of a recording.
    Messages,
    /// Topics and services that commands come in on.
    Commands,
}

/// A row of the table beside the same thing in JSON.
type Entry = (Vec<String>, Value);

impl ListArgs {
    pub(super) fn run(&self) -> Result<(), CliError> {
        let (head, entries) = match self.what {
            What::Scenes => (vec!["scene", "description"], scenes()?),
            What::Fabrics => (FABRIC_HEAD.to_vec(), fabrics()),
            What::Methods => (vec!["method", "description"], methods()),
            What::Commands => (vec!["name", "kind", "type"], commands()),
            What::Messages => (vec!["topic", "type", "rate"], messages()),
        };
        let (rows, values): (Vec<_>, Vec<_>) = entries.into_iter().unzip();
        if self.json {
            return output::print_json(&Value::Array(values));
        }
        let head = head.into_iter().map(str::to_string).collect();
        let rows: Vec<_> = std::iter::once(head).chain(rows).collect();
        output::print(&output::table(&rows))
    }
}

fn scenes() -> Result<Vec<Entry>, CliError> {
    library::names()
        .map(|name| {
            let (scene, _) = parse(library::text(name).unwrap_or_default(), &[])?;
            let value = json!({"name": name, "description": scene.description});
            Ok((vec![name.to_string(), scene.description], value))
        })
        .collect()
}

const FABRIC_HEAD: [&str; 8] = [
    "fabric",
    "g/m²",
    "mm",
    "E_wp MPa",
    "E_wt MPa",
    "H MPa",
    "Rf_wp µN·m",
    "Rf_wt µN·m",
];

/// People read a fabric in the units of its data sheet.
fn fabrics() -> Vec<Entry> {
    let short = |value: f64| format!("{}", (value * 1e4).round() / 1e4);
    catalogue()
        .into_iter()
        .map(|fabric| {
            let cells = [
                fabric.areal_density / units::grams_per_square_metre(1.0),
                fabric.thickness / units::millimetres(1.0),
                fabric.young_warp / units::megapascals(1.0),
                fabric.young_weft / units::megapascals(1.0),
                fabric.shear_modulus / units::megapascals(1.0),
                fabric.rigidity_warp / units::micronewton_metres(1.0),
                fabric.rigidity_weft / units::micronewton_metres(1.0),
            ];
            let name = std::iter::once(fabric.name.clone());
            let row = name.chain(cells.map(short)).collect();
            (row, json!(fabric))
        })
        .collect()
}

fn methods() -> Vec<Entry> {
    let entry = |scheme: Scheme| {
        let (name, description) = (scheme.name(), scheme.description());
        (
            vec![name.to_string(), description.to_string()],
            json!({"name": name, "description": description}),
        )
    };
    let solver = |solver: Solver| {
        let (name, description) = (solver.name(), solver.description());
        (
            vec![name.to_string(), description.to_string()],
            json!({"name": name, "description": description}),
        )
    };
    Scheme::ALL
        .map(entry)
        .into_iter()
        .chain([Solver::QuasiNewton, Solver::Xpbd].map(solver))
        .collect()
}

fn messages() -> Vec<Entry> {
    let entry = |channel: &&'static channels::Channel| {
        let (topic, name) = (channel.topic, channel.message.name);
        let rate = match channel.rate {
            channels::Rate::Once => "once",
            channels::Rate::Output => "output.rate",
            channels::Rate::Mesh => "output.mesh_rate",
            channels::Rate::Event => "on event",
            channels::Rate::Second => "every simulated second",
            channels::Rate::Keyframe => "output.keyframe_interval",
        };
        (
            [topic, name, rate].map(str::to_string).to_vec(),
            json!({"topic": topic, "type": name, "rate": rate, "type_hash": channel.message.hash}),
        )
    };
    channels::ALL.iter().map(entry).collect()
}

fn commands() -> Vec<Entry> {
    let entry = |inlet: &&'static Inlet| {
        let (kind, kind_of_message) = match inlet.kind {
            InletKind::Topic => ("topic", inlet.request.name),
            InletKind::Service => ("service", inlet.service.map_or("", |s| s.name)),
        };
        (
            [inlet.name, kind, kind_of_message]
                .map(str::to_string)
                .to_vec(),
            json!({"name": inlet.name, "kind": kind, "type": kind_of_message}),
        )
    };
    inbound::ALL.iter().map(entry).collect()
}
