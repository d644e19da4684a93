//! The estimate of a mesh's error, on courses whose order, noise and limit are known.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use toile::chart::mesh_error::{MeshError, OnMesh, apart, error_of_change};

const DOUBLED: [usize; 5] = [500, 1000, 2000, 4000, 8000];
const MOMENTS: usize = 20;

/// Courses of two readings on meshes of so many triangles, and the course that they tend to. The error falls with an
/// order of the element size; `noise` is over what the last refinement changes.
struct Tending {
    triangles: Vec<usize>,
    courses: Vec<Vec<Vec<f64>>>,
    limit: Vec<Vec<f64>>,
}

impl Tending {
    fn new(triangles: &[usize], order: f64, noise: f64, seed: u64) -> Self {
        let mut random = Pcg64::seed_from_u64(seed);
        let mut draw = || 2.0 * random.random::<f64>() - 1.0;
        let phase = [draw(), draw()];
        let course = |of: &mut dyn FnMut(f64) -> f64| -> Vec<Vec<f64>> {
            let row = |m| phase.map(|p| of(m as f64 / MOMENTS as f64 + p)).to_vec();
            (1..=MOMENTS).map(row).collect()
        };
        let limit = course(&mut |t| -1.0 - t * t);
        let courses = triangles.iter().map(|n| {
            let error = 1e-4 * (*n as f64 / 500.0).powf(-0.5 * order);
            let changed = error * (2f64.powf(0.5 * order) - 1.0);
            let off = course(&mut |t| error * (5.0 * t).sin() + noise * changed * draw());
            let both = limit.iter().flatten().zip(off.iter().flatten());
            let sum: Vec<f64> = both.map(|(a, b)| a + b).collect();
            sum.chunks(2).map(<[f64]>::to_vec).collect()
        });
        Self {
            courses: courses.collect(),
            triangles: triangles.to_vec(),
            limit,
        }
    }

    fn meshes(&self) -> Vec<OnMesh<'_>> {
        let all = self.triangles.iter().zip(&self.courses);
        all.map(|(&triangles, readings)| OnMesh {
            triangles,
            readings,
        })
        .collect()
    }

    /// The estimate, and the true error.
    fn both(&self) -> (MeshError, f64) {
        let truth = apart(self.courses.last().unwrap(), &self.limit);
        (MeshError::of(&self.meshes()).unwrap(), truth)
    }
}

#[test]
fn verify_the_error_is_bounded_and_the_order_found_where_it_falls_regularly() {
    for order in [0.5, 0.7, 1.0, 1.5, 2.0, 2.65, 4.0] {
        for seed in 0..20 {
            let noise = if seed > 0 && order > 0.5 { 0.1 } else { 0.0 };
            for count in 3..=DOUBLED.len() {
                let made = Tending::new(&DOUBLED[..count], order, noise, seed);
                let (estimate, truth) = made.both();
                let what =
                    format!("order {order}, noise {noise}, seed {seed}: {estimate:?}, {truth}");
                // Beyond order 3 the safety is that of two meshes, and order 2 is believed where 4 is true.
                let most = if order > 3.0 {
                    9.0 * (1.0 + 4.0 * noise)
                } else if order > 2.0 {
                    4.0 * (1.0 + 3.0 * noise)
                } else {
                    2.0 * (1.0 + 2.0 * noise)
                };
                assert!((0.999..=most).contains(&(estimate.error / truth)), "{what}");
                let found = estimate.order.unwrap_or_else(|| panic!("{what}"));
                assert!(
                    (found - order.min(2.0)).abs() <= 1e-6 + 3.0 * noise,
                    "{what}"
                );
            }
        }
    }
}

/// Meshes need not be doubled.
#[test]
fn verify_the_order_is_found_on_any_sizes() {
    for order in [0.8, 1.3, 1.9] {
        let made = Tending::new(&[1000, 1500, 3300, 5100], order, 0.0, 7);
        let (estimate, truth) = made.both();
        assert!(
            (estimate.order.unwrap() - order).abs() < 1e-6,
            "{estimate:?}"
        );
        assert!((estimate.error / truth - 1.25).abs() < 1e-3, "{estimate:?}");
        let finer = Tending::new(&[5100, 15_300], order, 0.0, 7);
        let changed =
            apart(&finer.courses[0], &finer.limit) / apart(&finer.courses[0], &finer.courses[1]);
        let told = error_of_change(3.0, estimate.order);
        assert!((told / changed - 1.0).abs() < 1e-2, "{told} of {changed}");
    }
}

/// Random meshes: no order can be measured, or a wrong one; the error is bounded all the same.
#[test]
fn verify_noise_is_bounded() {
    for seed in 0..200 {
        let made = Tending::new(&DOUBLED[..3 + seed as usize % 3], 2.0, 3.0, seed);
        let (estimate, truth) = made.both();
        assert!(
            estimate.error >= truth,
            "seed {seed}: {estimate:?}, {truth}"
        );
    }
}

/// Two meshes that happen to agree, or differ more than those before, tell no small error.
#[test]
fn verify_chance_is_not_believed() {
    let mut made = Tending::new(&DOUBLED[..4], 2.0, 0.0, 1);
    made.courses[3] = made.courses[2].clone();
    let (estimate, truth) = made.both();
    let changed = apart(&made.courses[1], &made.courses[2]);
    assert!(
        estimate.error >= 0.25 * changed * 0.99,
        "{estimate:?}, {truth}"
    );
    for (turned, told) in [(1.5, 2.5), (-0.5, 0.5)] {
        let mut made = Tending::new(&DOUBLED[..3], 2.0, 0.0, 1);
        for row in 0..MOMENTS {
            for k in 0..2 {
                let [a, b] = [0, 1].map(|mesh| made.courses[mesh][row][k]);
                made.courses[2][row][k] = b + turned * (b - a);
            }
        }
        let (estimate, _) = made.both();
        let changed = apart(&made.courses[0], &made.courses[1]);
        assert_eq!(estimate.order, None);
        assert!(
            (estimate.error / (1.25 * told * changed) - 1.0).abs() < 1e-3,
            "{estimate:?}"
        );
    }
}

/// Three meshes of which the first is too coarse tell no more than the last two.
#[test]
fn verify_a_first_mesh_too_coarse_lowers_no_estimate() {
    let regular = Tending::new(&DOUBLED[..3], 2.0, 0.0, 1);
    let mut coarser = Tending::new(&DOUBLED[..3], 2.0, 0.0, 1);
    for row in 0..MOMENTS {
        for k in 0..2 {
            let [rough, fair] = [0, 1].map(|mesh| coarser.courses[mesh][row][k]);
            coarser.courses[0][row][k] = fair + 3.0 * (rough - fair);
        }
    }
    let [of_regular, of_coarser] = [&regular, &coarser].map(|made| made.both().0.error);
    let of_two = MeshError::of(&regular.meshes()[1..]).unwrap().error;
    assert!((of_regular / of_two - 1.25 / 3.0).abs() < 1e-3);
    assert!((of_coarser / of_two - 1.0).abs() < 1e-9);
}

#[test]
fn verify_few_meshes_tell_less() {
    let made = Tending::new(&DOUBLED[..2], 2.0, 0.0, 1);
    assert_eq!(MeshError::of(&made.meshes()[..1]), None);
    let (estimate, truth) = made.both();
    assert_eq!(estimate.order, None);
    assert!((estimate.error / truth - 3.0).abs() < 1e-3, "{estimate:?}");
}
