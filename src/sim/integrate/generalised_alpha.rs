//! Generalised-alpha (Chung, Hulbert, J. Appl. Mech. 60, 1993, 371): second order, with the spectral radius
//! rho at infinite frequency chosen between 1 (the trapezoidal rule) and 0.
//!
//! ```text
//! M a_(n+1-am) + mu A v_(n+1-af) + dW/dx(x_(n+1-af)) = 0
//! am = (2 rho - 1)/(rho + 1),  af = rho/(rho + 1),  gamma = 1/2 - am + af,  beta = (1 - am + af)²/4
//! ```
//!
//! The unknown is x_(n+1-af) = (1 - af) x_(n+1) + af x_n; Newmark's formulas make everything affine in it.

use nalgebra::Vector3;

use super::{Map, State};

/// Constants of the scheme \[-\].
pub struct Constants {
    pub af: f64,
    pub am: f64,
    pub beta: f64,
    pub gamma: f64,
}

pub fn constants(rho: f64) -> Constants {
    let (am, af) = ((2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0));
    Constants {
        af,
        am,
        beta: 0.25 * (1.0 - am + af).powi(2),
        gamma: 0.5 - am + af,
    }
}

pub fn map(state: &State, dt: f64, rho: f64) -> Map {
    let c = constants(rho);
    let inside = 1.0 - c.af;
    // a_(n+1) = p x_inside + q, v_(n+1) = v_n + dt ((1 - gamma) a_n + gamma a_(n+1)).
    let p = 1.0 / (c.beta * dt * dt * inside);
    let mut b_v = Vec::with_capacity(state.positions.len());
    let mut b_a = Vec::with_capacity(state.positions.len());
    for ((x, v), a) in state
        .positions
        .iter()
        .zip(&state.velocities)
        .zip(&state.history.accelerations)
    {
        let q = x * -p - v / (c.beta * dt) - a * (0.5 / c.beta - 1.0);
        b_a.push(q * (1.0 - c.am) + a * c.am);
        b_v.push(v + (a * (1.0 - c.gamma) + q * c.gamma) * (dt * inside));
    }
    Map {
        fraction: inside,
        alpha_v: c.gamma * dt * p * inside,
        alpha_a: (1.0 - c.am) * p,
        b_v,
        b_a,
    }
}

/// Velocities and accelerations at the end of the step, given the positions there.
pub fn end(
    state: &State,
    positions: &[Vector3<f64>],
    dt: f64,
    rho: f64,
) -> (Vec<Vector3<f64>>, Vec<Vector3<f64>>) {
    let c = constants(rho);
    state
        .positions
        .iter()
        .zip(positions)
        .zip(state.velocities.iter().zip(&state.history.accelerations))
        .map(|((x, end), (v, a))| {
            let next = (end - x - v * dt) / (c.beta * dt * dt) - a * (0.5 / c.beta - 1.0);
            (v + (a * (1.0 - c.gamma) + next * c.gamma) * dt, next)
        })
        .unzip()
}
