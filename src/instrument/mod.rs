//! The laboratory: each instrument builds a specimen as a scene, brings it to rest, and reads it.
//!
//! Every number comes as the mean over several unstructured meshes with its spread, beside what the fabric's
//! constants say by closed form and, where the mesh matters, its change against a coarser one, and with the residual at which the state was taken for one of rest.

mod cantilever;
pub mod drapemeter;
mod error;
mod poisson;
mod report;
mod shear;
mod specimen;
mod strip;
mod tensile;

use serde::Serialize;

use crate::fabric::identify::STANDARD_ANGLE;
use crate::scene::FabricSpec;

pub use drapemeter::{Drape, DrapeSettings, Hold};
pub use error::MeasureError;
pub use report::{Curve, Diagram, Mark, Reading, Report};

/// A laboratory instrument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Instrument {
    /// Stress of a strip at a strain, and its modulus.
    Tensile,
    /// Contraction over extension of a strip.
    Poisson,
    /// Shear modulus from three tensions by (18).
    Shear,
    /// Overhang, bending length and flexural rigidity.
    Cantilever,
    /// Drape coefficient and folds of a disc over a plate.
    Drapemeter,
}

impl Instrument {
    /// All of them.
    pub const ALL: [Instrument; 5] = [
        Instrument::Tensile,
        Instrument::Poisson,
        Instrument::Shear,
        Instrument::Cantilever,
        Instrument::Drapemeter,
    ];

    /// The word on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Instrument::Tensile => "tensile",
            Instrument::Poisson => "poisson",
            Instrument::Shear => "shear",
            Instrument::Cantilever => "cantilever",
            Instrument::Drapemeter => "drapemeter",
        }
    }

    /// Puts a specimen into the instrument and reads it.
    ///
    /// # Errors
    /// A setting is out of range, the specimen does not fit the instrument, or no state of rest was found.
    pub fn measure(self, fabric: &FabricSpec, settings: &Settings) -> Result<Report, MeasureError> {
        settings.check()?;
        match self {
            Instrument::Tensile => tensile::measure(fabric, settings),
            Instrument::Poisson => poisson::measure(fabric, settings),
            Instrument::Shear => shear::measure(fabric, settings),
            Instrument::Cantilever => cantilever::measure(fabric, settings),
            Instrument::Drapemeter => drapemeter::measure(fabric, settings),
        }
    }
}

/// How the specimen is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// Its length along the warp.
    Warp,
    /// Along the weft.
    Weft,
    /// At 45 degrees to both.
    Bias,
}

impl Direction {
    /// The word on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Direction::Warp => "warp",
            Direction::Weft => "weft",
            Direction::Bias => "bias",
        }
    }

    /// From the specimen's length to the warp \[degrees\].
    fn warp_angle(self) -> f64 {
        match self {
            Direction::Warp => 0.0,
            Direction::Weft => 90.0,
            Direction::Bias => 45.0,
        }
    }
}

/// What is measured and how finely; sizes left out are those that suit the fabric.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Settings {
    /// Cut of the specimen; `shear` needs all three and ignores it.
    pub direction: Direction,
    /// Strain of the tensile reading \[-\].
    pub strain: f64,
    /// Angle of the cantilever from the horizontal \[degrees\].
    pub angle: f64,
    /// Gravity \[m/s²\].
    pub gravity: f64,
    /// Length of the specimen \[m\]: of a tensile strip between its jaws, 200 mm; the most that a cantilever has.
    pub length: Option<f64>,
    /// Width of the specimen \[m\].
    pub width: Option<f64>,
    /// Edge length of the mesh \[m\].
    pub edge: Option<f64>,
    /// Meshes over which readings are averaged.
    pub meshes: u64,
    /// For the drapemeter, which ignores the rest.
    pub drape: DrapeSettings,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            direction: Direction::Warp,
            strain: 0.01,
            angle: STANDARD_ANGLE,
            gravity: 9.81,
            length: None,
            width: None,
            edge: None,
            meshes: 3,
            drape: DrapeSettings::default(),
        }
    }
}
