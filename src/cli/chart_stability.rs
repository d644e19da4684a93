//! `toile chart stability`: every method on a grid of steps, stiffnesses and meshes.

use std::fs;
use std::path::PathBuf;

use clap::Args;

use super::chart::{PNG_SCALE, failed, fill, kept, missing, read, refused};
use super::{CliError, output, source};
use crate::chart::png_of_svg;
use crate::chart::rows;
use crate::chart::stability::cells;
use crate::chart::stability_plot::map;
use crate::node::NodeError;

#[derive(Args)]
pub(super) struct StabilityArgs {
    /// A scene that observes something: a built-in name, a TOML file, or `-`.
    scene: String,
    /// Directory of the chart and its CSV; what is in the CSV already is not run again.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

impl StabilityArgs {
    /// Runs what is missing, draws, and prints the paths.
    pub(super) fn run(&self) -> Result<(), CliError> {
        let (scene, _) = source::scene(&self.scene, &[])?;
        let cells = cells(&scene).map_err(failed)?;
        fs::create_dir_all(&self.output)
            .map_err(NodeError::file("create directory", &self.output))?;
        let stem = format!("stability-{}", scene.name);
        let csv = self.output.join(format!("{stem}.csv"));
        let mut rows =
            read(&csv, |t| rows::from_csv(t).map_err(|e| e.to_string()))?.unwrap_or_default();
        for cell in &cells {
            let missing = missing(cell.plan().into_iter(), &rows);
            if missing.is_empty() {
                continue;
            }
            let truth = format!("{stem}-{}-{}-truth.csv", cell.triangles, cell.stiffness);
            let truth = kept(&self.output.join(truth), |watch| cell.truth(watch))?;
            fill(&missing, &mut rows, &csv, &mut |key, cpu, watch| {
                cell.run(key, &truth, cpu, watch)
            })?;
        }
        let title = format!("{}: where each method is right, wrong, lost", scene.name);
        let svg = map(&title, &cells, &rows).map_err(refused)?;
        output::save(&self.output.join(format!("{stem}.svg")), &svg)?;
        let png = png_of_svg(&svg, PNG_SCALE).map_err(refused)?;
        output::save(&self.output.join(format!("{stem}.png")), png)?;
        output::announce(&csv)
    }
}
