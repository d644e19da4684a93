//! From laboratory tests to the constants of a fabric: (17)-(20) of the paper, corrected where they need it.

mod bending;
mod elastica;
mod finding;
#[cfg(test)]
mod test;

use serde::{Deserialize, Serialize};

use super::law::{Fabric, PoissonCoupling, TwistRigidity};
pub use bending::{Bending, BendingRule, STANDARD_ANGLE};
pub use elastica::HeavyElastica;
pub use finding::{Finding, Unusable};

/// What a laboratory measured, SI; the document that `toile identify` reads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tests {
    /// Name of the fabric.
    pub name: String,
    /// \[kg/m²\]
    pub areal_density: f64,
    /// \[m\]
    pub thickness: f64,
    /// Young's modulus in warp tension \[Pa\].
    pub young_warp: f64,
    /// In weft tension \[Pa\].
    pub young_weft: f64,
    /// In tension at 45 degrees \[Pa\].
    pub young_bias: f64,
    /// Contraction over extension, as strains, under warp tension \[-\].
    #[serde(default)]
    pub poisson_warp: f64,
    /// Under weft tension \[-\].
    #[serde(default)]
    pub poisson_weft: f64,
    /// Angle of the cantilever test from the horizontal \[degrees\].
    #[serde(default = "standard_angle")]
    pub angle: f64,
    /// \[m/s²\]
    #[serde(default = "standard_gravity")]
    pub gravity: f64,
    /// Overhang at the angle, strip along the warp \[m\]; this or the bending length.
    #[serde(default)]
    pub overhang_warp: Option<f64>,
    /// Strip along the weft \[m\].
    #[serde(default)]
    pub overhang_weft: Option<f64>,
    /// Bending length as the laboratory computed it, strip along the warp \[m\].
    #[serde(default)]
    pub bending_length_warp: Option<f64>,
    /// Strip along the weft \[m\].
    #[serde(default)]
    pub bending_length_weft: Option<f64>,
    /// The formula by which it did.
    #[serde(default)]
    pub bending_length_by: BendingRule,
}

fn standard_angle() -> f64 {
    STANDARD_ANGLE
}

fn standard_gravity() -> f64 {
    9.81
}

/// A cantilever test read in both ways.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Cantilever {
    /// Overhang \[m\].
    pub overhang: f64,
    /// By the exact elastica.
    pub exact: Bending,
    /// By Peirce's (19) and (20).
    pub peirce: Bending,
}

/// The shear modulus in three readings \[Pa\]; none where the tests leave no positive one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Shear {
    /// Equation (18) as printed, which gives each ratio to the other yarn's modulus.
    pub printed: Option<f64>,
    /// Each ratio with its own modulus, as the compliance tensor has it: S12 = -nu/E.
    pub consistent: Option<f64>,
    /// Without Poisson's ratios: what a membrane with C12 = 0 needs to give the bias modulus back.
    pub uncoupled: Option<f64>,
}

/// Elastic constants of a tension test \[Pa\], \[-\].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tension {
    /// Young's moduli in warp, weft and bias \[Pa\].
    pub young: [f64; 3],
    /// Contraction over extension under warp and weft tension \[-\].
    pub poisson: [f64; 2],
}

/// What the tests come to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Identified {
    /// The fabric; its rigidities are those of the exact elastica.
    pub fabric: Fabric,
    /// Cantilever along warp and weft.
    pub cantilever: [Cantilever; 2],
    /// The shear modulus.
    pub shear: Shear,
    /// What was measured in tension.
    pub measured: Tension,
    /// What the fabric gives back in the same tests.
    pub given_back: Tension,
    /// What does not fit.
    pub findings: Vec<Finding>,
}

/// Shear modulus from moduli in warp, weft and bias and the two Poisson ratios \[Pa\].
pub fn shear(test: &Tension) -> Shear {
    let [warp, weft, bias] = test.young;
    let [nu_warp, nu_weft] = test.poisson;
    let modulus = |nu_of_warp: f64, nu_of_weft: f64| {
        let compliance = 4.0 / bias - (1.0 - nu_of_warp) / warp - (1.0 - nu_of_weft) / weft;
        (compliance > 0.0).then(|| compliance.recip())
    };
    Shear {
        printed: modulus(nu_weft, nu_warp),
        consistent: modulus(nu_warp, nu_weft),
        uncoupled: modulus(0.0, 0.0),
    }
}

/// What small tension tests on a membrane of this fabric give.
pub fn tension(fabric: &Fabric) -> Tension {
    let c = fabric.membrane();
    let (scale, h) = (c.c11 * c.c22 - c.c12 * c.c12, fabric.thickness);
    let (s11, s22, s12, s66) = (c.c22 / scale, c.c11 / scale, -c.c12 / scale, 1.0 / c.c66);
    Tension {
        young: [s11, s22, 0.25 * (s11 + s22 + 2.0 * s12 + s66)].map(|s| 1.0 / (s * h)),
        poisson: [-s12 / s11, -s12 / s22],
    }
}

impl Tests {
    /// The fabric that these tests describe, and what in them does not fit.
    ///
    /// # Errors
    /// A value is missing, out of its range, or no fabric can have it.
    pub fn identify(&self) -> Result<Identified, Unusable> {
        self.check()?;
        let measured = Tension {
            young: [self.young_warp, self.young_weft, self.young_bias],
            poisson: [self.poisson_warp, self.poisson_weft],
        };
        let cantilever = [self.cantilever(Yarn::Warp)?, self.cantilever(Yarn::Weft)?];
        let shear = shear(&measured);
        let mut findings = vec![];
        let fabric = self.fabric(&shear, &cantilever, &mut findings)?;
        findings.extend(finding::of(self, &shear, &cantilever));
        Ok(Identified {
            given_back: tension(&fabric),
            fabric,
            cantilever,
            shear,
            measured,
            findings,
        })
    }

    /// With the ratios coupled if that makes a fabric, else without them.
    fn fabric(
        &self,
        shear: &Shear,
        cantilever: &[Cantilever; 2],
        findings: &mut Vec<Finding>,
    ) -> Result<Fabric, Unusable> {
        let [rigidity_warp, rigidity_weft] = cantilever.map(|c| c.exact.rigidity);
        let with = |poisson, shear_modulus| Fabric {
            name: self.name.clone(),
            areal_density: self.areal_density,
            thickness: self.thickness,
            young_warp: self.young_warp,
            young_weft: self.young_weft,
            shear_modulus,
            rigidity_warp,
            rigidity_weft,
            poisson_warp: self.poisson_warp,
            poisson_weft: self.poisson_weft,
            twist: TwistRigidity::default(),
            poisson,
        };
        if self.poisson_warp + self.poisson_weft > 0.0 {
            let coupled = shear.printed.map(|h| with(PoissonCoupling::Symmetrised, h));
            match coupled {
                Some(fabric) if fabric.check().is_ok() => return Ok(fabric),
                _ => findings.push(Finding::NotPositiveDefinite {
                    poisson: [self.poisson_warp, self.poisson_weft],
                }),
            }
        }
        let stiffest = 4.0 / (1.0 / self.young_warp + 1.0 / self.young_weft);
        let Some(modulus) = shear.uncoupled else {
            let allowed = format!("below {stiffest:.4e} Pa, where shear would be rigid");
            return Err(Unusable::new("young_bias", self.young_bias, allowed));
        };
        Ok(with(PoissonCoupling::None, modulus))
    }

    fn cantilever(&self, yarn: Yarn) -> Result<Cantilever, Unusable> {
        let (overhang, length, names) = match yarn {
            Yarn::Warp => (
                self.overhang_warp,
                self.bending_length_warp,
                ["overhang_warp", "bending_length_warp"],
            ),
            Yarn::Weft => (
                self.overhang_weft,
                self.bending_length_weft,
                ["overhang_weft", "bending_length_weft"],
            ),
        };
        let angle = self.angle.to_radians();
        let overhang = match (overhang, length) {
            (Some(overhang), None) => finding::size(names[0], overhang)?,
            (None, Some(length)) => {
                finding::size(names[1], length)? / self.bending_length_by.factor(angle)
            }
            (None, None) => {
                return Err(Unusable::Missing {
                    one: names[0],
                    other: names[1],
                });
            }
            (Some(_), Some(_)) => {
                return Err(Unusable::Twice {
                    one: names[0],
                    other: names[1],
                });
            }
        };
        let weight = self.areal_density * self.gravity;
        let exact = Bending::exact(overhang, angle, weight).ok_or_else(|| {
            Unusable::new("angle", self.angle, "from 5 to 85 degrees".to_string())
        })?;
        Ok(Cantilever {
            overhang,
            exact,
            peirce: Bending::peirce(overhang, angle, weight),
        })
    }
}

#[derive(Clone, Copy)]
enum Yarn {
    Warp,
    Weft,
}
