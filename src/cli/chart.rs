//! `toile chart`: runs that end in a chart, resumable, with their data beside it.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use cpu_time::ProcessTime;

use super::chart_stability::StabilityArgs;
use super::chart_waterfall::WaterfallArgs;
use super::progress::share_bar;
use super::{CliError, output, source};
use crate::chart::peers::Peer;
use crate::chart::plot::{Caption, chart};
use crate::chart::png_of_svg;
use crate::chart::problems::CHARTED;
use crate::chart::reference::Reference;
use crate::chart::rows::{self, Key, Row};
use crate::chart::work_precision::{ChartError, Problem, label};
use crate::chart::{CpuClock, Watch};
use crate::node::NodeError;

/// Pixels to the unit of the SVG in the PNG beside it.
pub(super) const PNG_SCALE: f32 = 1.5;

/// Arguments of `toile chart`.
#[derive(Args)]
pub struct ChartArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// Error against CPU time of every method, step and mesh, failures included.
    WorkPrecision(WorkPrecisionArgs),
    /// Where every method converges, goes wrong, is lost: step, stiffness, mesh.
    Stability(StabilityArgs),
    /// What each economy saves within a tolerance: solver, scheme, mesh, sleep.
    Waterfall(WaterfallArgs),
}

#[derive(Args)]
struct WorkPrecisionArgs {
    /// Scenes that observe something; strip-release, four-edges, drapemeter, fling and drape-table if none is
    /// named.
    scenes: Vec<String>,
    /// Directory of the charts and their CSV; what is in the CSV already is not run again.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// CPU seconds that a run may cost; a dearer one is left, drawn where it was, and not taken up again unless its row
    /// is deleted. References have no limit.
    #[arg(long, value_name = "S", default_value = "60", value_parser = budget)]
    budget: f64,
}

/// CPU seconds, more than none.
pub(super) fn budget(text: &str) -> Result<f64, String> {
    let seconds = text.parse::<f64>().ok().filter(|s| *s > 0.0);
    seconds.ok_or_else(|| "must be CPU seconds, more than 0".to_string())
}

impl ChartArgs {
    /// Runs what is missing, draws, and prints the paths.
    pub fn run(&self) -> Result<(), CliError> {
        match &self.what {
            What::WorkPrecision(args) => args.run(),
            What::Stability(args) => args.run(),
            What::Waterfall(args) => args.run(),
        }
    }
}

impl WorkPrecisionArgs {
    fn run(&self) -> Result<(), CliError> {
        let named = match self.scenes.is_empty() {
            true => CHARTED.map(str::to_string).to_vec(),
            false => self.scenes.clone(),
        };
        let mut problems = vec![];
        for name in &named {
            let (scene, _) = source::scene(name, &[])?;
            for mut problem in Problem::all_of(scene).map_err(failed)? {
                problem.budget = self.budget;
                problems.push(problem);
            }
        }
        fs::create_dir_all(&self.output)
            .map_err(NodeError::file("create directory", &self.output))?;
        let csv = self.output.join("work-precision.csv");
        let mut rows = read(&csv, |t| rows::from_csv(t).map_err(|e| e.to_string()))?;
        let rows = rows.get_or_insert_default();
        for problem in &problems {
            let reference = self.reference(problem)?;
            self.fill(problem, &reference, rows, &csv)?;
            self.draw(problem, &reference, rows)?;
        }
        output::announce(&csv)
    }

    /// The reference of a problem: embedded, kept from an earlier time, or run now.
    fn reference(&self, problem: &Problem) -> Result<Reference, CliError> {
        match &problem.reference {
            Some(reference) => Ok(reference.clone()),
            None => {
                let path = format!("{}-reference.csv", problem.name);
                kept(&self.output.join(path), |watch| {
                    problem.make_reference(watch)
                })
            }
        }
    }

    /// Runs every key that has no row yet, each mesh against its own truth, too.
    fn fill(
        &self,
        problem: &Problem,
        reference: &Reference,
        rows: &mut Vec<Row>,
        csv: &Path,
    ) -> Result<(), CliError> {
        for triangles in &problem.meshes {
            let mesh = format!("triangles={triangles}");
            let mine = problem.plan().into_iter().filter(|key| key.mesh == mesh);
            let missing = missing(mine, rows);
            if missing.is_empty() {
                continue;
            }
            let path = format!("{}-{triangles}-truth.csv", problem.name);
            let path = self.output.join(path);
            let own = kept(&path, |watch| problem.truth_on(*triangles, watch))?;
            fill(&missing, rows, csv, &mut |key, cpu, watch| {
                problem.run(key, (reference, Some(&own)), cpu, watch)
            })?;
        }
        Ok(())
    }

    fn draw(&self, problem: &Problem, of: &Reference, rows: &[Row]) -> Result<(), CliError> {
        let svg = chart(&caption(problem, of, rows), rows).map_err(refused)?;
        let stem = format!("work-precision-{}", problem.name);
        let path = self.output.join(format!("{stem}.svg"));
        output::save(&path, &svg)?;
        let path = self.output.join(format!("{stem}.png"));
        let png = png_of_svg(&svg, PNG_SCALE).map_err(refused)?;
        output::save(&path, png)
    }
}

/// A reference kept in a file, or made now and kept there.
pub(super) fn kept(
    path: &Path,
    make: impl FnOnce(&mut Watch) -> Result<Reference, ChartError>,
) -> Result<Reference, CliError> {
    let found = read(path, |t| Reference::from_csv(t).map_err(|e| e.to_string()))?;
    if let Some(reference) = found {
        return Ok(reference);
    }
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let bar = share_bar(&name);
    let made = make(&mut |part| bar.set_position(thousandths(part)));
    bar.finish_and_clear();
    let reference = made.map_err(failed)?;
    fs::write(path, reference.to_csv()).map_err(NodeError::file("write", path))?;
    Ok(reference)
}

/// Keys without a row.
pub(super) fn missing(keys: impl Iterator<Item = Key>, rows: &[Row]) -> Vec<Key> {
    keys.filter(|key| !rows.iter().any(|r| r.key == *key))
        .collect()
}

/// What makes a row of a key, given a CPU clock and whom to tell how far it is.
pub(super) type MakeRow<'a> = dyn FnMut(&Key, &mut CpuClock, &mut Watch) -> Row + 'a;

/// Runs keys; the CSV is written after each, so that a stop loses one run at most.
pub(super) fn fill(
    keys: &[Key],
    rows: &mut Vec<Row>,
    csv: &Path,
    make: &mut MakeRow,
) -> Result<(), CliError> {
    let start = ProcessTime::now();
    for (key, number) in keys.iter().zip(1..) {
        let bar = share_bar(&format!("{} ({number} of {})", label(key), keys.len()));
        let row = make(key, &mut || start.elapsed().as_secs_f64(), &mut |part| {
            bar.set_position(thousandths(part))
        });
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
        .filter(|r| r.key.scene == problem.name)
        .map(|r| r.triangles);
    let mut triangles: Vec<usize> = triangles.collect();
    triangles.sort_unstable();
    triangles.dedup();
    let triangles: Vec<String> = triangles.iter().map(ToString::to_string).collect();
    let last = reference.times.iter().copied().fold(0.0, f64::max);
    Caption {
        scene: problem.name.clone(),
        title: format!("{}: error against step and CPU time", problem.name),
        subtitle: format!(
            "{}, {} triangles, force tolerance {:e} of the weight; largest error over {last} s",
            scene.fabric.name,
            triangles.join(" and "),
            scene.method.tolerance,
        ),
        error_over: format!("{over} ({} mm)", (length * 1e5).round() / 1e2),
        uncertainty: reference.uncertainty / length,
        source: reference.source.clone(),
        peers: Peer::on(&scene.name)
            .iter()
            .map(|peer| {
                let label = format!("{} {} ms, {}", peer.name, 1e3 * peer.dt, peer.triangles);
                (label, peer.cpu_rate, peer.distance(reference) / length)
            })
            .collect(),
    }
}

/// What a file holds, or nothing if it is not there.
pub(super) fn read<T>(
    path: &Path,
    parse: impl Fn(&str) -> Result<T, String>,
) -> Result<Option<T>, CliError> {
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

pub(super) fn failed(error: ChartError) -> CliError {
    CliError::Input(error.to_string())
}

pub(super) fn refused(error: crate::chart::DrawError) -> CliError {
    CliError::Input(error.to_string())
}
