//! Implicit gradient flow: M (x - x_n)/tau² + dW/dx = 0, backward Euler with the velocity forgotten. Each step
//! minimises the energy plus a distance, so the energy falls; tau grows until Newton alone is left.

use nalgebra::Vector3;

use super::{Map, State};

pub fn map(state: &State, tau: f64) -> Map {
    let a = 1.0 / (tau * tau);
    Map {
        fraction: 1.0,
        alpha_v: 0.0,
        alpha_a: a,
        b_v: vec![Vector3::zeros(); state.positions.len()],
        b_a: state.positions.iter().map(|x| x * -a).collect(),
    }
}
