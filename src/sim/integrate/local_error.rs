//! What a part of a step adds to the error of the positions, from the state at its end: no solve, no memory beyond it.
//!
//! Backward Euler and BDF2 are set beside the trapezoidal rule over the velocities that they found (an embedded pair;
//! Hairer, Norsett, Wanner, Solving ODEs I, II.4 and III.7):
//!
//! ```text
//! d = x_(n+1) - x_n - dt/2 (v_n + v_(n+1))
//! backward Euler   d = -dt²/2 x''                                 = what it adds
//! BDF2             d = 1/4 dt³ x''',  it adds 1/3 dt³ x''',  so     4/3 d
//! ```
//!
//! The 1/3 of equal steps is the usual 2/9 with the part that the formula remembers, 1/3 of what it added before.
//!
//! Generalised-alpha has no such pair (at `rho` = 1 it is the trapezoidal rule); after Zienkiewicz and Xie (Earthquake
//! Eng. Struct. Dyn. 20, 1991, 871) the jump of the acceleration serves. Theirs is (beta - 1/6) dt² (a_(n+1) - a_n) for
//! Newmark; here a_n stands for the time t_n + theta dt, theta = am - af, and Taylor's series give
//!
//! ```text
//! it adds (beta + theta/2 - 1/6) dt³ x''' = (1/12 + theta²/4) dt² (a_(n+1) - a_n)
//! ```
//!
//! with a_n from Newmark's two formulas, which the state at the end still satisfies.
//!
//! Over the sheet the root of the mean square is taken, weighted by mass: the norm of the kinetic energy. It does not
//! change with the mesh, where the largest vertex would: one vertex that lands jumps in velocity, and no step but the
//! shortest would serve it, however small its share of the sheet. A vibration that the step does not resolve counts by its
//! amplitude, since all here are differences of positions over the step itself: with dt omega times its amplitude, which
//! true velocities would give, micrometres of the membrane's ringing would force the step of the explicit scheme.

use nalgebra::Vector3;

use super::{Rule, generalised_alpha};
use crate::sim::dofs::Dofs;
use crate::sim::state::State;

/// Power of the step with which what a part adds grows.
pub fn exponent(rule: Rule) -> u32 {
    match rule {
        Rule::BackwardEuler | Rule::GradientFlow => 2,
        Rule::Bdf2 | Rule::GeneralisedAlpha(_) => 3,
    }
}

/// What the part that ends in `state` added to the error of the free positions \[m\], mass-weighted root of the mean square;
/// zero without a past.
pub fn local_error(rule: Rule, state: &State, masses: &[f64], dofs: &Dofs) -> f64 {
    let past = &state.history;
    if past.dt == 0.0 || past.accelerations.is_empty() {
        return 0.0;
    }
    let mut square = 0.0;
    for (v, mass) in masses.iter().enumerate() {
        square += mass * dofs.free(v, of_vertex(rule, state, v)).norm_squared();
    }
    (square / masses.iter().sum::<f64>()).sqrt()
}

fn of_vertex(rule: Rule, state: &State, v: usize) -> Vector3<f64> {
    let past = &state.history;
    let dt = past.dt;
    let moved = state.positions[v] - past.positions[v];
    let (from, to) = (past.velocities[v], state.velocities[v]);
    let beside_the_trapezoidal_rule = moved - (from + to) * (0.5 * dt);
    match rule {
        Rule::BackwardEuler => beside_the_trapezoidal_rule,
        Rule::Bdf2 => beside_the_trapezoidal_rule * (4.0 / 3.0),
        Rule::GeneralisedAlpha(rho) => {
            let c = generalised_alpha::constants(rho);
            let now = past.accelerations[v];
            // (1 - gamma) j and (1/2 - beta) j, where j = a_(n+1) - a_n; the two never vanish together.
            let weights = [1.0 - c.gamma, 0.5 - c.beta];
            let by_velocity = now - (to - from) / dt;
            let by_position = now * 0.5 - (moved - from * dt) / (dt * dt);
            let jump = (by_velocity * weights[0] + by_position * weights[1])
                / (weights[0].powi(2) + weights[1].powi(2));
            let theta = c.am - c.af;
            jump * ((1.0 / 12.0 + 0.25 * theta * theta) * dt * dt)
        }
        Rule::GradientFlow => Vector3::zeros(),
    }
}
