use nalgebra::Vector3;

use super::Damping;
use crate::physics::suite::Chance;

/// The power taken out is what the force does on the velocity, and never negative.
#[test]
fn power_is_force_on_velocity() {
    let areas = [2e-5, 1e-5, 4e-5];
    let term = Damping::new(0.1, &areas);
    let mut chance = Chance::new(9);
    for _ in 0..10 {
        let velocities: [Vector3<f64>; 3] = chance.nodes(2.0);
        let work: f64 = (0..3)
            .map(|i| term.force(i, &velocities[i]).dot(&velocities[i]))
            .sum();
        let power = term.power(&velocities);
        assert!(power > 0.0 && (power + work).abs() < 1e-15 * power.max(1.0));
        let expected = velocities[1] * (-0.1 * areas[1]);
        assert!((term.force(1, &velocities[1]) - expected).norm() < 1e-18);
    }
}

/// The force is linear in the velocity, so its derivative is the coefficient that the tangent uses.
#[test]
fn derivative_is_the_coefficient() {
    let term = Damping::new(3.0, &[2e-5]);
    let (v, d) = (Vector3::new(1.0, -2.0, 0.5), Vector3::new(0.1, 0.2, -0.3));
    let difference = (term.force(0, &(v + d)) - term.force(0, &(v - d))) * 0.5;
    assert!((difference + d * term.coefficients[0]).norm() < 1e-18);
}
