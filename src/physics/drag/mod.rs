#![doc = include_str!("doc.md")]

#[cfg(test)]
mod test;

use nalgebra::{Matrix3, Vector3};

use super::stencil::{Block, Gradient, Hessian, Load, Nodes};

/// Air on the faces at one moment.
#[derive(Clone, Debug)]
pub struct Drag<'a> {
    /// Vertices of each face.
    pub faces: &'a [[u32; 3]],
    /// C \[kg/(m²·s)\].
    pub fluid_damping: f64,
    /// Velocity of the air at each vertex \[m/s\].
    pub air: Vec<Vector3<f64>>,
}

impl Drag<'_> {
    /// R: what the air's velocity over the sheet is multiplied by at each corner of a face \[N·s/m\]; zero for a
    /// face without area.
    pub fn resistance(&self, x: &Nodes<3>) -> Block {
        let normal = normal(x);
        match normal.norm() {
            0.0 => Block::zeros(),
            length => normal * normal.transpose() * (self.fluid_damping / (6.0 * length)),
        }
    }

    /// Power that the air puts in at positions `x` and velocities `v`, negative where it brakes \[W\].
    pub fn power(&self, x: &[Vector3<f64>], v: &[Vector3<f64>]) -> f64 {
        let forces = self.forces(x, v);
        forces.iter().zip(v).map(|(force, v)| force.dot(v)).sum()
    }

    /// Force on the vertices at positions `x` and velocities `v` \[N\].
    pub fn forces(&self, x: &[Vector3<f64>], v: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let mut sum = vec![Vector3::zeros(); v.len()];
        for s in 0..self.count() {
            let stencil = self.nodes(s).map(|n| n as usize);
            let resistance = self.resistance(&stencil.map(|n| x[n]));
            for n in stencil {
                sum[n] += resistance * (self.air[n] - v[n]);
            }
        }
        sum
    }
}

/// Normal of a face, twice its area long \[m²\].
fn normal(x: &Nodes<3>) -> Vector3<f64> {
    (x[1] - x[0]).cross(&(x[2] - x[0]))
}

impl Load<3> for Drag<'_> {
    fn count(&self) -> usize {
        self.faces.len()
    }

    fn nodes(&self, s: usize) -> [u32; 3] {
        self.faces[s]
    }

    fn force(&self, s: usize, x: &Nodes<3>, v: &Nodes<3>) -> Gradient<3> {
        let resistance = self.resistance(x);
        std::array::from_fn(|i| resistance * (self.air[self.faces[s][i] as usize] - v[i]))
    }

    fn by_position(&self, s: usize, x: &Nodes<3>, v: &Nodes<3>) -> Hessian<3> {
        let normal = normal(x);
        let length = normal.norm();
        if length == 0.0 {
            return [[Block::zeros(); 3]; 3];
        }
        let unit = normal / length;
        let turns = [x[2] - x[1], x[0] - x[2], x[1] - x[0]].map(|side| side.cross_matrix());
        std::array::from_fn(|i| {
            let over = self.air[self.faces[s][i] as usize] - v[i];
            let along = unit.dot(&over);
            let by_normal =
                unit * over.transpose() + (Matrix3::identity() - unit * unit.transpose()) * along;
            turns.map(|turn| by_normal * turn * (self.fluid_damping / 6.0))
        })
    }

    fn by_velocity(&self, _s: usize, x: &Nodes<3>, _v: &Nodes<3>) -> Hessian<3> {
        let resistance = self.resistance(x);
        let block = |same: bool| if same { -resistance } else { Block::zeros() };
        std::array::from_fn(|i| std::array::from_fn(|j| block(i == j)))
    }
}
