//! The kick of the explicit scheme where air acts on the sheet.

use nalgebra::Matrix3;

use crate::physics::drag::Drag;
use crate::sim::air::resistances;
use crate::sim::lanes::{Lanes, lanes, vector};

/// Takes the rates of the vertices to the next half step with air on the faces, whose force is linear in the velocity: with
/// R the sum of the faces' resistances at a vertex, (I + B dt/2) dv = (M^-1 (f + R u) - B v) dt and B = M^-1 R + mu A/m.
/// Returns what damping took out and what the air put in \[J\].
pub fn kick_in_air(
    air: &Drag,
    (nodes, forces): (&[Lanes], &[Lanes]),
    rates: &mut [Lanes],
    (inverse_mass, drag): (&[Lanes], &[f64]),
    dt: f64,
) -> [f64; 2] {
    let places: Vec<_> = nodes[..drag.len()].iter().map(vector).collect();
    let resistance = resistances(air, &places);
    let (mut taken, mut put) = (0.0, 0.0);
    for (n, r) in resistance.iter().enumerate() {
        let u = air.air[n];
        let (v, inverse) = (vector(&rates[n]), vector(&inverse_mass[n]));
        let braking = Matrix3::from_diagonal(&inverse) * r + Matrix3::identity() * drag[n];
        let pull = (vector(&forces[n]) + r * u).component_mul(&inverse) - braking * v;
        let inertia = Matrix3::identity() + braking * (0.5 * dt);
        let change = inertia.try_inverse().unwrap_or_default() * pull * dt;
        let mean = v + change * 0.5;
        rates[n] = lanes(&(v + change));
        // What air and damping do to a part that is held, its support bears.
        if inverse.max() == 0.0 {
            continue;
        }
        put += (r * (u - mean)).dot(&mean) * dt;
        if drag[n] > 0.0 {
            taken += drag[n] / inverse.max() * mean.norm_squared() * dt;
        }
    }
    [taken, put]
}
