use nalgebra::{Vector2, Vector3};

use super::Stretch;
use crate::fabric::{Orthotropic, PoissonCoupling, find};
use crate::physics::suite::{self, Chance};
use crate::physics::{Nodes, Potential};
use crate::sheet::Mesh;

/// One triangle with its stiffness and smallest height.
fn triangle(corners: [[f64; 2]; 3], stiffness: Orthotropic) -> (Stretch, Nodes<3>, f64) {
    let points = corners.map(Vector2::from);
    let mesh = Mesh::new(points.into(), points.into(), vec![[0, 1, 2]]);
    let longest = (0..3).map(|e| mesh.edge_length(e)).fold(0.0, f64::max);
    let height = 2.0 * mesh.area() / longest;
    let rest = points.map(|p| Vector3::new(p.x, p.y, 0.0));
    (Stretch::new(&mesh, stiffness), rest, height)
}

/// Well shaped, right, sliver, 170 degrees.
const SHAPES: [(&str, [[f64; 2]; 3]); 4] = [
    ("regular", [[0.0, 0.0], [5e-3, 0.2e-3], [2.4e-3, 4.5e-3]]),
    ("right", [[0.0, 0.0], [5e-3, 0.0], [0.0, 5e-3]]),
    ("sliver", [[0.0, 0.0], [5e-3, 0.0], [4.9e-3, 0.1e-3]]),
    ("170 degrees", [[0.0, 0.0], [10e-3, 0.0], [5e-3, 0.437e-3]]),
];

fn laws() -> [Orthotropic; 2] {
    let mut fabric = find("F1").unwrap();
    let plain = fabric.membrane();
    fabric.poisson = PoissonCoupling::Symmetrised;
    [plain, fabric.membrane()]
}

#[test]
fn derivatives_hold_for_any_shape_and_strain() {
    let mut chance = Chance::new(1);
    for law in laws() {
        for (name, corners) in SHAPES {
            let (term, rest, height) = triangle(corners, law);
            for amount in [0.01, 0.1, 0.5] {
                let turn = chance.rotation();
                let x = rest.map(|p| turn * p + chance.vector(amount * height));
                suite::derivatives(&term, 0, &x, height, name);
                suite::rigid_motion(&term, 0, &x, 3, name);
                suite::rest(&term, 0, &rest.map(|p| turn * p), &x, name);
            }
        }
    }
}

#[test]
fn derivatives_hold_where_the_face_is_nearly_collapsed() {
    let (term, rest, height) = triangle(SHAPES[0].1, laws()[1]);
    for flat in [1e-1, 1e-3, 1e-6, 0.0] {
        let x = rest.map(|p| Vector3::new(p.x, p.y * flat, 0.1 * p.x));
        suite::derivatives(&term, 0, &x, height, "collapsed");
    }
    let inverted = rest.map(|p| Vector3::new(p.x, -p.y, 0.0));
    assert!(
        term.value(0, &inverted) < 1e-20,
        "a metric does not see a mirror"
    );
}

/// Tension keeps the exact Hessian, compression does not.
#[test]
fn projection_acts_on_compression_only() {
    let (term, rest, _) = triangle(SHAPES[0].1, laws()[1]);
    let scaled = |a: f64, b: f64| rest.map(|p| Vector3::new(p.x * a, p.y * b, 0.0));
    let [tense, slack] = [scaled(1.02, 1.03), scaled(0.98, 1.01)];
    suite::projection(
        &term.hessian(0, &tense),
        &term.hessian_projected(0, &tense),
        "tense",
    );
    assert_eq!(term.hessian(0, &tense), term.hessian_projected(0, &tense));
    assert_ne!(term.hessian(0, &slack), term.hessian_projected(0, &slack));
}

/// A strain of 1 % along the warp costs C11 e11²/2 per area, a shear C66 (2 e12)²/2.
#[test]
fn energy_is_that_of_the_law() {
    let law = laws()[1];
    let (term, rest, _) = triangle(SHAPES[0].1, law);
    let area = term.faces[0].area;
    let e = 0.5 * (1.01f64.powi(2) - 1.0);
    let pulled = rest.map(|p| Vector3::new(p.x * 1.01, p.y, 0.0));
    let expected = 0.5 * area * law.c11 * e * e;
    assert!((term.value(0, &pulled) / expected - 1.0).abs() < 1e-12);
    let sheared = rest.map(|p| Vector3::new(p.x, p.y, 0.0) + Vector3::x() * (0.02 * p.y));
    let (e12, e22) = (0.01, 0.5 * 0.02f64.powi(2));
    let expected = 0.5 * area * (4.0 * law.c66 * e12 * e12 + law.c22 * e22 * e22);
    assert!((term.value(0, &sheared) / expected - 1.0).abs() < 1e-10);
}

/// The stress that Newton predicts is exact to first order in the step.
#[test]
fn linearised_stress_leaves_out_the_quadratic_part() {
    let (term, rest, height) = triangle(SHAPES[0].1, laws()[1]);
    let mut chance = Chance::new(3);
    let way: Nodes<3> = chance.nodes(height);
    let off = |step: f64| {
        let x = std::array::from_fn(|k| rest[k] + way[k] * step);
        (term.linearised_stress(0, &rest, &x) - term.stress(&term.strain(0, &x))).norm()
    };
    let order = (off(1e-2) / off(1e-3)).log10();
    assert!((order - 2.0).abs() < 0.05, "order {order}");
    // Along a straight way it is the exactly linear part: twice the step, twice the stress.
    let stress = |step: f64| {
        let x = std::array::from_fn(|k| rest[k] + way[k] * step);
        term.linearised_stress(0, &rest, &x)
    };
    assert!((stress(0.2) - stress(0.1) * 2.0).norm() < 1e-10 * stress(0.2).norm());
}
