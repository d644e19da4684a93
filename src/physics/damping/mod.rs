#![doc = include_str!("doc.md")]

#[cfg(test)]
mod test;

use nalgebra::Vector3;

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

    /// Force on vertex `i` at velocity `v` \[N\].
    pub fn force(&self, i: usize, v: &Vector3<f64>) -> Vector3<f64> {
        v * -self.coefficients[i]
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
