//! Boxes in the world, and deformation gradients near a mean.

use nalgebra::Vector3;

type Point = Vector3<f64>;

/// An axis-aligned box of the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub low: Point,
    pub high: Point,
}

impl Bounds {
    pub const EMPTY: Self = Self {
        low: Vector3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Vector3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    pub fn add(&mut self, p: &Point) {
        for k in 0..3 {
            self.low[k] = min(self.low[k], p[k]);
            self.high[k] = max(self.high[k], p[k]);
        }
    }

    pub fn join(&mut self, other: &Self) {
        for k in 0..3 {
            self.low[k] = min(self.low[k], other.low[k]);
            self.high[k] = max(self.high[k], other.high[k]);
        }
    }

    /// Distance, at least; the empty box is infinitely far from all.
    pub fn gap(&self, other: &Self) -> f64 {
        let apart = |k: usize| {
            let gap = max(self.low[k] - other.high[k], other.low[k] - self.high[k]);
            max(gap, 0.0)
        };
        let [x, y, z] = [0, 1, 2].map(apart);
        (x * x + y * y + z * z).sqrt()
    }

    /// Whether some axis alone keeps them `reach` apart; the empty box is apart from all.
    pub fn apart(&self, other: &Self, reach: f64) -> bool {
        // Without a branch for each: most are apart, no telling along which.
        let gap = |k: usize| max(self.low[k] - other.high[k], other.low[k] - self.high[k]);
        max(gap(0), max(gap(1), gap(2))) >= reach
    }
}

// `f64::min` cares for NaN, which costs time; what is not finite is found elsewhere.
pub(super) fn min(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

pub(super) fn max(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Deformation gradients that lie within a radius of a mean.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spread {
    pub mean: [Point; 2],
    pub radius: f64,
}

impl Spread {
    pub const NOTHING: Self = Self {
        mean: [Vector3::new(0.0, 0.0, 0.0); 2],
        radius: f64::NEG_INFINITY,
    };

    pub fn away(&self, mean: &[Point; 2]) -> f64 {
        let [a, b] = [self.mean[0] - mean[0], self.mean[1] - mean[1]];
        self.radius + (a.norm_squared() + b.norm_squared()).sqrt()
    }

    pub fn join(parts: &[Self]) -> Self {
        let count = parts.len() as f64;
        let mean = [0, 1].map(|k| parts.iter().map(|p| p.mean[k]).sum::<Point>() / count);
        let radius = parts.iter().map(|p| p.away(&mean)).fold(0.0, f64::max);
        Self { mean, radius }
    }

    /// Least stretch over the straight lines of the patch.
    pub fn least(&self) -> f64 {
        let [u, v] = &self.mean;
        let (a, b, c) = (u.norm_squared(), u.dot(v), v.norm_squared());
        let least = 0.5 * (a + c - ((a - c).powi(2) + 4.0 * b * b).sqrt());
        least.max(0.0).sqrt() - self.radius
    }
}
