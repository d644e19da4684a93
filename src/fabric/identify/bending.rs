//! The cantilever test: overhang and angle in, bending length and flexural rigidity out.

use serde::{Deserialize, Serialize};

use super::elastica::HeavyElastica;

/// Angle of the standard test, ASTM D1388 and ISO 9073-7, from the horizontal \[degrees\].
pub const STANDARD_ANGLE: f64 = 41.5;

/// How a bending length was computed from an overhang.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BendingRule {
    /// The paper's (19), after Peirce: c = L (cos(θ/2) / (8 tan θ))^(1/3).
    #[default]
    Peirce,
    /// ASTM D1388: half the overhang at 41.5 degrees. The exact factor is 0.49991.
    HalfOverhang,
}

/// A bending length with the rigidity that it stands for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bending {
    /// c = (D / (rho g))^(1/3) \[m\].
    pub length: f64,
    /// Flexural rigidity D = rho g c³, the paper's (20) \[N·m\].
    pub rigidity: f64,
}

impl Bending {
    /// From the overhang \[m\] of a strip of so much weight per area \[N/m²\] whose chord hangs at `angle` \[rad\], by
    /// the exact elastica; none if no strip hangs so.
    pub fn exact(overhang: f64, angle: f64, weight: f64) -> Option<Self> {
        let strip = HeavyElastica::of_chord(angle)?;
        Some(Self::new(overhang * strip.bending_length(), weight))
    }

    /// The same by Peirce's formula, (19) and (20).
    pub fn peirce(overhang: f64, angle: f64, weight: f64) -> Self {
        Self::new(overhang * BendingRule::Peirce.factor(angle), weight)
    }

    fn new(length: f64, weight: f64) -> Self {
        Self {
            length,
            rigidity: weight * length.powi(3),
        }
    }
}

impl BendingRule {
    /// Bending length over overhang at an angle \[rad\]; the half knows its own angle only.
    pub fn factor(self, angle: f64) -> f64 {
        match self {
            BendingRule::Peirce => ((0.5 * angle).cos() / (8.0 * angle.tan())).cbrt(),
            BendingRule::HalfOverhang => 0.5,
        }
    }
}
