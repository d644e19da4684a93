//! The pass over the faces, written once for all vector units.

use super::Faces;
use crate::sim::lanes::Lanes;
use crate::sim::wide::Wide;

/// One pass over the faces.
// No closures below: the compiler would not give them the vector unit's instructions.
pub struct Pass<'a, U> {
    unit: U,
    faces: &'a [Faces],
    nodes: &'a [Lanes],
    forces: &'a mut [Lanes],
}

/// x, y and z of four faces.
type Vectors<U> = [<U as Wide>::Numbers; 3];

impl<'a, U: Wide> Pass<'a, U> {
    pub fn new(unit: U, faces: &'a [Faces], nodes: &'a [Lanes], forces: &'a mut [Lanes]) -> Self {
        Self {
            unit,
            faces,
            nodes,
            forces,
        }
    }
}

impl<U: Wide> pulp::WithSimd for Pass<'_, U> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let u = self.unit;
        // Of one length, so that a bound is checked once.
        let count = self.nodes.len().min(self.forces.len());
        let (x, forces) = (&self.nodes[..count], &mut self.forces[..count]);
        for faces in self.faces {
            let [on_a, on_b, on_c, on_0, on_1, on_2] = &faces.nodes;
            let a = u.gather(x, on_a);
            let d1 = sub(u, u.gather(x, on_b), a);
            let d2 = sub(u, u.gather(x, on_c), a);
            let [s11, s22, s12] = stress(u, faces, &d1, &d2);
            let [[k01, k02], [k11, k12], [k21, k22]] = &faces.flat;
            let t0 = less(u, d2, k02, less(u, d1, k01, u.gather(x, on_0)));
            let t1 = less(u, d2, k12, less(u, d1, k11, u.gather(x, on_1)));
            let t2 = less(u, d2, k22, less(u, d1, k21, u.gather(x, on_2)));
            let [w00, w11, w22, w12, w02, w01] = &faces.bending;
            let m0 = plus(u, t2, w02, plus(u, t1, w01, times(u, t0, w00)));
            let m1 = plus(u, t2, w12, plus(u, t1, w11, times(u, t0, w01)));
            let m2 = plus(u, t2, w22, plus(u, t1, w12, times(u, t0, w02)));
            // Forces on corners 1 and 2, against the energy's derivative by d_1 and d_2.
            let f1 = plus(u, m2, k21, plus(u, m1, k11, times(u, m0, k01)));
            let f1 = pulled(u, d2, s12, pulled(u, d1, s11, f1));
            let f2 = plus(u, m2, k22, plus(u, m1, k12, times(u, m0, k02)));
            let f2 = pulled(u, d2, s22, pulled(u, d1, s12, f2));
            let zero = u.load(&[0.0; 4]);
            let none = [zero, zero, zero];
            u.scatter(sub(u, sub(u, none, f1), f2), forces, on_a);
            u.scatter(f1, forces, on_b);
            u.scatter(f2, forces, on_c);
            u.scatter(sub(u, none, m0), forces, on_0);
            u.scatter(sub(u, none, m1), forces, on_1);
            u.scatter(sub(u, none, m2), forces, on_2);
        }
    }
}

/// Derivative of the membrane energy by the strains along the sides 11, 22, 12 \[N/m\].
#[inline(always)]
fn stress<U: Wide>(u: U, faces: &Faces, d1: &Vectors<U>, d2: &Vectors<U>) -> Vectors<U> {
    let [l11, l22, l12] = &faces.rest;
    let half = u.load(&[0.5; 4]);
    let e11 = u.times(half, u.sub(dot(u, d1, d1), u.load(l11)));
    let e22 = u.times(half, u.sub(dot(u, d2, d2), u.load(l22)));
    let e12 = u.sub(dot(u, d1, d2), u.load(l12));
    let [q11, q22, q33, q12, q23, q13] = &faces.membrane;
    let (q12, q23, q13) = (u.load(q12), u.load(q23), u.load(q13));
    [
        u.plus(q13, e12, u.plus(q12, e22, u.times(u.load(q11), e11))),
        u.plus(q23, e12, u.plus(u.load(q22), e22, u.times(q12, e11))),
        u.plus(u.load(q33), e12, u.plus(q23, e22, u.times(q13, e11))),
    ]
}

#[inline(always)]
fn dot<U: Wide>(u: U, a: &Vectors<U>, b: &Vectors<U>) -> U::Numbers {
    u.plus(a[2], b[2], u.plus(a[1], b[1], u.times(a[0], b[0])))
}

#[inline(always)]
fn sub<U: Wide>(u: U, a: Vectors<U>, b: Vectors<U>) -> Vectors<U> {
    [u.sub(a[0], b[0]), u.sub(a[1], b[1]), u.sub(a[2], b[2])]
}

#[inline(always)]
fn times<U: Wide>(u: U, a: Vectors<U>, s: &[f64; 4]) -> Vectors<U> {
    let s = u.load(s);
    [u.times(a[0], s), u.times(a[1], s), u.times(a[2], s)]
}

/// a s + b.
#[inline(always)]
fn plus<U: Wide>(u: U, a: Vectors<U>, s: &[f64; 4], b: Vectors<U>) -> Vectors<U> {
    let s = u.load(s);
    [
        u.plus(a[0], s, b[0]),
        u.plus(a[1], s, b[1]),
        u.plus(a[2], s, b[2]),
    ]
}

/// b - a s.
#[inline(always)]
fn less<U: Wide>(u: U, a: Vectors<U>, s: &[f64; 4], b: Vectors<U>) -> Vectors<U> {
    pulled(u, a, u.load(s), b)
}

/// b - a s.
#[inline(always)]
fn pulled<U: Wide>(u: U, a: Vectors<U>, s: U::Numbers, b: Vectors<U>) -> Vectors<U> {
    [
        u.less(a[0], s, b[0]),
        u.less(a[1], s, b[1]),
        u.less(a[2], s, b[2]),
    ]
}
