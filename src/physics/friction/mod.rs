#![doc = include_str!("doc.md")]

#[cfg(test)]
mod test;

use nalgebra::{Matrix3, Vector3};

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
    /// Tangential offset of the point `y` from the anchor \[m\].
    pub fn offset(&self, y: &Vector3<f64>) -> Vector3<f64> {
        let d = y - self.anchor;
        d - self.normal * self.normal.dot(&d)
    }

    /// The elastic part of the offset, which the bond remembers, and the slip, which it does not \[m\].
    pub fn settle(&self, y: &Vector3<f64>) -> (Vector3<f64>, f64) {
        let s = self.offset(y);
        let (length, elastic) = (s.norm(), self.limit / self.stiffness);
        if length <= elastic {
            (s, 0.0)
        } else {
            (s * (elastic / length), length - elastic)
        }
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
        let length = bond.offset(&weighted(&bond.weights, x)).norm();
        if bond.stiffness * length <= bond.limit {
            0.5 * bond.stiffness * length * length
        } else {
            bond.limit * (length - 0.5 * bond.limit / bond.stiffness)
        }
    }

    fn gradient(&self, s: usize, x: &Nodes<3>) -> Gradient<3> {
        let bond = &self.bonds[s];
        let offset = bond.offset(&weighted(&bond.weights, x));
        let length = offset.norm();
        let force = if bond.stiffness * length <= bond.limit {
            offset * bond.stiffness
        } else {
            offset * (bond.limit / length)
        };
        bond.weights.map(|w| force * w)
    }

    fn hessian(&self, s: usize, x: &Nodes<3>) -> Hessian<3> {
        let bond = &self.bonds[s];
        let offset = bond.offset(&weighted(&bond.weights, x));
        let length = offset.norm();
        let tangential = Matrix3::identity() - bond.normal * bond.normal.transpose();
        let matrix = if bond.stiffness * length <= bond.limit {
            tangential * bond.stiffness
        } else {
            let along = offset / length;
            (tangential - along * along.transpose()) * (bond.limit / length)
        };
        spread(&bond.weights, &matrix)
    }

    fn hessian_projected(&self, s: usize, x: &Nodes<3>) -> Hessian<3> {
        self.hessian(s, x)
    }
}
