//! Time schemes. An implicit scheme is an affine map of the unknown positions x (after Drake's
//! `DiscreteTimeIntegrator`), so that Newton is written once:
//!
//! ```text
//! v = alpha_v x + b_v,   a = alpha_a x + b_a,   M a + mu A v + dW/dx = 0 at t_n + fraction dt
//! ```

mod backward_euler;
mod bdf2;
pub mod explicit;
mod folds;
mod generalised_alpha;
mod gradient_flow;
mod held;
mod impulse;
mod leap;
mod local_error;
mod stable;
#[cfg(test)]
mod test;
pub mod xpbd;

pub use local_error::{exponent, local_error};
pub use stable::{SAFETY, quickest};

use nalgebra::Vector3;

use super::state::State;
use crate::scene::{MethodSpec, Scheme};

/// The affine map of a step and where in the step the forces are taken.
#[derive(Clone, Debug)]
pub struct Map {
    /// Where the forces are taken, as a fraction of the step.
    pub fraction: f64,
    /// Weight of x in v \[1/s\].
    pub alpha_v: f64,
    /// Weight of x in a \[1/s²\].
    pub alpha_a: f64,
    /// Rest of v \[m/s\], shape \[vertices\].
    pub b_v: Vec<Vector3<f64>>,
    /// Rest of a \[m/s²\], shape \[vertices\].
    pub b_a: Vec<Vector3<f64>>,
}

/// An implicit rule for one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// First order.
    BackwardEuler,
    /// Second order, variable step.
    Bdf2,
    /// Second order, spectral radius at infinity given.
    GeneralisedAlpha(f64),
    /// No inertia: x' = -dW/dx in the metric of the mass, the step squared in place of the step.
    GradientFlow,
}

impl Rule {
    /// The rule that a method names; `None` for the explicit scheme.
    pub fn of(method: &MethodSpec) -> Option<Self> {
        match method.scheme {
            Scheme::BackwardEuler => Some(Self::BackwardEuler),
            Scheme::Bdf2 => Some(Self::Bdf2),
            Scheme::GeneralisedAlpha => Some(Self::GeneralisedAlpha(method.rho_infinity)),
            Scheme::Equilibrium => Some(Self::GradientFlow),
            Scheme::CentralDifference => None,
        }
    }

    /// The rule for the next step: backward Euler where the state lacks the past that a rule needs.
    pub(super) fn possible(self, state: &State) -> Self {
        match self {
            Self::Bdf2 if state.history.dt == 0.0 => Self::BackwardEuler,
            Self::GeneralisedAlpha(_) if state.history.accelerations.is_empty() => {
                Self::BackwardEuler
            }
            rule => rule,
        }
    }

    /// The map for a step of `dt` from `state`.
    pub fn map(&self, state: &State, dt: f64) -> Map {
        match self.possible(state) {
            Self::BackwardEuler => backward_euler::map(state, dt),
            Self::Bdf2 => bdf2::map(state, dt),
            Self::GeneralisedAlpha(rho) => generalised_alpha::map(state, dt, rho),
            Self::GradientFlow => gradient_flow::map(state, dt),
        }
    }

    /// Takes the state from the start of the step to its end, given the nodes (positions, then slopes) that
    /// solve the equations at the map's fraction.
    pub fn advance(&self, state: &mut State, map: &Map, nodes: &[Vector3<f64>], dt: f64) {
        let end = if map.fraction == 1.0 {
            nodes.to_vec()
        } else {
            extrapolate(&state.nodes(), nodes, map.fraction)
        };
        let (positions, slopes) = end.split_at(state.positions.len());
        let (velocities, accelerations) = match self.possible(state) {
            Self::GeneralisedAlpha(rho) => generalised_alpha::end(state, positions, dt, rho),
            Self::GradientFlow => (
                vec![Vector3::zeros(); positions.len()],
                vec![Vector3::zeros(); positions.len()],
            ),
            _ => (
                affine(map.alpha_v, positions, &map.b_v),
                affine(map.alpha_a, positions, &map.b_a),
            ),
        };
        state.history.dt = dt;
        state.history.positions = std::mem::replace(&mut state.positions, positions.to_vec());
        state.history.velocities = std::mem::replace(&mut state.velocities, velocities);
        state.history.accelerations = accelerations;
        state.slopes = slopes.to_vec();
        state.slope_rates.fill(Vector3::zeros());
    }
}

fn affine(alpha: f64, x: &[Vector3<f64>], b: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    x.iter().zip(b).map(|(x, b)| x * alpha + b).collect()
}

/// From the start and a point inside the step to its end. Slopes may be carried too: they are a linear function
/// of the positions.
pub fn extrapolate(
    start: &[Vector3<f64>],
    inside: &[Vector3<f64>],
    fraction: f64,
) -> Vec<Vector3<f64>> {
    let step = |(a, b): (&Vector3<f64>, &Vector3<f64>)| a + (b - a) / fraction;
    start.iter().zip(inside).map(step).collect()
}
