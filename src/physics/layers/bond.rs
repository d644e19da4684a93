//! Friction of layer on layer as an elastic-plastic bond.

use nalgebra::Vector3;

use super::combine;
use crate::physics::friction::Coulomb;
use crate::physics::stencil::{Gradient, Hessian, Nodes, Potential};

/// A frictional bond of a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerBond {
    /// Nodes of the pair.
    pub nodes: [u32; 4],
    /// Their weights.
    pub weights: [f64; 4],
    /// Normal of the pair \[-\].
    pub normal: Vector3<f64>,
    /// Offset of the pair at which the bond is slack \[m\].
    pub slack: Vector3<f64>,
    /// mu N \[N\].
    pub limit: f64,
    /// Tangential stiffness k \[N/m\].
    pub stiffness: f64,
}

impl LayerBond {
    fn law(&self) -> Coulomb {
        Coulomb {
            normal: self.normal,
            limit: self.limit,
            stiffness: self.stiffness,
        }
    }

    /// Tangential offset from the slack bond \[m\].
    pub fn offset(&self, x: &Nodes<4>) -> Vector3<f64> {
        self.law()
            .tangential(combine(&self.weights, x) - self.slack)
    }

    /// The elastic part of the offset, which the bond remembers, and the slip, which it does not \[m\].
    pub fn settle(&self, x: &Nodes<4>) -> (Vector3<f64>, f64) {
        self.law().settle(self.offset(x))
    }
}

/// Friction over a list of bonds.
pub struct LayerFriction<'a> {
    /// The bonds.
    pub bonds: &'a [LayerBond],
}

impl Potential<4> for LayerFriction<'_> {
    fn count(&self) -> usize {
        self.bonds.len()
    }

    fn nodes(&self, s: usize) -> [u32; 4] {
        self.bonds[s].nodes
    }

    fn value(&self, s: usize, x: &Nodes<4>) -> f64 {
        let bond = &self.bonds[s];
        bond.law().value(&bond.offset(x))
    }

    fn gradient(&self, s: usize, x: &Nodes<4>) -> Gradient<4> {
        let bond = &self.bonds[s];
        let force = bond.law().gradient(&bond.offset(x));
        bond.weights.map(|w| force * w)
    }

    fn hessian(&self, s: usize, x: &Nodes<4>) -> Hessian<4> {
        let bond = &self.bonds[s];
        let matrix = bond.law().hessian(&bond.offset(x));
        let w = bond.weights;
        std::array::from_fn(|i| std::array::from_fn(|j| matrix * (w[i] * w[j])))
    }

    fn hessian_projected(&self, s: usize, x: &Nodes<4>) -> Hessian<4> {
        self.hessian(s, x)
    }
}
