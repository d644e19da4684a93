//! The vector unit of x86-64.

use pulp::x86::V3;
use pulp::{cast, f64x4};

use super::Wide;
use crate::sim::lanes::Lanes;

/// AVX2.
impl Wide for V3 {
    type Numbers = f64x4;

    #[inline(always)]
    fn load(self, a: &[f64; 4]) -> f64x4 {
        cast(*a)
    }

    #[inline(always)]
    fn sub(self, a: f64x4, b: f64x4) -> f64x4 {
        cast(self.avx._mm256_sub_pd(cast(a), cast(b)))
    }

    #[inline(always)]
    fn times(self, a: f64x4, b: f64x4) -> f64x4 {
        cast(self.avx._mm256_mul_pd(cast(a), cast(b)))
    }

    #[inline(always)]
    fn plus(self, a: f64x4, b: f64x4, c: f64x4) -> f64x4 {
        let fma = self.fma;
        cast(fma._mm256_fmadd_pd(cast(a), cast(b), cast(c)))
    }

    #[inline(always)]
    fn less(self, a: f64x4, b: f64x4, c: f64x4) -> f64x4 {
        let fma = self.fma;
        cast(fma._mm256_fnmadd_pd(cast(a), cast(b), cast(c)))
    }

    #[inline(always)]
    fn gather(self, nodes: &[Lanes], at: &[u32; 4]) -> [f64x4; 3] {
        let avx = self.avx;
        let (a, b) = (nodes[at[0] as usize], nodes[at[1] as usize]);
        let (c, d) = (nodes[at[2] as usize], nodes[at[3] as usize]);
        let (a, b, c, d) = (cast(a.0), cast(b.0), cast(c.0), cast(d.0));
        let (xz_ab, y_ab) = (avx._mm256_unpacklo_pd(a, b), avx._mm256_unpackhi_pd(a, b));
        let (xz_cd, y_cd) = (avx._mm256_unpacklo_pd(c, d), avx._mm256_unpackhi_pd(c, d));
        [
            cast(avx._mm256_permute2f128_pd::<0x20>(xz_ab, xz_cd)),
            cast(avx._mm256_permute2f128_pd::<0x20>(y_ab, y_cd)),
            cast(avx._mm256_permute2f128_pd::<0x31>(xz_ab, xz_cd)),
        ]
    }

    #[inline(always)]
    fn scatter(self, x: [f64x4; 3], nodes: &mut [Lanes], at: &[u32; 4]) {
        let avx = self.avx;
        let (x, y, z) = (cast(x[0]), cast(x[1]), cast(x[2]));
        let zero = avx._mm256_setzero_pd();
        let (xy_02, xy_13) = (avx._mm256_unpacklo_pd(x, y), avx._mm256_unpackhi_pd(x, y));
        let (z_02, z_13) = (
            avx._mm256_unpacklo_pd(z, zero),
            avx._mm256_unpackhi_pd(z, zero),
        );
        let x0 = avx._mm256_permute2f128_pd::<0x20>(xy_02, z_02);
        let x1 = avx._mm256_permute2f128_pd::<0x20>(xy_13, z_13);
        let x2 = avx._mm256_permute2f128_pd::<0x31>(xy_02, z_02);
        let x3 = avx._mm256_permute2f128_pd::<0x31>(xy_13, z_13);
        let (p, q) = (at[0] as usize, at[1] as usize);
        let (r, s) = (at[2] as usize, at[3] as usize);
        nodes[p].0 = cast(avx._mm256_add_pd(cast(nodes[p].0), x0));
        nodes[q].0 = cast(avx._mm256_add_pd(cast(nodes[q].0), x1));
        nodes[r].0 = cast(avx._mm256_add_pd(cast(nodes[r].0), x2));
        nodes[s].0 = cast(avx._mm256_add_pd(cast(nodes[s].0), x3));
    }
}
