//! The derivative suite that every potential must pass, after conspire's `constitutive_model_test_utilities`.
//!
//! Differences are taken over a sweep of steps: the error must fall as the step squared, reach a small floor,
//! and rise again when rounding takes over. A single step would pass a derivative that is off by a per mille.

use nalgebra::{DMatrix, DVector, Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::stencil::{Gradient, Hessian, Load, Nodes, Potential};

/// Difference steps over the stencil's length: half a decade apart, 3e-2 down to 1e-11.
const STEPS: i32 = 20;
/// Relative error that some step must reach: rounding and truncation meet between 1e-11 and 1e-9.
const FLOOR: f64 = 2e-8;
/// An error above this at the largest step counts as truncation, whose order can be read.
const READABLE: f64 = 1e-6;

/// Fixed-seed random numbers.
pub struct Chance(Pcg64);

impl Chance {
    /// The same numbers for the same seed.
    pub fn new(seed: u64) -> Self {
        Self(Pcg64::seed_from_u64(seed))
    }

    /// Even between `low` and `high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        let unit: f64 = self.0.random();
        low + (high - low) * unit
    }

    /// In the cube of half size `size`.
    pub fn vector(&mut self, size: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.between(-size, size))
    }

    /// Nodes in that cube.
    pub fn nodes<const N: usize>(&mut self, size: f64) -> Nodes<N> {
        std::array::from_fn(|_| self.vector(size))
    }

    /// Any rotation.
    pub fn rotation(&mut self) -> Rotation3<f64> {
        Rotation3::new(self.vector(3.0))
    }
}

/// Gradient and Hessian of stencil `s` at `x` against differences, symmetry, projection. `length` is what the
/// smallest feature of the stencil measures: steps are fractions of it.
pub fn derivatives<const N: usize>(
    term: &impl Potential<N>,
    s: usize,
    x: &Nodes<N>,
    length: f64,
    name: &str,
) {
    against(term, term, s, x, length, name);
    projection(&term.hessian(s, x), &term.hessian_projected(s, x), name);
}

/// Gradient and Hessian of `term` against differences of `reference`, which may be the same energy computed
/// in another way.
pub fn against<const N: usize>(
    term: &impl Potential<N>,
    reference: &impl Potential<N>,
    s: usize,
    x: &Nodes<N>,
    length: f64,
    name: &str,
) {
    let mut chance = Chance::new(7);
    let (gradient, hessian) = (flat(&term.gradient(s, x)), dense(&term.hessian(s, x)));
    // Forces are measured against those that a move by `length` makes, so that an energy with no force at x
    // has a scale too.
    let force = gradient.norm().max(hessian.norm() * length);
    for _ in 0..3 {
        let way: Nodes<N> = chance.nodes(1.0);
        let direction = flat(&way);
        let at = |step: f64| -> Nodes<N> { std::array::from_fn(|k| x[k] + way[k] * step) };
        let slope = gradient.dot(&direction);
        sweep(length, &format!("{name}: gradient"), |step| {
            let difference = reference.value(s, &at(step)) - reference.value(s, &at(-step));
            (difference / (2.0 * step) - slope).abs() / force
        });
        if hessian.norm() == 0.0 {
            assert_eq!(flat(&reference.gradient(s, &at(length))), gradient);
            continue;
        }
        let turn = &hessian * &direction;
        sweep(length, &format!("{name}: Hessian"), |step| {
            let [ahead, behind] = [step, -step].map(|h| flat(&reference.gradient(s, &at(h))));
            ((ahead - behind) / (2.0 * step) - &turn).norm() / hessian.norm()
        });
    }
}

/// Both derivatives of a load against differences of its force. Steps are fractions of `length` and `speed`.
pub fn load<const N: usize>(
    term: &impl Load<N>,
    s: usize,
    (x, v): (&Nodes<N>, &Nodes<N>),
    (length, speed): (f64, f64),
    name: &str,
) {
    let mut chance = Chance::new(8);
    let [by_place, by_rate] =
        [term.by_position(s, x, v), term.by_velocity(s, x, v)].map(|m| dense(&m));
    for _ in 0..3 {
        let way: Nodes<N> = chance.nodes(1.0);
        let at = |from: &Nodes<N>, step: f64| -> Nodes<N> {
            std::array::from_fn(|k| from[k] + way[k] * step)
        };
        let place = &by_place * flat(&way);
        if by_place.norm() == 0.0 {
            assert_eq!(term.force(s, &at(x, length), v), term.force(s, x, v));
        } else {
            sweep(length, &format!("{name}: by position"), |step| {
                let [ahead, behind] = [step, -step].map(|h| flat(&term.force(s, &at(x, h), v)));
                ((ahead - behind) / (2.0 * step) - &place).norm() / by_place.norm()
            });
        }
        let rate = &by_rate * flat(&way);
        sweep(speed, &format!("{name}: by velocity"), |step| {
            let [ahead, behind] = [step, -step].map(|h| flat(&term.force(s, x, &at(v, h))));
            ((ahead - behind) / (2.0 * step) - &rate).norm() / by_rate.norm()
        });
    }
}

/// Asserts second order, floor and rise of an error over difference steps.
fn sweep(length: f64, name: &str, error: impl Fn(f64) -> f64) {
    let steps: Vec<f64> = (3..3 + STEPS)
        .map(|k| length * 10f64.powf(-0.5 * f64::from(k)))
        .collect();
    let errors: Vec<f64> = steps.iter().map(|&step| error(step)).collect();
    let shown: String = errors.iter().map(|e| format!(" {e:.1e}")).collect();
    let floor = errors.iter().fold(f64::INFINITY, |m, &e| m.min(e));
    assert!(floor < FLOOR, "{name}: floor {floor:.1e} of {shown}");
    // Two decades of error over one of step; the second step keeps clear of terms of fourth order.
    if errors[1] > READABLE {
        let order = (errors[1] / errors[3]).log10();
        assert!((order - 2.0).abs() < 0.1, "{name}: order {order:.2}");
    } else {
        assert!(errors[0] < 20.0 * READABLE, "{name}: {shown}");
    }
    let last = errors[errors.len() - 1];
    assert!(last > floor, "{name}: no rounding at the end: {shown}");
}

/// Symmetry of the Hessian; its projection positive semidefinite, and equal to it if it is so already.
pub fn projection<const N: usize>(exact: &Hessian<N>, projected: &Hessian<N>, name: &str) {
    let (exact, projected) = (dense(exact), dense(projected));
    let size = exact.norm().max(projected.norm());
    for matrix in [&exact, &projected] {
        let skew = (matrix - matrix.transpose()).norm();
        assert!(skew <= 1e-13 * size, "{name}: not symmetric by {skew:.1e}");
    }
    let least = |matrix: &DMatrix<f64>| matrix.symmetric_eigenvalues().min();
    assert!(
        least(&projected) >= -1e-12 * size,
        "{name}: projection has the eigenvalue {:.1e}",
        least(&projected)
    );
    if least(&exact) >= -1e-13 * size {
        let apart = (&exact - &projected).norm();
        assert!(
            apart <= 1e-10 * size,
            "{name}: needless projection {apart:.1e}"
        );
    }
}

/// The value does not change in a rigid motion and the gradient turns with it; the first `positions` nodes
/// are places, the others directions.
pub fn rigid_motion<const N: usize>(
    term: &impl Potential<N>,
    s: usize,
    x: &Nodes<N>,
    positions: usize,
    name: &str,
) {
    let mut chance = Chance::new(11);
    for _ in 0..5 {
        let (turn, shift) = (chance.rotation(), chance.vector(0.1));
        let moved = std::array::from_fn(|k| {
            let shift = if k < positions {
                shift
            } else {
                Vector3::zeros()
            };
            turn * x[k] + shift
        });
        let (value, again) = (term.value(s, x), term.value(s, &moved));
        assert!(
            (value - again).abs() <= 1e-10 * value.abs(),
            "{name}: value {value:e} became {again:e}"
        );
        let (before, after) = (term.gradient(s, x), term.gradient(s, &moved));
        for k in 0..N {
            let off = (turn * before[k] - after[k]).norm();
            let size = flat(&before).norm();
            assert!(off <= 1e-9 * size, "{name}: gradient off by {off:e}");
        }
    }
}

/// Value and gradient vanish at rest, to the rounding of those of a strained state.
pub fn rest<const N: usize>(
    term: &impl Potential<N>,
    s: usize,
    x: &Nodes<N>,
    strained: &Nodes<N>,
    name: &str,
) {
    let (energy, force) = (term.value(s, strained), flat(&term.gradient(s, strained)));
    let (value, gradient) = (term.value(s, x), flat(&term.gradient(s, x)));
    assert!(value.abs() <= 1e-14 * energy, "{name}: {value:e} at rest");
    assert!(
        gradient.norm() <= 1e-12 * force.norm(),
        "{name}: force {:e} at rest",
        gradient.norm()
    );
}

pub fn flat<const N: usize>(nodes: &Gradient<N>) -> DVector<f64> {
    DVector::from_iterator(3 * N, nodes.iter().flat_map(|v| v.iter().copied()))
}

pub fn dense<const N: usize>(blocks: &Hessian<N>) -> DMatrix<f64> {
    DMatrix::from_fn(3 * N, 3 * N, |i, j| blocks[i / 3][j / 3][(i % 3, j % 3)])
}
