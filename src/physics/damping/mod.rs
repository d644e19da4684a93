#![doc = include_str!("doc.md")]

#[cfg(test)]
mod test;

use nalgebra::Vector3;

use super::stencil::{Block, Gradient, Hessian, Load, Nodes};

/// Viscous damping on the vertices.
#[derive(Clone, Debug)]
pub struct Damping {
    /// mu A_i \[N·s/m\], shape \[vertices\].
    pub coefficients: Vec<f64>,
}

impl Damping {
    /// Damping `mu` \[kg/(m²·s)\] on vertex areas \[m²\].
    pub fn new(mu: f64, vertex_areas: &[f64]) -> Self {
        let coefficients = vertex_areas.iter().map(|a| mu * a).collect();
        Self { coefficients }
    }

    /// Power taken out \[W\].
    pub fn power(&self, velocities: &[Vector3<f64>]) -> f64 {
        self.coefficients
            .iter()
            .zip(velocities)
            .map(|(c, v)| c * v.norm_squared())
            .sum()
    }
}

impl Load<1> for Damping {
    fn count(&self) -> usize {
        self.coefficients.len()
    }

    fn nodes(&self, s: usize) -> [u32; 1] {
        [s as u32]
    }

    fn force(&self, s: usize, _x: &Nodes<1>, v: &Nodes<1>) -> Gradient<1> {
        [v[0] * -self.coefficients[s]]
    }

    fn by_position(&self, _s: usize, _x: &Nodes<1>, _v: &Nodes<1>) -> Hessian<1> {
        [[Block::zeros()]]
    }

    fn by_velocity(&self, s: usize, _x: &Nodes<1>, _v: &Nodes<1>) -> Hessian<1> {
        [[Block::from_diagonal_element(-self.coefficients[s])]]
    }
}
