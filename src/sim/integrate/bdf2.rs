//! BDF2 with a variable step (Hairer, Norsett, Wanner, Solving ODEs I, III.5): with w = dt / dt_before,
//!
//! ```text
//! y' = [(1 + 2w)/(1 + w) y - (1 + w) y_n + w²/(1 + w) y_(n-1)] / dt
//! ```
//!
//! for y = x and y = v. Second order; A-stable at a constant step, zero-stable for w below 1 + sqrt 2.

use super::{Map, State};

pub fn map(state: &State, dt: f64) -> Map {
    let w = dt / state.history.dt;
    let [c0, c1, c2] = [(1.0 + 2.0 * w) / (1.0 + w), -(1.0 + w), w * w / (1.0 + w)].map(|c| c / dt);
    let past = &state.history;
    let b_v: Vec<_> = state
        .positions
        .iter()
        .zip(&past.positions)
        .map(|(x, before)| x * c1 + before * c2)
        .collect();
    let b_a = b_v
        .iter()
        .zip(state.velocities.iter().zip(&past.velocities))
        .map(|(b, (v, before))| b * c0 + v * c1 + before * c2)
        .collect();
    Map {
        fraction: 1.0,
        alpha_v: c0,
        alpha_a: c0 * c0,
        b_v,
        b_a,
    }
}
