//! Arithmetic on four faces at once, by the vector unit that the processor has.
//!
//! A unit may fuse a product with a sum, so bits depend on the processor.

#[cfg(target_arch = "x86_64")]
mod avx;

use super::lanes::Lanes;

/// A vector unit for four numbers, one of each face.
pub trait Wide: Copy {
    /// The numbers in a register.
    type Numbers: Copy;
    /// From memory.
    fn load(self, a: &[f64; 4]) -> Self::Numbers;
    /// a - b.
    fn sub(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// a b.
    fn times(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// a b + c.
    fn plus(self, a: Self::Numbers, b: Self::Numbers, c: Self::Numbers) -> Self::Numbers;
    /// c - a b.
    fn less(self, a: Self::Numbers, b: Self::Numbers, c: Self::Numbers) -> Self::Numbers;
    /// x, y and z of four nodes.
    fn gather(self, nodes: &[Lanes], at: &[u32; 4]) -> [Self::Numbers; 3];
    /// Adds x, y and z to one node after the other.
    fn scatter(self, x: [Self::Numbers; 3], nodes: &mut [Lanes], at: &[u32; 4]);
}

/// Whatever the compiler makes of it.
#[derive(Clone, Copy)]
pub struct Plain;

#[inline(always)]
fn each(f: impl Fn(usize) -> f64) -> [f64; 4] {
    [f(0), f(1), f(2), f(3)]
}

impl Wide for Plain {
    type Numbers = [f64; 4];

    #[inline(always)]
    fn load(self, a: &[f64; 4]) -> [f64; 4] {
        *a
    }

    #[inline(always)]
    fn sub(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        each(|i| a[i] - b[i])
    }

    #[inline(always)]
    fn times(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        each(|i| a[i] * b[i])
    }

    #[inline(always)]
    fn plus(self, a: [f64; 4], b: [f64; 4], c: [f64; 4]) -> [f64; 4] {
        each(|i| a[i] * b[i] + c[i])
    }

    #[inline(always)]
    fn less(self, a: [f64; 4], b: [f64; 4], c: [f64; 4]) -> [f64; 4] {
        each(|i| c[i] - a[i] * b[i])
    }

    #[inline(always)]
    fn gather(self, nodes: &[Lanes], at: &[u32; 4]) -> [[f64; 4]; 3] {
        [0, 1, 2].map(|k| each(|i| nodes[at[i] as usize][k]))
    }

    #[inline(always)]
    fn scatter(self, x: [[f64; 4]; 3], nodes: &mut [Lanes], at: &[u32; 4]) {
        for (i, &n) in at.iter().enumerate() {
            for k in 0..3 {
                nodes[n as usize][k] += x[k][i];
            }
        }
    }
}
