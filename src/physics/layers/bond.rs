//! Friction of layer on layer as an elastic-plastic bond.

use nalgebra::{Matrix3, Vector3};

use super::combine;
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
    /// Tangential offset from the slack bond \[m\].
    pub fn offset(&self, x: &Nodes<4>) -> Vector3<f64> {
        let d = combine(&self.weights, x) - self.slack;
        d - self.normal * self.normal.dot(&d)
    }

    /// The elastic part of the offset, which the bond remembers, and the slip, which it does not \[m\].
    pub fn settle(&self, x: &Nodes<4>) -> (Vector3<f64>, f64) {
        let s = self.offset(x);
        let (length, elastic) = (s.norm(), self.limit / self.stiffness);
        if length <= elastic {
            (s, 0.0)
        } else {
            (s * (elastic / length), length - elastic)
        }
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
        let length = bond.offset(x).norm();
        if bond.stiffness * length <= bond.limit {
            0.5 * bond.stiffness * length * length
        } else {
            bond.limit * (length - 0.5 * bond.limit / bond.stiffness)
        }
    }

    fn gradient(&self, s: usize, x: &Nodes<4>) -> Gradient<4> {
        let bond = &self.bonds[s];
        let offset = bond.offset(x);
        let length = offset.norm();
        let force = if bond.stiffness * length <= bond.limit {
            offset * bond.stiffness
        } else {
            offset * (bond.limit / length)
        };
        bond.weights.map(|w| force * w)
    }

    fn hessian(&self, s: usize, x: &Nodes<4>) -> Hessian<4> {
        let bond = &self.bonds[s];
        let offset = bond.offset(x);
        let length = offset.norm();
        let tangential = Matrix3::identity() - bond.normal * bond.normal.transpose();
        let matrix = if bond.stiffness * length <= bond.limit {
            tangential * bond.stiffness
        } else {
            let along = offset / length;
            (tangential - along * along.transpose()) * (bond.limit / length)
        };
        let w = bond.weights;
        std::array::from_fn(|i| std::array::from_fn(|j| matrix * (w[i] * w[j])))
    }

    fn hessian_projected(&self, s: usize, x: &Nodes<4>) -> Hessian<4> {
        self.hessian(s, x)
    }
}
