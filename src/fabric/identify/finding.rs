//! What is wrong with a set of tests: unusable values, and values that do not fit each other.

use std::fmt;

use serde::Serialize;

use super::bending::{BendingRule, STANDARD_ANGLE};
use super::{Cantilever, Shear, Tests};

/// Tests from which no fabric follows.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unusable {
    /// A value out of its range.
    #[error("{field} = {value}: must be {allowed}")]
    Value {
        /// Key of the document.
        field: &'static str,
        /// What it holds, SI.
        value: f64,
        /// What it may hold.
        allowed: String,
    },
    /// Neither of two keys is there.
    #[error("give {one} or {other}; neither is there")]
    Missing {
        /// A key.
        one: &'static str,
        /// The other.
        other: &'static str,
    },
    /// Both of two keys are there.
    #[error("give one of {one} and {other}, not both")]
    Twice {
        /// A key.
        one: &'static str,
        /// The other.
        other: &'static str,
    },
}

impl Unusable {
    pub(super) fn new(field: &'static str, value: f64, allowed: String) -> Self {
        Self::Value {
            field,
            value,
            allowed,
        }
    }
}

/// Tests that do not fit each other; the fabric is made all the same.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Finding {
    /// nu_warp/E_warp and nu_weft/E_weft, which reciprocity makes equal, differ by more than 5 %.
    Reciprocity {
        /// The first over the second \[-\].
        ratio: f64,
    },
    /// The ratios leave no positive definite membrane, or no positive shear modulus: they are left out.
    NotPositiveDefinite {
        /// Under warp and weft tension \[-\].
        poisson: [f64; 2],
    },
    /// (18) as printed and in tensor form differ by more than 1 %.
    ShearFormulas {
        /// As printed \[Pa\].
        printed: f64,
        /// Each ratio with its own modulus \[Pa\].
        consistent: f64,
    },
    /// Peirce's formula differs from the exact elastica by more than 1 %.
    Peirce {
        /// Rigidity by (19)-(20) over the exact one \[-\].
        ratio: f64,
    },
    /// Half the overhang is meant for 41.5 degrees.
    HalfAngle {
        /// The angle of the tests \[degrees\].
        angle: f64,
    },
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Finding::Reciprocity { ratio } => write!(
                f,
                "reciprocity: poisson_warp/young_warp is {ratio:.3} times poisson_weft/young_weft, and an elastic \
                 sheet has 1; one ratio in between is used"
            ),
            Finding::NotPositiveDefinite { poisson: [a, b] } => write!(
                f,
                "positive definiteness: with poisson_warp = {a} and poisson_weft = {b} no elastic membrane gives \
                 these moduli; the ratios are left out (poisson = \"none\")"
            ),
            Finding::ShearFormulas {
                printed,
                consistent,
            } => write!(
                f,
                "shear: (18) as printed gives {:.4} MPa, with each Poisson ratio over its own modulus {:.4} MPa",
                1e-6 * printed,
                1e-6 * consistent
            ),
            Finding::Peirce { ratio } => write!(
                f,
                "bending: Peirce's (19)-(20) gives {ratio:.4} times the rigidity of the exact elastica, which is used"
            ),
            Finding::HalfAngle { angle } => write!(
                f,
                "bending: half the overhang is the bending length at {STANDARD_ANGLE} degrees, the angle is {angle}"
            ),
        }
    }
}

/// What does not fit, apart from what decides the fabric.
pub(super) fn of(tests: &Tests, shear: &Shear, cantilever: &[Cantilever; 2]) -> Vec<Finding> {
    let mut findings = vec![];
    let [warp, weft] = [
        tests.poisson_warp / tests.young_warp,
        tests.poisson_weft / tests.young_weft,
    ];
    let ratio = warp / weft;
    // No ratio at all is a laboratory that did not measure them.
    if warp + weft > 0.0 && (ratio - 1.0).abs() > 0.05 {
        findings.push(Finding::Reciprocity { ratio });
    }
    if let (Some(printed), Some(consistent)) = (shear.printed, shear.consistent)
        && (printed / consistent - 1.0).abs() > 0.01
    {
        findings.push(Finding::ShearFormulas {
            printed,
            consistent,
        });
    }
    let ratio = cantilever[0].peirce.rigidity / cantilever[0].exact.rigidity;
    if (ratio - 1.0).abs() > 0.01 {
        findings.push(Finding::Peirce { ratio });
    }
    let lengths = tests.bending_length_warp.or(tests.bending_length_weft);
    let halved = tests.bending_length_by == BendingRule::HalfOverhang && lengths.is_some();
    if halved && (tests.angle - STANDARD_ANGLE).abs() > 0.05 {
        findings.push(Finding::HalfAngle { angle: tests.angle });
    }
    findings
}

/// A length of cloth that a laboratory can have.
pub(super) fn size(field: &'static str, value: f64) -> Result<f64, Unusable> {
    within(field, value, 1e-4, 10.0, "m").map(|()| value)
}

fn within(field: &'static str, value: f64, min: f64, max: f64, unit: &str) -> Result<(), Unusable> {
    match value >= min && value <= max {
        true => Ok(()),
        false => {
            let allowed = format!("from {min} to {max} {unit}");
            Err(Unusable::new(field, value, allowed.trim_end().to_string()))
        }
    }
}

impl Tests {
    pub(super) fn check(&self) -> Result<(), Unusable> {
        within("areal_density", self.areal_density, 1e-4, 100.0, "kg/m²")?;
        within("thickness", self.thickness, 1e-6, 0.1, "m")?;
        within("young_warp", self.young_warp, 1.0, 1e13, "Pa")?;
        within("young_weft", self.young_weft, 1.0, 1e13, "Pa")?;
        within("young_bias", self.young_bias, 1.0, 1e13, "Pa")?;
        within("poisson_warp", self.poisson_warp, 0.0, 10.0, "")?;
        within("poisson_weft", self.poisson_weft, 0.0, 10.0, "")?;
        within("angle", self.angle, 5.0, 85.0, "degrees")?;
        within("gravity", self.gravity, 1e-3, 1e3, "m/s²")
    }
}
