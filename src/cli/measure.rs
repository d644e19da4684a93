//! `toile measure`: a laboratory instrument on a fabric.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde_json::json;

use super::drapes::{self, DrapeArgs};
use super::{CliError, audit, output, specimen};
use crate::chart;
use crate::instrument::{Direction, Instrument, MeasureError, Reading, Report, Settings};

/// Arguments of `toile measure`.
#[derive(Args)]
pub(super) struct MeasureArgs {
    /// The instrument.
    instrument: Word,
    /// Fabric of the catalogue, F1 to F12, or a TOML file with a [fabric] table.
    #[arg(long, value_name = "F", required_unless_present = "all")]
    fabric: Option<String>,
    /// Cut of the specimen; `shear` takes all three.
    #[arg(long, value_name = "CUT", default_value = "warp")]
    direction: Cut,
    /// Replace a constant of the fabric, such as fabric.poisson=symmetrised.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Strain at which stress is read [-].
    #[arg(
        long,
        value_name = "E",
        default_value_t = 0.01,
        allow_negative_numbers = true
    )]
    strain: f64,
    /// Angle of the cantilever below the horizontal [degrees].
    #[arg(
        long,
        value_name = "A",
        default_value_t = 41.5,
        allow_negative_numbers = true
    )]
    angle: f64,
    /// Length of the specimen [m].
    #[arg(long, value_name = "L", allow_negative_numbers = true)]
    length: Option<f64>,
    /// Width of the specimen [m].
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    width: Option<f64>,
    /// Edge length of the mesh [m].
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    edge: Option<f64>,
    /// Meshes to average over.
    #[arg(long, value_name = "N", default_value_t = 3)]
    meshes: u64,
    /// Draws the report as SVG, or as PNG by that ending; with --all, the directory of the audit.
    #[arg(short, long, value_name = "REPORT.svg")]
    output: Option<PathBuf>,
    #[command(flatten)]
    drape: DrapeArgs,
    /// A JSON object instead of the table, SI units throughout.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Word {
    Tensile,
    Poisson,
    Shear,
    Cantilever,
    Drapemeter,
}

#[derive(Clone, Copy, ValueEnum)]
enum Cut {
    Warp,
    Weft,
    Bias,
}

impl MeasureArgs {
    pub(super) fn run(&self) -> Result<(), CliError> {
        if self.drape.all {
            return self.audit();
        }
        let name = self.fabric.as_deref().unwrap_or_default();
        let fabric = specimen::fabric(name, &self.set)?;
        let settings = Settings {
            direction: match self.direction {
                Cut::Warp => Direction::Warp,
                Cut::Weft => Direction::Weft,
                Cut::Bias => Direction::Bias,
            },
            strain: self.strain,
            angle: self.angle,
            length: self.length,
            width: self.width,
            edge: self.edge,
            meshes: self.meshes,
            drape: self.drape.settings(),
            ..Settings::default()
        };
        let instrument = match self.instrument {
            Word::Tensile => Instrument::Tensile,
            Word::Poisson => Instrument::Poisson,
            Word::Shear => Instrument::Shear,
            Word::Cantilever => Instrument::Cantilever,
            Word::Drapemeter => Instrument::Drapemeter,
        };
        let report = instrument.measure(&fabric, &settings).map_err(failed)?;
        for warning in &report.warnings {
            eprintln!("warning: {warning}");
        }
        match self.json {
            true => output::print_json(&json!(report))?,
            false => output::print(&text(&report))?,
        }
        self.output
            .as_deref()
            .map_or(Ok(()), |path| draw(&report, path))
    }

    /// The drapemeter on all fabrics of the catalogue.
    fn audit(&self) -> Result<(), CliError> {
        let input = |said: &str| CliError::Input(said.to_string());
        match (self.instrument, &self.output) {
            (Word::Drapemeter, Some(dir)) if self.fabric.is_none() => {
                audit::run(dir, &self.set, &self.drape)
            }
            (Word::Drapemeter, Some(_)) => {
                Err(input("--all takes every fabric; leave out --fabric"))
            }
            (Word::Drapemeter, None) => Err(input("--all needs -o DIR, where the audit goes")),
            _ => Err(input("--all is for the drapemeter")),
        }
    }
}

fn failed(error: MeasureError) -> CliError {
    match error {
        MeasureError::Diverged(_) | MeasureError::NoOverhang { .. } => {
            CliError::Measure(error.to_string())
        }
        other => CliError::Input(other.to_string()),
    }
}

/// The picture; its path goes to standard error, since the readings have standard output.
fn draw(report: &Report, path: &Path) -> Result<(), CliError> {
    let rows: Vec<[String; 2]> = report
        .readings
        .iter()
        .map(|reading| [reading.name.clone(), cells(reading).join("   ")])
        .chain([["specimen".into(), specimen_line(report)]])
        .chain([["mesh".into(), mesh_line(report)]])
        .collect();
    let svg = chart::report(report, &head(report), &rows)
        .map_err(|error| CliError::Input(error.to_string()))?;
    let as_png = path
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
    let bytes = match as_png {
        true => chart::png_of_svg(&svg, 1.0).map_err(|error| CliError::Input(error.to_string()))?,
        false => svg.into_bytes(),
    };
    output::write(path, bytes)?;
    eprintln!("wrote {}", path.display());
    Ok(())
}

fn head(report: &Report) -> String {
    let name = report.instrument.name();
    match report.instrument {
        Instrument::Shear | Instrument::Drapemeter => format!("{name}: {}", report.fabric),
        _ => format!("{name}: {}, {}", report.fabric, report.direction.name()),
    }
}

fn specimen_line(report: &Report) -> String {
    let [length, width] = report.specimen.map(|size| output::trimmed(1e3 * size));
    if report.instrument == Instrument::Drapemeter {
        return format!("disc of {length} mm on a plate of {width} mm");
    }
    format!("{length} x {width} mm")
}

fn mesh_line(report: &Report) -> String {
    format!(
        "{} triangles, edges of {} mm, {} meshes, residual {:.1e} of the weight",
        output::thousands(report.triangles),
        output::significant(1e3 * report.edge, 3),
        report.meshes,
        report.residual
    )
}

/// The report for a reader.
fn text(report: &Report) -> String {
    let mut rows = vec![
        ["", "reading", "meshes", "edges x 2", "constants", "off"]
            .map(String::from)
            .to_vec(),
    ];
    for reading in &report.readings {
        let name = format!("  {}", reading.name);
        rows.push(std::iter::once(name).chain(cells(reading)).collect());
    }
    format!(
        "{}\n{}{}  specimen {}, {}\n  {}\n",
        head(report),
        output::table(&rows),
        drapes::text(&report.drapes),
        specimen_line(report),
        report.set_up,
        mesh_line(report)
    )
}

/// Value, half the spread over meshes, change from a coarser mesh, expectation and deviation, in units that a textile
/// laboratory reads.
fn cells(reading: &Reading) -> [String; 5] {
    let (factor, unit) = match reading.unit {
        "Pa" => (1e-6, " MPa"),
        "m" => (1e3, " mm"),
        "%" => (1.0, " %"),
        "Hz" => (1.0, " Hz"),
        "J" => (1e3, " mJ"),
        "N·m" => (1e6, " µN·m"),
        "N/m" => (1.0, " N/m"),
        _ => (1.0, ""),
    };
    let show = |value: f64| output::significant(factor * value, 6) + unit;
    // A part of the reading is easier to judge than its unit, and has no long row of noughts.
    let part = |change: f64| match change.abs() < 1e-7 * reading.value.abs() {
        true => "below 1e-7".to_string(),
        false => format!("{:.1e}", change / reading.value.abs().max(1e-300)),
    };
    let off = |part: f64| match part.abs() < 1e-6 {
        true => "below 1e-6".to_string(),
        false => format!("{:+.4} %", 1e2 * part),
    };
    let spread = |whole: f64| format!("± {}", part(0.5 * whole));
    [
        show(reading.value),
        reading.spread.map_or(String::new(), spread),
        reading.mesh_change.map_or(String::new(), part),
        reading.expected.map_or(String::new(), show),
        reading.deviation().map_or(String::new(), off),
    ]
}
