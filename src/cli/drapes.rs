//! What `toile measure drapemeter` takes and prints beyond the other instruments.

use clap::{Args, ValueEnum};

use super::output;
use crate::instrument::{Drape, DrapeSettings, Hold};

/// Options of the drapemeter.
#[derive(Args)]
#[command(next_help_heading = "Drapemeter")]
pub(super) struct DrapeArgs {
    /// All fabrics of the catalogue, clamped and resting, beside the paper's tables; goes on where it was broken off.
    #[arg(long)]
    pub all: bool,
    /// How the disc is held [default: clamped; with --all, both].
    #[arg(long, value_name = "H")]
    pub hold: Option<HoldWord>,
    /// Specimen and plate: the paper's 250 over 150 mm, or 240, 300, 360 mm over 180 mm (ISO 9073-9).
    #[arg(long, value_name = "S", default_value = "paper")]
    size: Size,
    /// Diameter of the specimen [m], in place of that of --size.
    #[arg(long, value_name = "D", allow_negative_numbers = true)]
    specimen: Option<f64>,
    /// Diameter of the plate [m], in place of that of --size.
    #[arg(long, value_name = "D", allow_negative_numbers = true)]
    plate: Option<f64>,
    /// Triangles of the mesh.
    #[arg(long, value_name = "N", default_value_t = 5750)]
    triangles: usize,
    /// Starts, each with its own mesh.
    #[arg(long, value_name = "N", default_value_t = 8)]
    seeds: u64,
    /// Friction coefficient of the plate, resting.
    #[arg(
        long,
        value_name = "MU",
        default_value_t = 0.3,
        allow_negative_numbers = true
    )]
    friction: f64,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum HoldWord {
    Clamped,
    Resting,
}

#[derive(Clone, Copy, ValueEnum)]
enum Size {
    Paper,
    #[value(name = "240")]
    Iso240,
    #[value(name = "300")]
    Iso300,
    #[value(name = "360")]
    Iso360,
}

impl DrapeArgs {
    pub(super) fn settings(&self) -> DrapeSettings {
        let (specimen, plate) = match self.size {
            Size::Paper => (0.25, 0.15),
            Size::Iso240 => (0.24, 0.18),
            Size::Iso300 => (0.30, 0.18),
            Size::Iso360 => (0.36, 0.18),
        };
        DrapeSettings {
            hold: match self.hold {
                Some(HoldWord::Resting) => Hold::Resting,
                _ => Hold::Clamped,
            },
            plate: self.plate.unwrap_or(plate),
            specimen: self.specimen.unwrap_or(specimen),
            triangles: self.triangles,
            seeds: self.seeds,
            friction: self.friction,
        }
    }
}

/// The states one by one, and how often each number of folds came; nothing if there are none.
pub(super) fn text(drapes: &[Drape]) -> String {
    if drapes.is_empty() {
        return String::new();
    }
    let heads = [
        "",
        "seed",
        "coefficient",
        "folds",
        "energy",
        "lowest frequency",
        "saddles left",
    ];
    let mut rows = vec![heads.map(String::from).to_vec()];
    for drape in drapes {
        rows.push(vec![
            String::new(),
            format!("  {}", drape.seed),
            format!("{:.2} %", 1e2 * drape.coefficient),
            drape.folds.to_string(),
            format!("{:.5} mJ", 1e3 * drape.energy),
            format!("{:.2} Hz", drape.lowest_frequency),
            drape.saddles.to_string(),
        ]);
    }
    let counts: Vec<String> = histogram(drapes)
        .iter()
        .map(|(folds, count)| format!("{count} with {folds} folds"))
        .collect();
    format!(
        "{}  {}; every state is a minimum of the energy\n",
        output::table(&rows),
        counts.join(", ")
    )
}

/// How many states have how many folds, by rising number of folds.
fn histogram(drapes: &[Drape]) -> Vec<(usize, usize)> {
    let most = drapes.iter().map(|d| d.folds).max().unwrap_or(0);
    let count = |folds: usize| drapes.iter().filter(|d| d.folds == folds).count();
    (0..=most)
        .map(|folds| (folds, count(folds)))
        .filter(|(_, count)| *count > 0)
        .collect()
}
