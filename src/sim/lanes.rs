//! A node in four lanes (x, y, z and a zero), and arithmetic on it by the vector unit that the processor has. All units
//! give the same bits: none fuses a product with a sum.

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

/// A vector unit for four lanes.
pub trait Four: Copy {
    /// Four lanes in its registers.
    type Vector: Copy;
    /// From memory.
    fn load(self, a: &Lanes) -> Self::Vector;
    /// To memory.
    fn store(self, a: Self::Vector) -> Lanes;
    /// a + b.
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// a - b.
    fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// a s.
    fn scale(self, a: Self::Vector, s: f64) -> Self::Vector;
    /// a s + b.
    #[inline(always)]
    fn plus(self, a: Self::Vector, s: f64, b: Self::Vector) -> Self::Vector {
        self.add(self.scale(a, s), b)
    }
    /// a · b.
    fn dot(self, a: Self::Vector, b: Self::Vector) -> f64;
}

/// Whatever the compiler makes of it.
#[derive(Clone, Copy)]
pub struct Plain;

impl Four for Plain {
    type Vector = Lanes;

    #[inline(always)]
    fn load(self, a: &Lanes) -> Lanes {
        *a
    }

    #[inline(always)]
    fn store(self, a: Lanes) -> Lanes {
        a
    }

    #[inline(always)]
    fn add(self, a: Lanes, b: Lanes) -> Lanes {
        add(a, b)
    }

    #[inline(always)]
    fn sub(self, a: Lanes, b: Lanes) -> Lanes {
        sub(a, b)
    }

    #[inline(always)]
    fn scale(self, a: Lanes, s: f64) -> Lanes {
        scale(a, s)
    }

    #[inline(always)]
    fn dot(self, a: Lanes, b: Lanes) -> f64 {
        dot(a, b)
    }
}

/// AVX: one register. Left to itself the compiler shuffles lanes between registers.
#[cfg(target_arch = "x86_64")]
impl Four for pulp::x86::V3 {
    type Vector = pulp::f64x4;

    #[inline(always)]
    fn load(self, a: &Lanes) -> pulp::f64x4 {
        pulp::cast(*a)
    }

    #[inline(always)]
    fn store(self, a: pulp::f64x4) -> Lanes {
        pulp::cast(a)
    }

    #[inline(always)]
    fn add(self, a: pulp::f64x4, b: pulp::f64x4) -> pulp::f64x4 {
        pulp::cast(self.avx._mm256_add_pd(pulp::cast(a), pulp::cast(b)))
    }

    #[inline(always)]
    fn sub(self, a: pulp::f64x4, b: pulp::f64x4) -> pulp::f64x4 {
        pulp::cast(self.avx._mm256_sub_pd(pulp::cast(a), pulp::cast(b)))
    }

    #[inline(always)]
    fn scale(self, a: pulp::f64x4, s: f64) -> pulp::f64x4 {
        let s = self.avx._mm256_set1_pd(s);
        pulp::cast(self.avx._mm256_mul_pd(pulp::cast(a), s))
    }

    #[inline(always)]
    fn dot(self, a: pulp::f64x4, b: pulp::f64x4) -> f64 {
        let product: Lanes = pulp::cast(self.avx._mm256_mul_pd(pulp::cast(a), pulp::cast(b)));
        product[0] + product[1] + product[2]
    }
}
