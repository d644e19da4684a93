use nalgebra::Vector3;

use super::{Bond, Friction};
use crate::physics::suite::{self, Chance};
use crate::physics::{Nodes, Potential};

const CORNERS: Nodes<3> = [
    Vector3::new(0.0, 0.0, 0.0),
    Vector3::new(5e-3, 0.0, 1e-3),
    Vector3::new(2e-3, 4e-3, -1e-3),
];

/// A bond at a point of a face whose anchor lies `away` from it \[m\]; it slips beyond 1 um.
fn bond(weights: [f64; 3], normal: Vector3<f64>, away: Vector3<f64>) -> Bond {
    Bond {
        vertices: [0, 1, 2],
        weights,
        normal: normal.normalize(),
        anchor: super::weighted(&weights, &CORNERS) - away,
        limit: 1e-3,
        stiffness: 1e3,
    }
}

#[test]
fn derivatives_hold_while_it_sticks_and_while_it_slips() {
    let mut chance = Chance::new(4);
    for weights in [[1.0, 0.0, 0.0], [0.0, 0.3, 0.7], [0.2, 0.3, 0.5]] {
        for (name, size, length) in [("stick", 2e-7, 5e-7), ("slip", 1e-4, 2e-5)] {
            let normal = chance.vector(1.0);
            let across = normal.cross(&chance.vector(1.0)).normalize();
            let bonds = [bond(weights, normal, across * size + normal * 1e-5)];
            let term = Friction { bonds: &bonds };
            suite::derivatives(&term, 0, &CORNERS, length, name);
        }
    }
}

#[test]
fn it_rests_at_its_anchor_and_feels_no_normal_motion() {
    let bonds = [bond([0.2, 0.3, 0.5], Vector3::z(), Vector3::zeros())];
    let term = Friction { bonds: &bonds };
    let strained = CORNERS.map(|p| p + Vector3::x() * 1e-6);
    let lifted = CORNERS.map(|p| p + Vector3::z() * 1e-3);
    assert!(term.value(0, &strained) > 0.0);
    suite::rest(&term, 0, &CORNERS, &strained, "friction");
    suite::rest(&term, 0, &lifted, &strained, "friction, lifted");
}

/// The force is k s up to mu N and mu N beyond, against the offset; both branches meet.
#[test]
fn force_is_bounded_by_coulombs_limit() {
    let bonds = [bond([0.2, 0.3, 0.5], Vector3::z(), Vector3::zeros())];
    let term = Friction { bonds: &bonds };
    for (offset, expected) in [(5e-7, 5e-4), (1e-6, 1e-3), (1e-5, 1e-3), (1e-2, 1e-3)] {
        let x = CORNERS.map(|p| p + Vector3::x() * offset);
        let force: Vector3<f64> = term.gradient(0, &x).iter().sum();
        assert!((force - Vector3::x() * expected).norm() < 1e-12, "{force}");
    }
}

/// What the bond forgets is the slip: its elastic part is never beyond mu N / k.
#[test]
fn memory_keeps_the_elastic_part_only() {
    let bond = bond([0.2, 0.3, 0.5], Vector3::z(), Vector3::zeros());
    let at = |x: f64| bond.anchor + Vector3::new(x, 0.0, 3e-4);
    let (kept, slip) = bond.settle(&at(4e-7));
    assert!((kept - Vector3::x() * 4e-7).norm() < 1e-16 && slip == 0.0);
    let (kept, slip) = bond.settle(&at(5e-6));
    assert!((kept - Vector3::x() * 1e-6).norm() < 1e-16 && (slip - 4e-6).abs() < 1e-15);
}
