//! `toile measure drapemeter --all`: the paper's drape tables against the paper's constants.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::Path;

use indicatif::{ProgressBar, ProgressDrawTarget};

use super::drapes::{DrapeArgs, HoldWord};
use super::{CliError, output, specimen};
use crate::chart::drape::{Row, chart, summary};
use crate::chart::png_of_svg;
use crate::fabric::catalogue;
use crate::instrument::{DrapeSettings, Hold, drapemeter};

/// Drapes whatever the directory does not have yet, then draws table and chart.
pub(super) fn run(dir: &Path, set: &[String], args: &DrapeArgs) -> Result<(), CliError> {
    let failed = |what: &Path, error: std::io::Error| {
        CliError::Output(std::io::Error::new(
            error.kind(),
            format!("{}: {error}", what.display()),
        ))
    };
    fs::create_dir_all(dir).map_err(|error| failed(dir, error))?;
    let path = dir.join("drapemeter.csv");
    let mut rows = match fs::read_to_string(&path) {
        Ok(text) => {
            Row::read(&text).map_err(|e| CliError::Input(format!("{}: {e}", path.display())))?
        }
        Err(_) => {
            fs::write(&path, Row::head()).map_err(|error| failed(&path, error))?;
            vec![]
        }
    };
    let mut table = OpenOptions::new()
        .append(true)
        .open(&path)
        .map_err(|error| failed(&path, error))?;
    let jobs = jobs(args);
    let bar = ProgressBar::with_draw_target(Some(jobs.len() as u64), ProgressDrawTarget::stderr());
    let mut wanted = vec![];
    for (done, (name, settings, seed)) in jobs.iter().enumerate() {
        bar.set_position(done as u64);
        let fabric = specimen::fabric(name, set)?;
        let key = Row::key(&fabric, settings, *seed);
        wanted.push(key.clone());
        if rows.iter().any(|row| row.is(&key)) {
            continue;
        }
        match drapemeter::drape(&fabric, settings, *seed) {
            Ok(drape) => {
                let row = Row::new(key, drape);
                table
                    .write_all(row.line().as_bytes())
                    .map_err(|error| failed(&path, error))?;
                rows.push(row);
            }
            Err(error) => eprintln!("warning: {name}, seed {seed}: {error}"),
        }
    }
    bar.finish_and_clear();
    // The table may hold other sizes and meshes, too.
    rows.retain(|row| wanted.iter().any(|key| row.is(key)));
    let text = summary(&rows);
    output::save(&dir.join("drapemeter-table.md"), &text)?;
    let svg = chart(&rows).map_err(|error| CliError::Input(error.to_string()))?;
    let png = png_of_svg(&svg, 1.0).map_err(|error| CliError::Input(error.to_string()))?;
    output::save(&dir.join("drapemeter.svg"), svg)?;
    output::save(&dir.join("drapemeter.png"), png)?;
    output::print(&text)
}

/// Every drape of the audit; seeds outermost, so that an audit broken off has something on every fabric.
fn jobs(args: &DrapeArgs) -> Vec<(String, DrapeSettings, u64)> {
    let holds = match args.hold {
        Some(HoldWord::Clamped) => vec![Hold::Clamped],
        Some(HoldWord::Resting) => vec![Hold::Resting],
        None => Hold::ALL.to_vec(),
    };
    let mut jobs = vec![];
    for seed in 1..=args.settings().seeds {
        for &hold in &holds {
            for fabric in catalogue() {
                let settings = DrapeSettings {
                    hold,
                    ..args.settings()
                };
                jobs.push((fabric.name, settings, seed));
            }
        }
    }
    jobs
}
