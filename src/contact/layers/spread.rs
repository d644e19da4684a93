//! Deformation gradients of a part of the sheet, and how far apart they keep its points.
//!
//! Let R be two orthonormal vectors and F the gradients along a straight line of the flat sheet from P to Q, d its
//! direction. The integral of `R d . F d` along it is `R d . (x(Q) - x(P))`, and `R d` is of length 1: so if
//! `R d . F d >= m` for every F and every d of length 1, the points are at least `m |P - Q|` apart. With R in the mean
//! plane of the part, cloth that bends by an angle a to either side of it has m = cos(a): what is across the plane does
//! not count. While the sheet moves straight, `R d . F d` changes evenly: gradients at both ends of the way tell for all of
//! it.

use nalgebra::Vector3;

use super::bounds::{max, min};

type Point = Vector3<f64>;

/// Two by three: where the axes of the flat sheet go.
pub(super) type Gradient = [Point; 2];

/// Share of its square that the area of a mean must have for a plane to be told.
const FLATTEST: f64 = 1e-6;

/// The plane of a gradient, and the rotation into it that is nearest to the gradient.
#[derive(Clone, Copy, Debug)]
struct Plane {
    axes: Gradient,
    normal: Point,
}

impl Plane {
    /// Nothing where the gradient has none, or is no number.
    fn of([u, v]: &Gradient) -> Option<Self> {
        let (a, b, c) = (u.norm_squared(), u.dot(v), v.norm_squared());
        let square = a * c - b * b;
        if square.is_nan() || square <= FLATTEST * (a + c) * (a + c) {
            return None;
        }
        // The gradient times the inverse root of `C = F^T F`, whose root is `(C + area) / sqrt(tr C + 2 area)`.
        let area = square.sqrt();
        let inverse = 1.0 / (area * (a + c + 2.0 * area).sqrt());
        let axes = [
            (u * (c + area) - v * b) * inverse,
            (v * (a + area) - u * b) * inverse,
        ];
        let normal = axes[0].cross(&axes[1]);
        Some(Self { axes, normal })
    }

    /// Square of what of a gradient is in the plane, and across it.
    #[inline]
    fn squares(&self, [u, v]: &Gradient) -> [f64; 2] {
        let [a, b] = &self.axes;
        let along = [a.dot(u), a.dot(v), b.dot(u), b.dot(v)];
        let across = [self.normal.dot(u), self.normal.dot(v)];
        let square = |[x, y]: [f64; 2]| x * x + y * y;
        let [p, q, r, s] = along;
        [square([p, q]) + square([r, s]), square(across)]
    }
}

/// Deformation gradients near a mean.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spread {
    mean: Gradient,
    plane: Plane,
    /// The most by which one differs from the mean along the plane, and across it.
    along: f64,
    across: f64,
}

impl Spread {
    /// Of some gradients and their mean; nothing if that has no plane.
    pub fn of<'a>(mean: Gradient, gradients: impl Iterator<Item = &'a Gradient>) -> Option<Self> {
        let plane = Plane::of(&mean)?;
        let (mut along, mut across) = (0.0, 0.0);
        for g in gradients {
            let squares = plane.squares(&[g[0] - mean[0], g[1] - mean[1]]);
            (along, across) = (max(squares[0], along), max(squares[1], across));
        }
        let [along, across] = [along, across].map(f64::sqrt);
        Some(Self {
            mean,
            plane,
            along,
            across,
        })
    }

    /// Least stretch over the straight lines of a part of the sheet with such gradients; negative if nothing is known.
    pub fn least(parts: &[Option<&Self>]) -> f64 {
        let Some(plane) = Plane::of(&mean(parts)) else {
            return -1.0;
        };
        let [r, s] = &plane.axes;
        let least = |part: &&Self| {
            let [u, v] = &part.mean;
            let (a, b, c) = (r.dot(u), 0.5 * (r.dot(v) + s.dot(u)), s.dot(v));
            let half = 0.5 * (a - c);
            let stretch = 0.5 * (a + c) - (half * half + b * b).sqrt();
            stretch - part.along - part.plane.normal.cross(&plane.normal).norm() * part.across
        };
        let parts = parts.iter().flatten();
        parts.map(least).fold(f64::INFINITY, min)
    }
}

fn mean(parts: &[Option<&Spread>]) -> Gradient {
    let part = 1.0 / parts.len() as f64;
    let mut sum = [Point::zeros(); 2];
    for part in parts.iter().flatten() {
        sum = [0, 1].map(|k| sum[k] + part.mean[k]);
    }
    sum.map(|s| s * part)
}
