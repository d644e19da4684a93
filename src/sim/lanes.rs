//! A node in four lanes (x, y, z and a zero), and arithmetic on it.

use std::ops::{Index, IndexMut};

use nalgebra::Vector3;

/// A node in four lanes; the last is zero. It stands in memory where a vector unit loads it at once: across the end of a
/// cache line, where an allocator may put every other one, that takes twice as long.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct Lanes(pub [f64; 4]);

impl Index<usize> for Lanes {
    type Output = f64;

    #[inline(always)]
    fn index(&self, lane: usize) -> &f64 {
        &self.0[lane]
    }
}

impl IndexMut<usize> for Lanes {
    #[inline(always)]
    fn index_mut(&mut self, lane: usize) -> &mut f64 {
        &mut self.0[lane]
    }
}

/// Nothing in each lane.
pub const ZERO: Lanes = Lanes([0.0; 4]);

/// Three components in four lanes.
pub fn lanes(v: &Vector3<f64>) -> Lanes {
    Lanes([v.x, v.y, v.z, 0.0])
}

/// The three components of four lanes.
pub fn vector(v: &Lanes) -> Vector3<f64> {
    Vector3::new(v[0], v[1], v[2])
}

/// The largest of the three components.
pub fn largest(v: &Lanes) -> f64 {
    v[0].max(v[1]).max(v[2])
}

/// Lane by lane.
#[inline(always)]
pub fn each(of: impl Fn(usize) -> f64) -> Lanes {
    Lanes([of(0), of(1), of(2), of(3)])
}

/// a + b.
#[inline(always)]
pub fn add(a: Lanes, b: Lanes) -> Lanes {
    each(|k| a[k] + b[k])
}

/// a - b.
#[inline(always)]
pub fn sub(a: Lanes, b: Lanes) -> Lanes {
    each(|k| a[k] - b[k])
}

#[inline(always)]
pub fn scale(a: Lanes, s: f64) -> Lanes {
    each(|k| a[k] * s)
}

#[inline(always)]
pub fn dot(a: Lanes, b: Lanes) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
