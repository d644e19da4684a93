//! A node in four lanes (x, y, z and a zero), and arithmetic on it.

use nalgebra::Vector3;

/// A node in four lanes; the last is zero.
pub type Lanes = [f64; 4];

/// Three components in four lanes.
pub fn lanes(v: &Vector3<f64>) -> Lanes {
    [v.x, v.y, v.z, 0.0]
}

/// The three components of four lanes.
pub fn vector(v: &Lanes) -> Vector3<f64> {
    Vector3::new(v[0], v[1], v[2])
}

/// a + b.
#[inline(always)]
pub fn add(a: Lanes, b: Lanes) -> Lanes {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]]
}

/// a - b.
#[inline(always)]
pub fn sub(a: Lanes, b: Lanes) -> Lanes {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]]
}

#[inline(always)]
pub fn scale(a: Lanes, s: f64) -> Lanes {
    [a[0] * s, a[1] * s, a[2] * s, a[3] * s]
}

#[inline(always)]
pub fn dot(a: Lanes, b: Lanes) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
