use nalgebra::Vector3;

use super::Damping;
use crate::physics::Load;
use crate::physics::suite::{self, Chance};

fn force(term: &Damping, i: usize, v: &Vector3<f64>) -> Vector3<f64> {
    term.force(i, &[Vector3::zeros()], &[*v])[0]
}

/// The power taken out is what the force does on the velocity, and never negative.
#[test]
fn power_is_force_on_velocity() {
    let areas = [2e-5, 1e-5, 4e-5];
    let term = Damping::new(0.1, &areas);
    let mut chance = Chance::new(9);
    for _ in 0..10 {
        let velocities: [Vector3<f64>; 3] = chance.nodes(2.0);
        let work: f64 = (0..3)
            .map(|i| force(&term, i, &velocities[i]).dot(&velocities[i]))
            .sum();
        let power = term.power(&velocities);
        assert!(power > 0.0 && (power + work).abs() < 1e-15 * power.max(1.0));
        let expected = velocities[1] * (-0.1 * areas[1]);
        assert!((force(&term, 1, &velocities[1]) - expected).norm() < 1e-18);
    }
}

#[test]
fn derivatives_hold() {
    let mut chance = Chance::new(10);
    let term = Damping::new(3.0, &[2e-5]);
    suite::load(
        &term,
        0,
        (&chance.nodes(0.1), &chance.nodes(2.0)),
        (1e-2, 1.0),
        "damping",
    );
}
