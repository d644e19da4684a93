//! What a scene may ask for and should know the price of.

use std::fmt;

use super::quantity::short;
use super::spec::Scene;

/// A remark on a scene that runs all the same.
#[derive(Clone, Debug, PartialEq)]
pub enum Warning {
    /// The mesh cannot show the folds that the fabric makes.
    CoarseMesh {
        /// Edge length of the mesh \[m\].
        edge: f64,
        /// Bending length of the limper direction \[m\].
        bending_length: f64,
    },
    /// Outputs are a whole number of steps apart, so the wanted rate is not met.
    RoundedRate {
        /// What the scene asks for \[Hz\].
        wanted: f64,
        /// What it gets \[Hz\].
        actual: f64,
    },
    /// The run is a whole number of steps, so it ends elsewhere.
    RoundedDuration {
        /// What the scene asks for \[s\].
        wanted: f64,
        /// What it gets \[s\].
        actual: f64,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Warning::CoarseMesh {
                edge,
                bending_length,
            } => write!(
                f,
                "the mesh's edges of {:.1} mm are longer than the fabric's bending length of {:.1} mm: folds \
                 will be wrong; a quarter of it (--set sheet.edge={:.2e}) resolves them",
                1e3 * edge,
                1e3 * bending_length,
                0.25 * bending_length
            ),
            Warning::RoundedRate { wanted, actual } => write!(
                f,
                "output.rate = {} Hz is not a whole number of steps apart: outputs come at {} Hz",
                short(*wanted),
                short((actual * 1e6).round() / 1e6)
            ),
            Warning::RoundedDuration { wanted, actual } => write!(
                f,
                "duration = {} s is not a whole number of steps: the run ends at {} s",
                short(*wanted),
                short((actual * 1e9).round() / 1e9)
            ),
        }
    }
}

/// Remarks on a checked scene.
pub(super) fn warnings(scene: &Scene) -> Vec<Warning> {
    let mut warnings = vec![];
    let gravity = scene.gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
    if let Ok(fabric) = scene.fabric.resolve() {
        let edge = scene.sheet.edge_length();
        let bending_length = fabric.bending_length(gravity);
        if edge > bending_length {
            warnings.push(Warning::CoarseMesh {
                edge,
                bending_length,
            });
        }
    }
    let differs = |wanted: f64, actual: f64| (actual - wanted).abs() > 1e-6 * wanted;
    let (wanted, actual) = (
        scene.output.rate,
        1.0 / (scene.output_steps() as f64 * scene.method.dt),
    );
    if differs(wanted, actual) {
        warnings.push(Warning::RoundedRate { wanted, actual });
    }
    let (wanted, actual) = (scene.duration, scene.steps() as f64 * scene.method.dt);
    if differs(wanted, actual) {
        warnings.push(Warning::RoundedDuration { wanted, actual });
    }
    warnings
}
