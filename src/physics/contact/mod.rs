#![doc = include_str!("doc.md")]

#[cfg(test)]
mod test;

use nalgebra::{Matrix2, Matrix3, SMatrix, Vector3};

use super::stencil::{Gradient, Hessian, Nodes, Potential};
use crate::contact::{Distance, Obstacle, Proximity};
use crate::sheet::Mesh;

/// Depth at which the whole weight of the sheet on one contact comes to rest \[m\].
pub const DEPTH: f64 = 5e-5;
/// Stiffness of deep contact over that of a shallow one.
const FIRMNESS: f64 = 100.0;
/// Depth over which the stiffness sets in \[m\].
const ONSET: f64 = 1e-5;

/// The contact law psi(g).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLaw {
    /// Stiffness k \[N/m\].
    pub stiffness: f64,
    /// Tangential stiffness of a sticking contact \[N/m\]: a tenth of the normal one. Stiffer bonds turn from
    /// stick to slip within nanometres, which Newton's method pays for.
    pub grip: f64,
    /// Half the cloth thickness \[m\].
    pub offset: f64,
    /// Depth from which on contact stiffens \[m\], so that no force brings the middle surface to the obstacle; infinite
    /// where the scheme stops it by impulses instead.
    pub firm: f64,
}

impl ContactLaw {
    /// Contact for a sheet of a weight \[N\], membrane stiffness sqrt(C11 C22) \[N/m\] and thickness \[m\].
    pub fn new(weight: f64, membrane: f64, thickness: f64) -> Self {
        let stiffness = (weight / DEPTH).max(membrane);
        Self {
            stiffness,
            grip: 0.1 * stiffness,
            offset: 0.5 * thickness,
            firm: f64::INFINITY,
        }
    }

    /// Depth that no contact should pass \[m\]: half way to the middle surface, for cloth that is not thinner than
    /// contact is soft.
    pub fn limit(&self) -> f64 {
        (0.5 * self.offset).max(2.0 * DEPTH)
    }

    /// The law that stiffens from there on.
    pub fn stiffening(self) -> Self {
        Self {
            firm: self.limit(),
            ..self
        }
    }

    /// What stiffening adds to psi, psi' and psi'' at a depth: psi'' rises by [`FIRMNESS`] k over a depth w.
    fn firmness(&self, depth: f64) -> [f64; 3] {
        let (t, w, k) = (
            depth - self.firm,
            0.5 * self.firm,
            FIRMNESS * self.stiffness,
        );
        if t <= 0.0 {
            [0.0; 3]
        } else if t < w {
            [k * t * t * t / (6.0 * w), -0.5 * k * t * t / w, k * t / w]
        } else {
            [
                0.5 * k * (t * t - w * t + w * w / 3.0),
                -k * (t - 0.5 * w),
                k,
            ]
        }
    }

    /// psi, psi' and psi'' at a gap \[J, N, N/m\].
    pub fn psi(&self, gap: f64) -> [f64; 3] {
        let (k, e) = (self.stiffness, ONSET);
        if gap >= 0.0 {
            [0.0; 3]
        } else if gap > -e {
            let d = -gap;
            [k * d * d * d / (6.0 * e), -0.5 * k * d * d / e, k * d / e]
        } else {
            let firm = self.firmness(-gap);
            [
                0.5 * k * (gap * gap + e * gap + e * e / 3.0) + firm[0],
                k * (gap + 0.5 * e) + firm[1],
                k + firm[2],
            ]
        }
    }

    /// Normal force of a proximity, not negative \[N\].
    pub fn normal_force(&self, near: &Proximity) -> f64 {
        self.force(near.share, near.distance.value)
    }

    /// The same of a point with a share of the stiffness whose middle surface is at a distance \[m\].
    pub fn force(&self, share: f64, distance: f64) -> f64 {
        -share * self.psi(distance - self.offset)[1]
    }
}

/// Contact at a list of proximities.
pub struct Contact<'a> {
    /// The law.
    pub law: ContactLaw,
    /// The sheet.
    pub mesh: &'a Mesh,
    /// Obstacles by the proximities' index.
    pub obstacles: &'a [Obstacle],
    /// Where.
    pub proximities: &'a [Proximity],
}

impl Contact<'_> {
    fn at(&self, s: usize, x: &Nodes<3>) -> (Distance, [f64; 3]) {
        let near = &self.proximities[s];
        let point = weighted(&near.weights, x);
        let distance = self.obstacles[near.obstacle as usize].distance_to(near.part, &point);
        let psi = self.law.psi(distance.value - self.law.offset);
        (distance, psi.map(|v| v * near.share))
    }

    /// Second derivative of the distance at its minimum over the feature, which moves as the nodes do.
    fn distance_hessian(&self, s: usize, x: &Nodes<3>, distance: &Distance) -> SMatrix<f64, 9, 9> {
        let near = &self.proximities[s];
        let (n, curvature) = (distance.normal, distance.curvature);
        let mut hessian = SMatrix::<f64, 9, 9>::zeros();
        for i in 0..3 {
            for j in 0..3 {
                let block = curvature * (near.weights[i] * near.weights[j]);
                hessian
                    .fixed_view_mut::<3, 3>(3 * i, 3 * j)
                    .copy_from(&block);
            }
        }
        let slides = near.slides();
        let along = slides.map(|slide| weighted(&slide, x));
        let mixed = |a: usize| {
            let mut column = SMatrix::<f64, 9, 1>::zeros();
            for i in 0..3 {
                let part = n * slides[a][i] + curvature * along[a] * near.weights[i];
                column.fixed_rows_mut::<3>(3 * i).copy_from(&part);
            }
            column
        };
        let second = Matrix2::from_fn(|a, b| along[a].dot(&(curvature * along[b])));
        let (m0, m1) = (mixed(0), mixed(1));
        // How stiffly the minimum sits: along[.] has the size of an edge and curvature that of 1/distance.
        let floor = 1e-9 * along[0].norm();
        match near.freedom() {
            2 if second.determinant() > floor * second.trace() => {
                let inverse = second.try_inverse().unwrap_or_default();
                hessian -= m0 * m0.transpose() * inverse.m11 + m1 * m1.transpose() * inverse.m22;
                let cross = m0 * m1.transpose() * inverse.m12;
                hessian -= cross + cross.transpose();
            }
            1 if second.m11 > floor => hessian -= m0 * m0.transpose() / second.m11,
            _ => {}
        }
        hessian
    }

    fn matrix(&self, s: usize, x: &Nodes<3>) -> SMatrix<f64, 9, 9> {
        let (distance, psi) = self.at(s, x);
        let near = &self.proximities[s];
        let mut column = SMatrix::<f64, 9, 1>::zeros();
        for i in 0..3 {
            column
                .fixed_rows_mut::<3>(3 * i)
                .copy_from(&(distance.normal * near.weights[i]));
        }
        self.distance_hessian(s, x, &distance) * psi[1] + column * column.transpose() * psi[2]
    }
}

fn blocks(matrix: &SMatrix<f64, 9, 9>) -> Hessian<3> {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| matrix.fixed_view::<3, 3>(3 * i, 3 * j).into_owned())
    })
}

/// The point with barycentric `weights` of a face.
pub fn weighted(weights: &[f64; 3], x: &Nodes<3>) -> Vector3<f64> {
    x[0] * weights[0] + x[1] * weights[1] + x[2] * weights[2]
}

/// Spreads a 3 x 3 matrix at a point of a face over its corners.
pub fn spread(weights: &[f64; 3], matrix: &Matrix3<f64>) -> Hessian<3> {
    std::array::from_fn(|i| std::array::from_fn(|j| matrix * (weights[i] * weights[j])))
}

impl Potential<3> for Contact<'_> {
    fn count(&self) -> usize {
        self.proximities.len()
    }

    fn nodes(&self, s: usize) -> [u32; 3] {
        self.mesh.faces[self.proximities[s].face as usize]
    }

    fn value(&self, s: usize, x: &Nodes<3>) -> f64 {
        self.at(s, x).1[0]
    }

    fn gradient(&self, s: usize, x: &Nodes<3>) -> Gradient<3> {
        let (distance, psi) = self.at(s, x);
        self.proximities[s]
            .weights
            .map(|w| distance.normal * (w * psi[1]))
    }

    fn hessian(&self, s: usize, x: &Nodes<3>) -> Hessian<3> {
        blocks(&self.matrix(s, x))
    }

    fn hessian_projected(&self, s: usize, x: &Nodes<3>) -> Hessian<3> {
        let mut eigen = self.matrix(s, x).symmetric_eigen();
        eigen.eigenvalues.apply(|v| *v = v.max(0.0));
        blocks(&eigen.recompose())
    }
}
