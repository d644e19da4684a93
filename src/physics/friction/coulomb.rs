//! Coulomb's law with an elastic start, for a bond of any kind.

use nalgebra::{Matrix3, Vector3};

use crate::physics::Block;

/// The law of one bond, over its tangential offset `s` \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coulomb {
    /// Contact normal \[-\].
    pub normal: Vector3<f64>,
    /// mu N \[N\].
    pub limit: f64,
    /// Tangential stiffness k \[N/m\].
    pub stiffness: f64,
}

impl Coulomb {
    /// The tangential part of an offset \[m\].
    pub fn tangential(&self, d: Vector3<f64>) -> Vector3<f64> {
        d - self.normal * self.normal.dot(&d)
    }

    /// The elastic part of the offset, which a bond remembers, and the slip, which it does not \[m\].
    pub fn settle(&self, s: Vector3<f64>) -> (Vector3<f64>, f64) {
        let (length, elastic) = (s.norm(), self.limit / self.stiffness);
        if length <= elastic {
            (s, 0.0)
        } else {
            (s * (elastic / length), length - elastic)
        }
    }

    /// Energy, what slip would take included \[J\].
    pub fn value(&self, s: &Vector3<f64>) -> f64 {
        let length = s.norm();
        if self.sticks(length) {
            0.5 * self.stiffness * length * length
        } else {
            self.limit * (length - 0.5 * self.limit / self.stiffness)
        }
    }

    /// Derivative of the energy \[N\].
    pub fn gradient(&self, s: &Vector3<f64>) -> Vector3<f64> {
        let length = s.norm();
        if self.sticks(length) {
            s * self.stiffness
        } else {
            s * (self.limit / length)
        }
    }

    /// Second derivative of the energy \[N/m\], positive semidefinite.
    pub fn hessian(&self, s: &Vector3<f64>) -> Block {
        let length = s.norm();
        let tangential = Matrix3::identity() - self.normal * self.normal.transpose();
        if self.sticks(length) {
            tangential * self.stiffness
        } else {
            let along = s / length;
            (tangential - along * along.transpose()) * (self.limit / length)
        }
    }

    fn sticks(&self, length: f64) -> bool {
        self.stiffness * length <= self.limit
    }
}
