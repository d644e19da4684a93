#![doc = include_str!("doc.md")]

mod coulomb;
#[cfg(test)]
mod test;

use nalgebra::Vector3;

pub use coulomb::Coulomb;

use super::contact::{spread, weighted};
use super::stencil::{Gradient, Hessian, Nodes, Potential};

/// A frictional bond at a point of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bond {
    /// Vertices of the face.
    pub vertices: [u32; 3],
    /// Barycentric coordinates of the point.
    pub weights: [f64; 3],
    /// Contact normal \[-\].
    pub normal: Vector3<f64>,
    /// Anchor on the obstacle, where it is at the end of the step \[m\].
    pub anchor: Vector3<f64>,
    /// mu N \[N\].
    pub limit: f64,
    /// Tangential stiffness k \[N/m\].
    pub stiffness: f64,
}

impl Bond {
    fn law(&self) -> Coulomb {
        Coulomb {
            normal: self.normal,
            limit: self.limit,
            stiffness: self.stiffness,
        }
    }

    /// Tangential offset of the point `y` from the anchor \[m\].
    pub fn offset(&self, y: &Vector3<f64>) -> Vector3<f64> {
        self.law().tangential(y - self.anchor)
    }

    /// The elastic part of the offset, which the bond remembers, and the slip, which it does not \[m\].
    pub fn settle(&self, y: &Vector3<f64>) -> (Vector3<f64>, f64) {
        self.law().settle(self.offset(y))
    }
}

/// Friction over a list of bonds.
pub struct Friction<'a> {
    /// The bonds.
    pub bonds: &'a [Bond],
}

impl Potential<3> for Friction<'_> {
    fn count(&self) -> usize {
        self.bonds.len()
    }

    fn nodes(&self, s: usize) -> [u32; 3] {
        self.bonds[s].vertices
    }

    fn value(&self, s: usize, x: &Nodes<3>) -> f64 {
        let bond = &self.bonds[s];
        bond.law().value(&bond.offset(&weighted(&bond.weights, x)))
    }

    fn gradient(&self, s: usize, x: &Nodes<3>) -> Gradient<3> {
        let bond = &self.bonds[s];
        let force = bond
            .law()
            .gradient(&bond.offset(&weighted(&bond.weights, x)));
        bond.weights.map(|w| force * w)
    }

    fn hessian(&self, s: usize, x: &Nodes<3>) -> Hessian<3> {
        let bond = &self.bonds[s];
        let matrix = bond
            .law()
            .hessian(&bond.offset(&weighted(&bond.weights, x)));
        spread(&bond.weights, &matrix)
    }

    fn hessian_projected(&self, s: usize, x: &Nodes<3>) -> Hessian<3> {
        self.hessian(s, x)
    }
}
