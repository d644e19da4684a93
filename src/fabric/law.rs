//! The orthotropic law of a woven fabric: engineering constants in, surface stiffness out.

use serde::{Deserialize, Serialize};

/// How the twist rigidity D66, which no textile test in the paper measures, follows from the other two.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TwistRigidity {
    /// 4 D66 = 2 √(D11 D22): the isotropic relation at zero Poisson ratio, generalised.
    #[default]
    Geometric,
    /// D66 = 0: the paper's choice. Not elliptic: the saddle x·y costs no energy.
    None,
}

/// Whether extension in warp contracts the weft (C12).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PoissonCoupling {
    /// C12 = 0: the paper's model.
    #[default]
    None,
    /// One reciprocal ratio from the two measured ones, such that equation (18) gives back the bias modulus.
    Symmetrised,
}

/// Four constants of an orthotropic quadratic form in Voigt order, energy
/// `1/2 [c11 a11² + c22 a22² + 2 c12 a11 a22 + 4 c66 a12²]`; \[N/m\] for strain, \[N·m\] for curvature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orthotropic {
    /// Warp stiffness.
    pub c11: f64,
    /// Weft stiffness.
    pub c22: f64,
    /// Warp-weft coupling.
    pub c12: f64,
    /// Shear (or twist) stiffness, for the engineering component 2 a12.
    pub c66: f64,
}

impl Orthotropic {
    /// The 3 x 3 matrix of the form in (a11, a22, 2 a12).
    pub fn matrix(&self) -> nalgebra::Matrix3<f64> {
        nalgebra::Matrix3::new(
            self.c11, self.c12, 0.0, self.c12, self.c22, 0.0, 0.0, 0.0, self.c66,
        )
    }
}

/// Why a set of constants cannot be a fabric.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{field} = {value}: {reason}")]
pub struct Unphysical {
    /// Name of the field as written in a scene.
    pub field: &'static str,
    /// The offending value, SI.
    pub value: f64,
    /// What a fabric needs.
    pub reason: &'static str,
}

/// A fabric by its engineering constants (paper, Table 2), SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fabric {
    /// Name, F1 to F12 in the catalogue.
    pub name: String,
    /// Mass per area \[kg/m²\].
    pub areal_density: f64,
    /// Cloth thickness \[m\]: turns moduli into surface stiffness, and is the contact thickness.
    pub thickness: f64,
    /// Young's modulus along the warp \[Pa\].
    pub young_warp: f64,
    /// Young's modulus along the weft \[Pa\].
    pub young_weft: f64,
    /// Shear modulus H \[Pa\].
    pub shear_modulus: f64,
    /// Flexural rigidity along the warp \[N·m\].
    pub rigidity_warp: f64,
    /// Flexural rigidity along the weft \[N·m\].
    pub rigidity_weft: f64,
    /// Measured Poisson ratio under warp tension \[-\].
    #[serde(default)]
    pub poisson_warp: f64,
    /// Measured Poisson ratio under weft tension \[-\].
    #[serde(default)]
    pub poisson_weft: f64,
    /// Choice of D66.
    #[serde(default)]
    pub twist: TwistRigidity,
    /// Choice of C12.
    #[serde(default)]
    pub poisson: PoissonCoupling,
}

impl Fabric {
    /// Membrane stiffness C \[N/m\]: C11 = E_wp h, C22 = E_wt h, C66 = H h (DESIGN section 1).
    ///
    /// With [`PoissonCoupling::Symmetrised`] the compliance S12 = -1/2 (nu_wt/E_wp + nu_wp/E_wt) is what
    /// the paper's (18) implies once reciprocity is restored, so the bias modulus of Table 2 comes back.
    pub fn membrane(&self) -> Orthotropic {
        let h = self.thickness;
        let c66 = self.shear_modulus * h;
        match self.poisson {
            PoissonCoupling::None => Orthotropic {
                c11: self.young_warp * h,
                c22: self.young_weft * h,
                c12: 0.0,
                c66,
            },
            PoissonCoupling::Symmetrised => {
                let (s11, s22) = (1.0 / self.young_warp, 1.0 / self.young_weft);
                let s12 = -0.5 * (self.poisson_weft * s11 + self.poisson_warp * s22);
                let scale = h / (s11 * s22 - s12 * s12);
                Orthotropic {
                    c11: s22 * scale,
                    c22: s11 * scale,
                    c12: -s12 * scale,
                    c66,
                }
            }
        }
    }

    /// Bending stiffness D \[N·m\]: D11 = Rf_wp, D22 = Rf_wt, D12 = 0, D66 by [`TwistRigidity`].
    pub fn bending(&self) -> Orthotropic {
        let (d11, d22) = (self.rigidity_warp, self.rigidity_weft);
        let c66 = match self.twist {
            TwistRigidity::Geometric => 0.5 * (d11 * d22).sqrt(),
            TwistRigidity::None => 0.0,
        };
        Orthotropic {
            c11: d11,
            c22: d22,
            c12: 0.0,
            c66,
        }
    }

    /// Bending length l = (Rf / (rho g))^(1/3) of the limper direction \[m\]: the scale a mesh must resolve.
    pub fn bending_length(&self, gravity: f64) -> f64 {
        let rigidity = self.rigidity_warp.min(self.rigidity_weft);
        (rigidity / (self.areal_density * gravity)).cbrt()
    }

    /// Checks that the constants can be a fabric: finite, positive, C and D positive definite.
    pub fn check(&self) -> Result<(), Unphysical> {
        for (field, value) in [
            ("areal_density", self.areal_density),
            ("thickness", self.thickness),
            ("young_warp", self.young_warp),
            ("young_weft", self.young_weft),
            ("shear_modulus", self.shear_modulus),
            ("rigidity_warp", self.rigidity_warp),
            ("rigidity_weft", self.rigidity_weft),
        ] {
            if !(value.is_finite() && value > 0.0) {
                let reason = "must be finite and positive";
                return Err(Unphysical {
                    field,
                    value,
                    reason,
                });
            }
        }
        for (field, value) in [
            ("poisson_warp", self.poisson_warp),
            ("poisson_weft", self.poisson_weft),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                let reason = "must be finite and not negative";
                return Err(Unphysical {
                    field,
                    value,
                    reason,
                });
            }
        }
        let c = self.membrane();
        if !(c.c11 > 0.0 && c.c22 > 0.0 && c.c11 * c.c22 > c.c12 * c.c12) {
            return Err(Unphysical {
                field: "poisson_warp",
                value: self.poisson_warp,
                reason: "with this poisson_weft the membrane stiffness C is not positive definite",
            });
        }
        Ok(())
    }
}
