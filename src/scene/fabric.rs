//! The fabric of a scene: a name of the catalogue, single constants replaced, or all constants given.

use super::spec::FabricSpec;
use crate::fabric::{Fabric, Unphysical, catalogue, find};

/// Why the fabric of a scene cannot be had.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FabricError {
    /// The name is not in the catalogue and constants are missing.
    #[error("not in the catalogue ({known}), and as a fabric of one's own it lacks {lacking}")]
    Unknown {
        /// Names of the catalogue.
        known: String,
        /// Constants that are not given.
        lacking: String,
    },
    /// The constants contradict each other or physics.
    #[error("{}", .0.reason)]
    Unphysical(#[from] Unphysical),
}

impl FabricError {
    /// The field of the fabric to blame.
    pub fn field(&self) -> &'static str {
        match self {
            FabricError::Unknown { .. } => "name",
            FabricError::Unphysical(reason) => reason.field,
        }
    }
}

impl FabricSpec {
    /// The fabric: that of the catalogue with the given constants replaced, or one's own.
    pub fn resolve(&self) -> Result<Fabric, FabricError> {
        let fabric = match find(&self.name) {
            Some(base) => self.replace(base),
            None => self.own()?,
        };
        fabric.check()?;
        Ok(fabric)
    }

    fn replace(&self, base: Fabric) -> Fabric {
        Fabric {
            name: base.name,
            areal_density: self.areal_density.unwrap_or(base.areal_density),
            thickness: self.thickness.unwrap_or(base.thickness),
            young_warp: self.young_warp.unwrap_or(base.young_warp),
            young_weft: self.young_weft.unwrap_or(base.young_weft),
            shear_modulus: self.shear_modulus.unwrap_or(base.shear_modulus),
            rigidity_warp: self.rigidity_warp.unwrap_or(base.rigidity_warp),
            rigidity_weft: self.rigidity_weft.unwrap_or(base.rigidity_weft),
            poisson_warp: self.poisson_warp.unwrap_or(base.poisson_warp),
            poisson_weft: self.poisson_weft.unwrap_or(base.poisson_weft),
            twist: self.twist,
            poisson: self.poisson,
        }
    }

    fn own(&self) -> Result<Fabric, FabricError> {
        let mut lacking = vec![];
        let mut take = |field: &'static str, value: Option<f64>| {
            value.unwrap_or_else(|| {
                lacking.push(field);
                0.0
            })
        };
        let fabric = Fabric {
            name: self.name.clone(),
            areal_density: take("areal_density", self.areal_density),
            thickness: take("thickness", self.thickness),
            young_warp: take("young_warp", self.young_warp),
            young_weft: take("young_weft", self.young_weft),
            shear_modulus: take("shear_modulus", self.shear_modulus),
            rigidity_warp: take("rigidity_warp", self.rigidity_warp),
            rigidity_weft: take("rigidity_weft", self.rigidity_weft),
            // Only the Poisson coupling needs the ratios; without it they are not asked for.
            poisson_warp: self.poisson_warp.unwrap_or(0.0),
            poisson_weft: self.poisson_weft.unwrap_or(0.0),
            twist: self.twist,
            poisson: self.poisson,
        };
        if lacking.is_empty() {
            return Ok(fabric);
        }
        let names: Vec<_> = catalogue().into_iter().map(|fabric| fabric.name).collect();
        Err(FabricError::Unknown {
            known: names.join(", "),
            lacking: lacking.join(", "),
        })
    }
}
