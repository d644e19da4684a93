#![doc = include_str!("doc.md")]

#[cfg(test)]
mod test;

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use super::stencil::{Gradient, Hessian, Nodes, Potential};
use crate::fabric::Orthotropic;
use crate::sheet::Mesh;

/// Membrane energy over the faces of a sheet.
#[derive(Clone, Debug)]
pub struct Stretch {
    stiffness: Orthotropic,
    faces: Vec<Face>,
}

#[derive(Clone, Copy, Debug)]
struct Face {
    vertices: [u32; 3],
    area: f64,
    /// Shape gradients \[1/m\].
    shape: [Vector2<f64>; 3],
}

impl Stretch {
    /// Membrane of stiffness C \[N/m\] on a mesh.
    pub fn new(mesh: &Mesh, stiffness: Orthotropic) -> Self {
        let faces = (0..mesh.faces.len())
            .map(|f| Face {
                vertices: mesh.faces[f],
                area: mesh.face_areas[f],
                shape: mesh.shape_gradients(f),
            })
            .collect();
        Self { stiffness, faces }
    }

    /// Green strain (e11, e22, e12) of a face \[-\].
    pub fn strain(&self, s: usize, x: &Nodes<3>) -> Vector3<f64> {
        let [r1, r2] = tangents(&self.faces[s], x);
        0.5 * Vector3::new(
            r1.norm_squared() - 1.0,
            r2.norm_squared() - 1.0,
            r1.dot(&r2),
        )
    }

    /// Largest principal strain in absolute value, as a nominal stretch minus one \[-\].
    pub fn largest_principal(&self, s: usize, x: &Nodes<3>) -> f64 {
        let e = self.strain(s, x);
        let (mean, half) = (
            0.5 * (e.x + e.y),
            (0.25 * (e.x - e.y).powi(2) + e.z * e.z).sqrt(),
        );
        let stretch = |green: f64| ((1.0 + 2.0 * green).max(0.0).sqrt() - 1.0).abs();
        stretch(mean + half).max(stretch(mean - half))
    }

    /// Stress resultant (s11, s22, s12) \[N/m\].
    fn stress(&self, e: &Vector3<f64>) -> Vector3<f64> {
        let c = &self.stiffness;
        Vector3::new(
            c.c11 * e.x + c.c12 * e.y,
            c.c22 * e.y + c.c12 * e.x,
            2.0 * c.c66 * e.z,
        )
    }

    /// The Hessian with a given stress in its geometric part, and a share (0 to 1) of that stress's projection.
    pub fn tangent(&self, s: usize, x: &Nodes<3>, stress: &Vector3<f64>, share: f64) -> Hessian<3> {
        let mut stress = tensor(stress);
        if share > 0.0 {
            stress += (tensile_part(&stress) - stress) * share;
        }
        self.second_derivative(s, x, &stress)
    }

    /// Stress (s11, s22, s12) at nodes `x`, less what is quadratic in the way there from `from` \[N/m\].
    pub fn linearised_stress(&self, s: usize, from: &Nodes<3>, x: &Nodes<3>) -> Vector3<f64> {
        let [r1, r2] = tangents(&self.faces[s], &std::array::from_fn(|k| x[k] - from[k]));
        let quadratic = 0.5 * Vector3::new(r1.norm_squared(), r2.norm_squared(), r1.dot(&r2));
        self.stress(&(self.strain(s, x) - quadratic))
    }

    fn second_derivative(&self, s: usize, x: &Nodes<3>, stress: &Matrix2<f64>) -> Hessian<3> {
        let face = &self.faces[s];
        let [r1, r2] = tangents(face, x);
        let c = self.stiffness;
        let (p11, p22, p12, p21) = (
            r1 * r1.transpose() * (c.c11 * face.area),
            r2 * r2.transpose() * (c.c22 * face.area),
            r1 * r2.transpose() * (c.c12 * face.area),
            r2 * r1.transpose() * (c.c12 * face.area),
        );
        let shear = |a: f64, b: f64| r2 * a + r1 * b;
        let n = &face.shape;
        let mut hessian = [[Matrix3::zeros(); 3]; 3];
        for i in 0..3 {
            let ui = shear(n[i].x, n[i].y) * (c.c66 * face.area);
            for j in 0..=i {
                let uj = shear(n[j].x, n[j].y);
                let geometric = face.area * n[i].dot(&(stress * n[j]));
                hessian[i][j] = p11 * (n[i].x * n[j].x)
                    + p22 * (n[i].y * n[j].y)
                    + p12 * (n[i].x * n[j].y)
                    + p21 * (n[i].y * n[j].x)
                    + ui * uj.transpose()
                    + Matrix3::from_diagonal_element(geometric);
                hessian[j][i] = hessian[i][j].transpose();
            }
        }
        hessian
    }
}

/// Tangents r,1 and r,2 \[-\].
fn tangents(face: &Face, x: &Nodes<3>) -> [Vector3<f64>; 2] {
    let n = &face.shape;
    [
        x[0] * n[0].x + x[1] * n[1].x + x[2] * n[2].x,
        x[0] * n[0].y + x[1] * n[1].y + x[2] * n[2].y,
    ]
}

fn tensor(voigt: &Vector3<f64>) -> Matrix2<f64> {
    Matrix2::new(voigt.x, voigt.z, voigt.z, voigt.y)
}

/// The tensile part of a plane stress.
fn tensile_part(stress: &Matrix2<f64>) -> Matrix2<f64> {
    let (mean, difference) = (0.5 * stress.trace(), 0.5 * (stress.m11 - stress.m22));
    let radius = difference.hypot(stress.m12);
    if mean - radius >= 0.0 {
        return *stress;
    }
    if mean + radius <= 0.0 {
        return Matrix2::zeros();
    }
    // One tensile principal stress: its projector is (1 + (s - mean)/radius)/2.
    let deviator = stress - Matrix2::from_diagonal_element(mean);
    (Matrix2::identity() + deviator / radius) * (0.5 * (mean + radius))
}

impl Potential<3> for Stretch {
    fn count(&self) -> usize {
        self.faces.len()
    }

    fn nodes(&self, s: usize) -> [u32; 3] {
        self.faces[s].vertices
    }

    fn value(&self, s: usize, x: &Nodes<3>) -> f64 {
        let e = self.strain(s, x);
        let t = self.stress(&e);
        0.5 * self.faces[s].area * (t.x * e.x + t.y * e.y + 2.0 * t.z * e.z)
    }

    fn gradient(&self, s: usize, x: &Nodes<3>) -> Gradient<3> {
        let face = &self.faces[s];
        let [r1, r2] = tangents(face, x);
        let t = self.stress(&self.strain(s, x)) * face.area;
        let (along_warp, along_weft) = (r1 * t.x + r2 * t.z, r1 * t.z + r2 * t.y);
        face.shape.map(|n| along_warp * n.x + along_weft * n.y)
    }

    fn hessian(&self, s: usize, x: &Nodes<3>) -> Hessian<3> {
        let stress = self.stress(&self.strain(s, x));
        self.second_derivative(s, x, &tensor(&stress))
    }

    fn hessian_projected(&self, s: usize, x: &Nodes<3>) -> Hessian<3> {
        let stress = self.stress(&self.strain(s, x));
        self.second_derivative(s, x, &tensile_part(&tensor(&stress)))
    }
}
