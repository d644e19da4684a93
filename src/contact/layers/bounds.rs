//! Boxes in the world.

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
}

/// Whether some axis alone keeps two parts of the sheet `reach` apart while they move straight through the moments at which
/// each has these boxes, however far they move together; the empty box is apart from all.
#[inline]
pub(super) fn apart<const M: usize>(boxes: [[&Bounds; 2]; M], reach: f64) -> bool {
    // Without a branch for each: most are apart, no telling along which.
    let gap = |k: usize| {
        let (mut before, mut behind) = (f64::INFINITY, f64::INFINITY);
        for [a, b] in boxes {
            before = min(b.low[k] - a.high[k], before);
            behind = min(a.low[k] - b.high[k], behind);
        }
        max(before, behind)
    };
    max(gap(0), max(gap(1), gap(2))) >= reach
}

// `f64::min` cares for NaN, which costs time; what is not finite is found elsewhere.
pub(super) fn min(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

pub(super) fn max(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
