#![doc = include_str!("doc.md")]

mod bond;
#[cfg(test)]
mod test;

use nalgebra::{Matrix2, Matrix3, SMatrix, Vector3};

use super::stencil::{Gradient, Hessian, Nodes, Potential};
use crate::contact::layers::Pair;

pub use bond::{LayerBond, LayerFriction};

/// Pressure scale of the compression law \[Pa\].
const PRESSURE: f64 = 1e4;
/// Part of a vertex's area that a pair stands for.
const PART: f64 = 0.25;
/// Distance over thickness below which the law is a parabola.
const FLOOR: f64 = 0.02;

/// The compression law of two layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerLaw {
    /// Distance of the middle surfaces at which layers touch \[m\].
    pub thickness: f64,
    /// Force scale of a pair \[N\].
    pub load: f64,
    /// Coefficient of friction of layer on layer \[-\].
    pub friction: f64,
}

impl LayerLaw {
    /// The law for a thickness \[m\], a mean area of vertices \[m²\] and a coefficient of friction.
    pub fn new(thickness: f64, area: f64, friction: f64) -> Self {
        Self {
            thickness,
            load: PRESSURE * PART * area,
            friction,
        }
    }

    /// psi, psi' and psi'' at a distance \[J, N, N/m\].
    pub fn psi(&self, distance: f64) -> [f64; 3] {
        let (h, s) = (self.thickness, distance / self.thickness);
        if s >= 1.0 {
            return [0.0; 3];
        }
        let at = s.max(FLOOR);
        let [value, first, second] = barrier(at);
        let below = s - at;
        [
            self.load * h * (value + below * (first + 0.5 * below * second)),
            self.load * (first + below * second),
            self.load / h * second,
        ]
    }

    /// Normal force of a pair, not negative where its share is not \[N\].
    pub fn normal_force(&self, pair: &Pair) -> f64 {
        -pair.share * self.psi(pair.distance)[1]
    }

    /// Tangential stiffness of a sticking pair \[N/m\].
    pub fn grip(&self) -> f64 {
        self.load / self.thickness
    }
}

/// beta and its derivatives.
fn barrier(s: f64) -> [f64; 3] {
    let (g, log) = (s - 1.0, s.ln());
    [
        -g * g * log,
        -2.0 * g * log - g * g / s,
        -2.0 * log - 4.0 * g / s + g * g / (s * s),
    ]
}

/// Layers that touch, at a list of pairs.
pub struct Layers<'a> {
    /// The law.
    pub law: LayerLaw,
    /// Where.
    pub pairs: &'a [Pair],
}

/// A pair at given positions.
struct At {
    weights: [f64; 4],
    distance: f64,
    normal: Vector3<f64>,
    psi: [f64; 3],
}

impl Layers<'_> {
    fn at(&self, s: usize, x: &Nodes<4>) -> At {
        let pair = &self.pairs[s];
        let weights = pair.weights_at(x);
        let offset = combine(&weights, x);
        let distance = offset.norm();
        At {
            weights,
            distance,
            normal: offset / distance,
            psi: self.law.psi(distance).map(|v| v * pair.share),
        }
    }

    fn matrix(&self, s: usize, x: &Nodes<4>) -> SMatrix<f64, 12, 12> {
        let at = self.at(s, x);
        let (w, n) = (at.weights, at.normal);
        let curvature = (Matrix3::identity() - n * n.transpose()) / at.distance;
        let mut hessian = outer(&w, &w, &(curvature * at.psi[1]));
        let (freedom, slides) = self.pairs[s].slides();
        let along = slides.map(|slide| combine(&slide, x));
        let mixed = |a: usize| {
            let mut column = SMatrix::<f64, 12, 1>::zeros();
            for i in 0..4 {
                let part = n * slides[a][i] + curvature * along[a] * w[i];
                column.fixed_rows_mut::<3>(3 * i).copy_from(&part);
            }
            column
        };
        let second = Matrix2::from_fn(|a, b| along[a].dot(&(curvature * along[b])));
        let (m0, m1) = (mixed(0), mixed(1));
        match freedom {
            0 => {}
            1 => hessian -= m0 * m0.transpose() * (at.psi[1] / second.m11),
            _ => {
                let inverse = second.try_inverse().unwrap_or_default() * at.psi[1];
                hessian -= m0 * m0.transpose() * inverse.m11 + m1 * m1.transpose() * inverse.m22;
                let cross = m0 * m1.transpose() * inverse.m12;
                hessian -= cross + cross.transpose();
            }
        }
        hessian + outer(&w, &w, &(n * n.transpose() * at.psi[2]))
    }
}

fn combine(weights: &[f64; 4], x: &Nodes<4>) -> Vector3<f64> {
    x[0] * weights[0] + x[1] * weights[1] + x[2] * weights[2] + x[3] * weights[3]
}

fn outer(a: &[f64; 4], b: &[f64; 4], matrix: &Matrix3<f64>) -> SMatrix<f64, 12, 12> {
    let mut out = SMatrix::<f64, 12, 12>::zeros();
    for i in 0..4 {
        for j in 0..4 {
            out.fixed_view_mut::<3, 3>(3 * i, 3 * j)
                .copy_from(&(matrix * (a[i] * b[j])));
        }
    }
    out
}

fn blocks(matrix: &SMatrix<f64, 12, 12>) -> Hessian<4> {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| matrix.fixed_view::<3, 3>(3 * i, 3 * j).into_owned())
    })
}

impl Potential<4> for Layers<'_> {
    fn count(&self) -> usize {
        self.pairs.len()
    }

    fn nodes(&self, s: usize) -> [u32; 4] {
        self.pairs[s].nodes
    }

    fn value(&self, s: usize, x: &Nodes<4>) -> f64 {
        self.at(s, x).psi[0]
    }

    fn gradient(&self, s: usize, x: &Nodes<4>) -> Gradient<4> {
        let at = self.at(s, x);
        at.weights.map(|w| at.normal * (w * at.psi[1]))
    }

    fn hessian(&self, s: usize, x: &Nodes<4>) -> Hessian<4> {
        blocks(&self.matrix(s, x))
    }

    fn hessian_projected(&self, s: usize, x: &Nodes<4>) -> Hessian<4> {
        let mut eigen = self.matrix(s, x).symmetric_eigen();
        eigen.eigenvalues.apply(|v| *v = v.max(0.0));
        blocks(&eigen.recompose())
    }
}
