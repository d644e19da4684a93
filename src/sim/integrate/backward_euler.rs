//! Backward Euler: v = (x - x_n)/dt, a = (v - v_n)/dt. First order, unconditionally stable, strongly damping.

use super::{Map, State};

pub fn map(state: &State, dt: f64) -> Map {
    let a = 1.0 / dt;
    let b_v: Vec<_> = state.positions.iter().map(|x| x * -a).collect();
    let b_a = b_v
        .iter()
        .zip(&state.velocities)
        .map(|(b, v)| (b - v) * a)
        .collect();
    Map {
        fraction: 1.0,
        alpha_v: a,
        alpha_a: a * a,
        b_v,
        b_a,
    }
}
