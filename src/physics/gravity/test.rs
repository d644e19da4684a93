use nalgebra::Vector3;

use super::Gravity;
use crate::physics::Potential;
use crate::physics::suite::{self, Chance};

#[test]
fn derivatives_hold() {
    let term = Gravity::new(&[2e-6, 5e-6], Vector3::new(0.3, -1.0, -9.81));
    let mut chance = Chance::new(5);
    for s in 0..2 {
        suite::derivatives(&term, s, &chance.nodes(0.1), 1e-2, "gravity");
    }
}

#[test]
fn weight_is_mass_times_field() {
    let term = Gravity::new(&[2e-6, 5e-6], Vector3::new(0.0, 0.0, -9.81));
    assert!((term.total() - 7e-6 * 9.81).abs() < 1e-18);
    let lifted = term.value(1, &[Vector3::z()]) - term.value(1, &[Vector3::zeros()]);
    assert!((lifted - 5e-6 * 9.81).abs() < 1e-18, "lifting costs m g h");
}
