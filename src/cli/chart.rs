//! `toile chart`: runs that end in a chart, resumable, with their data beside it.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use cpu_time::ProcessTime;

use super::progress::share_bar;
use super::{CliError, output, source};
use crate::chart::plot::{Caption, chart};
use crate::chart::png_of_svg;
use crate::chart::reference::Reference;
use crate::chart::rows::{self, Row};
use crate::chart::work_precision::{ChartError, Problem, label};
use crate::node::NodeError;

/// Pixels to the unit of the SVG in the PNG beside it.
const PNG_SCALE: f32 = 1.5;

/// Arguments of `toile chart`.
#[derive(Args)]
pub struct ChartArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// Error against CPU time of every scheme and step, failures included.
    WorkPrecision(WorkPrecisionArgs),
}

#[derive(Args)]
struct WorkPrecisionArgs {
    /// Scenes that have a reference; all of them if none is named.
    scenes: Vec<String>,
    /// Directory of the charts and their CSV; what is in the CSV already is not run again.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

impl ChartArgs {
    /// Runs what is missing, draws, and prints the paths.
    pub fn run(&self) -> Result<(), CliError> {
        match &self.what {
            What::WorkPrecision(args) => args.run(),
        }
    }
}

impl WorkPrecisionArgs {
    fn run(&self) -> Result<(), CliError> {
        let named = match self.scenes.is_empty() {
            true => vec!["strip-release".to_string(), "four-edges".to_string()],
            false => self.scenes.clone(),
        };
        let mut problems = vec![];
        for name in &named {
            let (scene, _) = source::scene(name, &[])?;
            problems.push(Problem::of(scene).map_err(failed)?);
        }
        fs::create_dir_all(&self.output)
            .map_err(NodeError::file("create directory", &self.output))?;
        let csv = self.output.join("work-precision.csv");
        let mut rows = read(&csv, |t| rows::from_csv(t).map_err(|e| e.to_string()))?;
        let rows = rows.get_or_insert_default();
        for problem in &problems {
            let reference = self.reference(problem)?;
            fill(problem, &reference, rows, &csv)?;
            self.draw(problem, &reference, rows)?;
        }
        output::announce(&csv)
    }

    /// The reference of a problem: embedded, kept from an earlier time, or run now.
    fn reference(&self, problem: &Problem) -> Result<Reference, CliError> {
        if let Some(reference) = &problem.reference {
            return Ok(reference.clone());
        }
        let path = self
            .output
            .join(format!("{}-reference.csv", problem.scene.name));
        let kept = read(&path, |t| Reference::from_csv(t).map_err(|e| e.to_string()))?;
        if let Some(reference) = kept {
            return Ok(reference);
        }
        let bar = share_bar(&format!("{} reference", problem.scene.name));
        let made = problem.make_reference(&mut |part| bar.set_position(thousandths(part)));
        bar.finish_and_clear();
        let reference = made.map_err(failed)?;
        fs::write(&path, reference.to_csv()).map_err(NodeError::file("write", &path))?;
        Ok(reference)
    }

    fn draw(&self, problem: &Problem, of: &Reference, rows: &[Row]) -> Result<(), CliError> {
        let svg = chart(&caption(problem, of, rows), rows).map_err(refused)?;
        let stem = format!("work-precision-{}", problem.scene.name);
        let path = self.output.join(format!("{stem}.svg"));
        output::save(&path, &svg)?;
        let path = self.output.join(format!("{stem}.png"));
        let png = png_of_svg(&svg, PNG_SCALE).map_err(refused)?;
        output::save(&path, png)
    }
}

/// Runs every key that has no row yet; the CSV is written after each, so that a stop loses one run at most.
fn fill(
    problem: &Problem,
    reference: &Reference,
    rows: &mut Vec<Row>,
    csv: &Path,
) -> Result<(), CliError> {
    let start = ProcessTime::now();
    let missing = problem.plan().into_iter();
    let missing: Vec<_> = missing
        .filter(|key| !rows.iter().any(|r| r.key == *key))
        .collect();
    for (key, number) in missing.iter().zip(1..) {
        let bar = share_bar(&format!("{} ({number} of {})", label(key), missing.len()));
        let row = problem.run(
            key,
            reference,
            &mut || start.elapsed().as_secs_f64(),
            &mut |part| bar.set_position(thousandths(part)),
        );
        bar.finish_and_clear();
        rows.push(row);
        let fresh = csv.with_extension("csv.part");
        fs::write(&fresh, rows::to_csv(rows)).map_err(NodeError::file("write", &fresh))?;
        fs::rename(&fresh, csv).map_err(NodeError::file("write", csv))?;
    }
    Ok(())
}

fn caption(problem: &Problem, reference: &Reference, rows: &[Row]) -> Caption {
    let scene = &problem.scene;
    let length = problem.error_length(reference);
    let over = match problem.length {
        Some(_) => "length",
        None => "largest displacement",
    };
    let triangles = rows
        .iter()
        .filter(|r| r.key.scene == scene.name)
        .map(|r| r.triangles);
    let last = reference.times.iter().copied().fold(0.0, f64::max);
    Caption {
        scene: scene.name.clone(),
        title: format!("{}: error against step and CPU time", scene.name),
        subtitle: format!(
            "{}, {} triangles, force tolerance {:e} of the weight; largest error over {last} s",
            scene.fabric.name,
            triangles.max().unwrap_or(0),
            scene.method.tolerance,
        ),
        error_over: format!("{over} ({} mm)", (length * 1e5).round() / 1e2),
        uncertainty: reference.uncertainty / length,
        source: reference.source.clone(),
    }
}

/// What a file holds, or nothing if it is not there.
fn read<T>(path: &Path, parse: impl Fn(&str) -> Result<T, String>) -> Result<Option<T>, CliError> {
    let text = match fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(NodeError::file("read", path)(error).into()),
    };
    let refuse = |reason| CliError::Input(format!("{}: {reason}", path.display()));
    parse(&text).map(Some).map_err(refuse)
}

fn thousandths(part: f64) -> u64 {
    (1000.0 * part) as u64
}

fn failed(error: ChartError) -> CliError {
    CliError::Input(error.to_string())
}

fn refused(error: crate::chart::DrawError) -> CliError {
    CliError::Input(error.to_string())
}
