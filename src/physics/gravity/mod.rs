#![doc = include_str!("doc.md")]

#[cfg(test)]
mod test;

use nalgebra::{Matrix3, Vector3};

use super::stencil::{Gradient, Hessian, Nodes, Potential};

/// Weight of the vertices, and the dead loads they bear.
#[derive(Clone, Debug)]
pub struct Gravity {
    /// m g and loads \[N\], shape \[vertices\].
    weights: Vec<Vector3<f64>>,
}

impl Gravity {
    /// Weight of `masses` \[kg\] in a field \[m/s²\].
    pub fn new(masses: &[f64], field: Vector3<f64>) -> Self {
        let weights = masses.iter().map(|&m| field * m).collect();
        Self { weights }
    }

    /// Adds dead loads \[N\] to the vertices.
    pub fn load(&mut self, forces: &[Vector3<f64>]) {
        for (weight, force) in self.weights.iter_mut().zip(forces) {
            *weight += force;
        }
    }

    /// Sum of the weights of all vertices \[N\].
    pub fn total(&self) -> f64 {
        self.weights.iter().map(|w| w.norm()).sum()
    }
}

impl Potential<1> for Gravity {
    fn count(&self) -> usize {
        self.weights.len()
    }

    fn nodes(&self, s: usize) -> [u32; 1] {
        [s as u32]
    }

    fn value(&self, s: usize, x: &Nodes<1>) -> f64 {
        -self.weights[s].dot(&x[0])
    }

    fn gradient(&self, s: usize, _x: &Nodes<1>) -> Gradient<1> {
        [-self.weights[s]]
    }

    fn hessian(&self, _s: usize, _x: &Nodes<1>) -> Hessian<1> {
        [[Matrix3::zeros()]]
    }

    fn hessian_projected(&self, s: usize, x: &Nodes<1>) -> Hessian<1> {
        self.hessian(s, x)
    }
}
