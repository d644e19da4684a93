//! What an instrument says: readings with their spread, and the diagram of the test.

use serde::Serialize;

use super::{Direction, Drape, Instrument};

/// A reading: the mean over several meshes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reading {
    /// What it is.
    pub name: String,
    /// Its unit, SI.
    pub unit: &'static str,
    /// Mean over the meshes.
    pub value: f64,
    /// Largest less smallest over the meshes; a single one says nothing of it.
    pub spread: Option<f64>,
    /// Change against a mesh with edges twice as long, where the mesh matters: what is left of its error is less.
    pub mesh_change: Option<f64>,
    /// What the fabric's constants say by closed form, where there is one.
    pub expected: Option<f64>,
}

impl Reading {
    /// The mean of one value a mesh.
    pub(super) fn new(
        name: &str,
        unit: &'static str,
        values: &[f64],
        expected: Option<f64>,
    ) -> Self {
        let range = values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(*v), high.max(*v))
            });
        Self {
            name: name.to_string(),
            unit,
            value: values.iter().sum::<f64>() / values.len() as f64,
            spread: (values.len() > 1).then_some(range.1 - range.0),
            mesh_change: None,
            expected,
        }
    }

    /// With what a mesh of edges twice as long reads instead.
    pub(super) fn against(self, coarse: f64) -> Self {
        Self {
            mesh_change: Some(self.value - coarse),
            ..self
        }
    }

    /// Value over expectation, less one; none without an expectation, or if that is zero.
    pub fn deviation(&self) -> Option<f64> {
        let expected = self.expected.filter(|e| *e != 0.0)?;
        Some(self.value / expected - 1.0)
    }
}

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mark {
    /// A dot for each point.
    Dots,
    /// A line through the points.
    Line,
    /// A broken line through the points.
    Dashes,
}

/// Points of a diagram.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Curve {
    /// For the legend.
    pub name: String,
    /// How it is drawn.
    pub mark: Mark,
    /// x and y in the units of the axes.
    pub points: Vec<[f64; 2]>,
}

/// What the test looked like.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Diagram {
    /// Label of the horizontal axis, with its unit.
    pub x: &'static str,
    /// Of the vertical one.
    pub y: &'static str,
    /// Both axes are lengths and have one scale.
    pub shape: bool,
    /// What is drawn.
    pub curves: Vec<Curve>,
}

/// The outcome of a measurement.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// The instrument.
    pub instrument: Instrument,
    /// The fabric's name.
    pub fabric: String,
    /// Cut of the specimen.
    pub direction: Direction,
    /// Length and width of the specimen \[m\].
    pub specimen: [f64; 2],
    /// How the specimen was held and read.
    pub set_up: String,
    /// Edge length of the meshes \[m\].
    pub edge: f64,
    /// Triangles of the first mesh.
    pub triangles: usize,
    /// Meshes averaged over.
    pub meshes: u64,
    /// Largest sum of residual forces over the specimen's weight, over all states read \[-\].
    pub residual: f64,
    /// The readings.
    pub readings: Vec<Reading>,
    /// Remarks on what limits them.
    pub warnings: Vec<String>,
    /// States of the drapemeter, one a seed.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub drapes: Vec<Drape>,
    /// For the picture.
    pub diagram: Diagram,
}

impl Report {
    /// A reading by name.
    pub fn reading(&self, name: &str) -> Option<&Reading> {
        self.readings.iter().find(|reading| reading.name == name)
    }
}
