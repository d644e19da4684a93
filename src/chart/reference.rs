//! What a run is compared with: where a point of the sheet has moved to, at given times.

use nalgebra::Vector3;

/// Displacement of the observed point from an independent method.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Times \[s\], rising.
    pub times: Vec<f64>,
    /// Displacement at each time \[m\].
    pub displacements: Vec<Vector3<f64>>,
    /// How far off the reference itself may be \[m\].
    pub uncertainty: f64,
    /// Where it comes from, for the chart.
    pub source: String,
}

/// A reference that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("reference, line {line}: `{text}` is not a row of numbers")]
pub struct ReferenceError {
    /// Line of the file, from 1.
    line: usize,
    /// What stands there.
    text: String,
}

/// Tip of the released strip by rigid links and DOP853 (tests/references/README.md).
const STRIP: &str = include_str!("../../tests/references/strip_release_F1warp_L100_mu0.0.csv");

impl Reference {
    /// Largest displacement \[m\].
    pub fn largest(&self) -> f64 {
        self.displacements
            .iter()
            .map(|d| d.norm())
            .fold(0.0, f64::max)
    }

    /// Largest distance from another course at the same times \[m\].
    pub fn largest_distance(&self, other: &Self) -> f64 {
        let pairs = self.displacements.iter().zip(&other.displacements);
        pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    }

    /// The released strip's tip; 100 mm long, clamped at the origin, let go along x.
    pub fn strip_release() -> Result<Self, ReferenceError> {
        let rows = numbers(STRIP, 5)?;
        let moved = |r: &Vec<f64>| Vector3::new(r[1] - 0.1, 0.0, r[2]);
        Ok(Self {
            times: rows.iter().map(|r| r[0]).collect(),
            displacements: rows.iter().map(moved).collect(),
            uncertainty: rows.iter().map(|r| r[3].hypot(r[4])).fold(0.0, f64::max),
            source: "independent chain of 200 links, DOP853".to_string(),
        })
    }

    /// As CSV, to be kept beside the chart: a reference may be dear.
    pub fn to_csv(&self) -> String {
        let mut text = format!(
            "# {}\n# uncertainty_m {:e}\n",
            self.source, self.uncertainty
        );
        text += "t_s,x_m,y_m,z_m\n";
        for (t, d) in self.times.iter().zip(&self.displacements) {
            text += &format!("{t},{:e},{:e},{:e}\n", d.x, d.y, d.z);
        }
        text
    }

    /// Reads what [`Reference::to_csv`] wrote.
    pub fn from_csv(text: &str) -> Result<Self, ReferenceError> {
        let comment = |k: usize| {
            text.lines()
                .nth(k)
                .unwrap_or_default()
                .trim_start_matches("# ")
        };
        let refuse = || ReferenceError {
            line: 2,
            text: comment(1).to_string(),
        };
        let uncertainty = comment(1)
            .strip_prefix("uncertainty_m ")
            .and_then(|t| t.parse().ok());
        let rows = numbers(text, 4)?;
        Ok(Self {
            times: rows.iter().map(|r| r[0]).collect(),
            displacements: rows
                .iter()
                .map(|r| Vector3::new(r[1], r[2], r[3]))
                .collect(),
            uncertainty: uncertainty.ok_or_else(refuse)?,
            source: comment(0).to_string(),
        })
    }
}

/// Rows of at least `columns` numbers after comments and one header line.
fn numbers(text: &str, columns: usize) -> Result<Vec<Vec<f64>>, ReferenceError> {
    let body = text
        .lines()
        .zip(1..)
        .filter(|(l, _)| !l.starts_with('#') && !l.is_empty())
        .skip(1);
    body.map(|(line, number)| {
        let values: Result<Vec<f64>, _> = line.split(',').map(|v| v.trim().parse()).collect();
        match values {
            Ok(values) if values.len() >= columns => Ok(values),
            _ => Err(ReferenceError {
                line: number,
                text: line.to_string(),
            }),
        }
    })
    .collect()
}
