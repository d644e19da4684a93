//! `toile chart waterfall`: what each economy saves.

use std::fs;
use std::path::PathBuf;

use clap::Args;

use super::chart::{PNG_SCALE, budget, refused};
use super::explain::cpu;
use super::plan::failed;
use super::progress::share_bar;
use super::{CliError, output, source};
use crate::chart::plan::Tolerance;
use crate::chart::png_of_svg;
use crate::chart::waterfall::{to_csv, waterfall};
use crate::chart::waterfall_plot::falls;
use crate::node::NodeError;
use crate::scene::Override;

#[derive(Args)]
pub(super) struct WaterfallArgs {
    /// A scene that observes something: a built-in name, a TOML file, or `-`.
    scene: String,
    /// Largest error of what the scene observes, at any time, over its largest value: 1% or 0.01.
    #[arg(long, value_name = "T", default_value = "5%")]
    tolerance: Tolerance,
    /// CPU seconds that a way may cost; a dearer one is left, and its cost is that of the time it came to.
    #[arg(long, value_name = "S", default_value = "60", value_parser = budget)]
    budget: f64,
    /// Replace any key of the scene.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Directory of the chart and its CSV.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

impl WaterfallArgs {
    /// Runs every way, draws, and prints the paths.
    pub(super) fn run(&self) -> Result<(), CliError> {
        let overrides: Result<Vec<_>, _> = self.set.iter().map(|s| Override::parse(s)).collect();
        let (scene, _) = source::scene(&self.scene, &overrides?)?;
        fs::create_dir_all(&self.output)
            .map_err(NodeError::file("create directory", &self.output))?;
        let bar = share_bar("waterfall");
        let within = (self.tolerance, self.budget);
        let bars = waterfall(&scene, within, &mut cpu, &mut |way| {
            bar.set_message(way.to_string());
            bar.tick();
        });
        bar.finish_and_clear();
        let bars = bars.map_err(failed)?;
        let title = format!("{}: what each economy saves", scene.name);
        let subtitle = format!(
            "{}, {} s, within {}; 1/2 means half the cost of the line above",
            scene.fabric.name, scene.duration, self.tolerance
        );
        let svg = falls(&title, &subtitle, &bars).map_err(refused)?;
        let stem = format!("waterfall-{}", scene.name);
        let csv = self.output.join(format!("{stem}.csv"));
        output::save(&csv, to_csv(&bars))?;
        output::save(&self.output.join(format!("{stem}.svg")), &svg)?;
        let png = png_of_svg(&svg, PNG_SCALE).map_err(refused)?;
        output::save(&self.output.join(format!("{stem}.png")), png)
    }
}
