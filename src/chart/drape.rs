//! The audit of the paper's drape tables: rows of single drapes as CSV, their means as a table, both as a chart.

use crate::instrument::drapemeter::paper::{INCONSISTENT, PUBLISHED, Published};
use crate::instrument::{Drape, DrapeSettings, Hold};
use crate::scene::FabricSpec;

pub use super::drape_plot::chart;

/// What was draped: two drapes with one key are the same.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Fabric, with the constants that differ from the catalogue.
    pub fabric: String,
    /// How the disc was held.
    pub hold: Hold,
    /// Specimen, plate \[mm\], triangles asked for, friction, seed: as written.
    pub rest: String,
}

/// One drape.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What was draped.
    pub key: Key,
    /// What came of it.
    pub drape: Drape,
}

const HEAD: &str = "fabric,hold,specimen_mm,plate_mm,triangles_asked,friction,seed,triangles,coefficient_pct,\
                    coefficient_rays_pct,folds,fold_length_mm,fold_width_mm,fold_depth_mm,energy_uJ,\
                    lowest_frequency_Hz,residual,saddles,flow_steps,largest_strain\n";

impl Row {
    /// The first line of a table.
    pub fn head() -> &'static str {
        HEAD
    }

    /// The key of a drape to come.
    pub fn key(fabric: &FabricSpec, set: &DrapeSettings, seed: u64) -> Key {
        let twist = match fabric.twist {
            crate::fabric::TwistRigidity::Geometric => "",
            crate::fabric::TwistRigidity::None => " twist none",
        };
        let friction = match set.hold {
            Hold::Clamped => 0.0,
            Hold::Resting => set.friction,
        };
        Key {
            fabric: format!("{}{twist}", fabric.name),
            hold: set.hold,
            rest: format!(
                "{},{},{},{friction},{seed}",
                1e-3 * (1e6 * set.specimen).round(),
                1e-3 * (1e6 * set.plate).round(),
                set.triangles
            ),
        }
    }

    /// A drape with its key.
    pub fn new(key: Key, drape: Drape) -> Self {
        Self { key, drape }
    }

    /// Whether this is the drape of a key.
    pub fn is(&self, key: &Key) -> bool {
        self.key == *key
    }

    /// The row as a line of the table.
    pub fn line(&self) -> String {
        let (key, d) = (&self.key, &self.drape);
        format!(
            "{},{},{},{},{:.4},{:.4},{},{:.3},{:.3},{:.3},{:.6},{:.4},{:.2e},{},{},{:.2e}\n",
            key.fabric,
            key.hold.name(),
            key.rest,
            d.triangles,
            1e2 * d.coefficient,
            1e2 * d.coefficient_rays,
            d.folds,
            1e3 * d.fold_length,
            1e3 * d.fold_width,
            1e3 * d.fold_depth,
            1e6 * d.energy,
            d.lowest_frequency,
            d.residual,
            d.saddles,
            d.flow_steps,
            d.largest_strain
        )
    }

    /// Reads a table back.
    ///
    /// # Errors
    /// Another head, or a line that is none of ours, by its number.
    pub fn read(text: &str) -> Result<Vec<Self>, String> {
        let Some(body) = text.strip_prefix(HEAD) else {
            return Err("not the head of a drape table".to_string());
        };
        let line = |(k, line): (usize, &str)| {
            parse(line).ok_or_else(|| format!("line {}: not a drape", k + 2))
        };
        body.lines().enumerate().map(line).collect()
    }
}

fn parse(line: &str) -> Option<Row> {
    let cells: Vec<&str> = line.split(',').collect();
    let number = |k: usize| cells.get(k)?.parse::<f64>().ok();
    let count = |k: usize| cells.get(k)?.parse::<u64>().ok();
    if cells.len() != HEAD.split(',').count() {
        return None;
    }
    Some(Row {
        key: Key {
            fabric: cells[0].to_string(),
            hold: Hold::ALL.into_iter().find(|h| h.name() == cells[1])?,
            rest: cells[2..7].join(","),
        },
        drape: Drape {
            seed: count(6)?,
            triangles: count(7)? as usize,
            coefficient: 1e-2 * number(8)?,
            coefficient_rays: 1e-2 * number(9)?,
            folds: count(10)? as usize,
            fold_length: 1e-3 * number(11)?,
            fold_width: 1e-3 * number(12)?,
            fold_depth: 1e-3 * number(13)?,
            energy: 1e-6 * number(14)?,
            lowest_frequency: number(15)?,
            residual: number(16)?,
            saddles: count(17)?,
            flow_steps: count(18)?,
            largest_strain: number(19)?,
            outline: vec![],
        },
    })
}

/// Mean and range of the drape coefficient \[%\] of one fabric, held one way, over all its rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Mean.
    pub mean: f64,
    /// Smallest and largest.
    pub range: (f64, f64),
    /// Mean number of folds.
    pub folds: f64,
    /// How many drapes.
    pub count: usize,
}

/// The cell of a fabric; none if it was not draped.
pub fn cell(rows: &[Row], fabric: &str, hold: Hold) -> Option<Cell> {
    let mine = |row: &&Row| row.key.fabric == fabric && row.key.hold == hold;
    let drapes: Vec<&Drape> = rows.iter().filter(mine).map(|row| &row.drape).collect();
    let count = drapes.len();
    let mean =
        |of: &dyn Fn(&Drape) -> f64| drapes.iter().map(|d| of(d)).sum::<f64>() / count as f64;
    let all = drapes.iter().map(|d| 1e2 * d.coefficient);
    let range = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| {
        (low.min(c), high.max(c))
    });
    (count > 0).then(|| Cell {
        mean: mean(&|d| 1e2 * d.coefficient),
        range,
        folds: mean(&|d| d.folds as f64),
        count,
    })
}

/// Pearson's correlation of our means with the measured coefficients, over all fabrics and without those that
/// contradict their own constants; none where there are fewer than three.
pub fn correlations(rows: &[Row], hold: Hold) -> [Option<f64>; 2] {
    let pairs = |skip: &[&str]| -> Vec<[f64; 2]> {
        let kept = PUBLISHED.iter().filter(|p| !skip.contains(&p.fabric));
        kept.filter_map(|p| Some([p.measured.0, cell(rows, p.fabric, hold)?.mean]))
            .collect()
    };
    [pairs(&[]), pairs(&INCONSISTENT)].map(|pairs| pearson(&pairs))
}

fn pearson(pairs: &[[f64; 2]]) -> Option<f64> {
    let count = pairs.len() as f64;
    let mean = [0, 1].map(|k| pairs.iter().map(|p| p[k]).sum::<f64>() / count);
    let moment = |i: usize, j: usize| -> f64 {
        pairs
            .iter()
            .map(|p| (p[i] - mean[i]) * (p[j] - mean[j]))
            .sum()
    };
    (pairs.len() >= 3).then(|| moment(0, 1) / (moment(0, 0) * moment(1, 1)).sqrt())
}

/// Measured, printed and ours, fabric by fabric, as a Markdown table.
pub fn summary(rows: &[Row]) -> String {
    let mut text = "Drape coefficient in %, number of folds in brackets. Ours: mean and range over the drapes.\n\n\
                    | fabric | measured (Table 3) | simulated (Table 4) | ours, clamped | ours, resting |\n\
                    |---|---|---|---|---|\n"
        .to_string();
    for Published {
        fabric,
        measured,
        simulated,
    } in &PUBLISHED
    {
        let ours = Hold::ALL.map(|hold| match cell(rows, fabric, hold) {
            Some(c) => format!(
                "{:.1}, {:.1} to {:.1} ({:.1}), {} drapes",
                c.mean, c.range.0, c.range.1, c.folds, c.count
            ),
            None => "-".to_string(),
        });
        let mark = if INCONSISTENT.contains(fabric) {
            "*"
        } else {
            ""
        };
        text += &format!(
            "| {fabric}{mark} | {} ({}) | {} ({}) | {} | {} |\n",
            measured.0, measured.1, simulated.0, simulated.1, ours[0], ours[1]
        );
    }
    text += "\n`*` the measured drape contradicts the paper's own constants (Table 2).\n";
    for hold in Hold::ALL {
        if let [Some(all), Some(kept)] = correlations(rows, hold) {
            text += &format!(
                "Correlation with the measured coefficients, {}: {all:.3} over all, {kept:.3} without {}.\n",
                hold.name(),
                INCONSISTENT.join(", ")
            );
        }
    }
    text
}
