//! Newton's method with a sparse Cholesky step and a line search on the directional derivative.

use super::cholesky::Cholesky;
use super::sparse::Pattern;

/// A system of equations r(z) = 0 whose Jacobian is symmetric.
pub trait Problem {
    /// Writes r(z) and returns its scaled norm; non-finite values mean that z is outside the domain.
    fn residual(&mut self, z: &[f64], r: &mut [f64]) -> f64;
    /// Says that the z of the last call to `residual` is the new iterate.
    fn accept(&mut self);
    /// Writes the lower triangle of the Jacobian at the z of the last call to `residual`; with `projected`,
    /// of a positive semidefinite stand-in.
    fn tangent(&mut self, projection: f64, values: &mut [f64]);
    /// The pattern of the Jacobian, if it has grown since it was last asked for.
    fn grown(&mut self) -> Option<Pattern> {
        None
    }
    /// How much of a step from `z` may be tried, 0 to 1.
    fn longest(&mut self, _z: &[f64], _step: &[f64]) -> f64 {
        1.0
    }
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Scaled norm of the residual at which the system counts as solved.
    pub tolerance: f64,
    /// Most iterations.
    pub iterations: usize,
    /// A step is cut while the slope along it, at its end, is more than this times that at its start, downhill.
    pub overshoot: f64,
}

/// What the iteration did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Whether the tolerance was met.
    pub converged: bool,
    /// Last scaled norm.
    pub norm: f64,
    /// Iterations.
    pub iterations: u64,
    /// Evaluations of the residual.
    pub evaluations: u64,
    /// Factorisations.
    pub factorisations: u64,
    /// Of these, those that failed: the matrix was not positive definite.
    pub indefinite: u64,
    /// Of these, those of a matrix that stays the same through a solve.
    pub constant: u64,
    /// Linear solves.
    pub solves: u64,
    /// Line search steps beyond the first.
    pub halvings: u64,
    /// Whether the last step of the iteration was taken.
    pub moved: bool,
}

/// Work vectors, kept between calls.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    pub(super) r: Vec<f64>,
    pub(super) trial_r: Vec<f64>,
    trial: Vec<f64>,
    pub(super) step: Vec<f64>,
    values: Vec<f64>,
    projection: f64,
}

impl Scratch {
    /// Forgets what earlier systems needed, so that the next one does not depend on them.
    pub fn forget(&mut self) {
        self.projection = 0.0;
    }

    pub(super) fn resize(&mut self, size: usize) {
        for vector in [
            &mut self.r,
            &mut self.trial_r,
            &mut self.trial,
            &mut self.step,
        ] {
            vector.resize(size, 0.0);
        }
    }
}

/// Least share of projection that is tried.
const LEAST_PROJECTION: f64 = 1.0 / 64.0;
/// Least part of a step that is worth trying.
const SHORTEST: f64 = 1e-4;
/// Most halvings of one step.
const HALVINGS: usize = 12;
/// The usual [`Limits::overshoot`]: a step must not end much further up than it began downhill.
pub const OVERSHOOT: f64 = 0.9;

/// Solves r(z) = 0 from the given z, which holds the best iterate on return.
pub fn newton(
    problem: &mut impl Problem,
    cholesky: &mut Cholesky,
    z: &mut [f64],
    limits: &Limits,
    scratch: &mut Scratch,
) -> Outcome {
    let mut outcome = Outcome::default();
    scratch.resize(z.len());
    scratch.values.resize(cholesky.pattern().entries(), 0.0);
    outcome.norm = problem.residual(z, &mut scratch.r);
    outcome.evaluations += 1;
    loop {
        outcome.converged = outcome.norm <= limits.tolerance;
        if outcome.converged || outcome.iterations as usize >= limits.iterations {
            return outcome;
        }
        outcome.iterations += 1;
        outcome.moved = false;
        if !factorise(problem, cholesky, scratch, &mut outcome) {
            return outcome;
        }
        for (step, r) in scratch.step.iter_mut().zip(&scratch.r) {
            *step = -r;
        }
        cholesky.solve(&mut scratch.step, 1);
        outcome.solves += 1;
        outcome.moved = line_search(problem, z, limits.overshoot, scratch, &mut outcome);
        if !outcome.moved {
            return outcome;
        }
    }
}

/// Factorises the tangent with as much projection as it needs to be positive definite. The share starts from
/// what the iteration before needed: a factorisation that fails costs as much as one that does not.
fn factorise(
    problem: &mut impl Problem,
    cholesky: &mut Cholesky,
    scratch: &mut Scratch,
    outcome: &mut Outcome,
) -> bool {
    if let Some(pattern) = problem.grown() {
        *cholesky = Cholesky::reordered(pattern);
        scratch.values.resize(cholesky.pattern().entries(), 0.0);
    }
    loop {
        problem.tangent(scratch.projection, &mut scratch.values);
        outcome.factorisations += 1;
        if cholesky.factorise(&scratch.values).is_ok() {
            scratch.projection = if scratch.projection <= LEAST_PROJECTION {
                0.0
            } else {
                scratch.projection / 4.0
            };
            return true;
        }
        outcome.indefinite += 1;
        if scratch.projection >= 1.0 {
            return false;
        }
        scratch.projection = (4.0 * scratch.projection).clamp(LEAST_PROJECTION, 1.0);
    }
}

/// Moves z along the step to where the slope r·step has lost its size or changed sign mildly.
pub(super) fn line_search(
    problem: &mut impl Problem,
    z: &mut [f64],
    overshoot: f64,
    scratch: &mut Scratch,
    outcome: &mut Outcome,
) -> bool {
    let slope = dot(&scratch.r, &scratch.step);
    if !slope.is_finite() || slope >= 0.0 {
        return false;
    }
    let mut length = problem.longest(z, &scratch.step);
    if length < SHORTEST {
        return false;
    }
    for _ in 0..=HALVINGS {
        for ((trial, z), step) in scratch.trial.iter_mut().zip(&*z).zip(&scratch.step) {
            *trial = z + length * step;
        }
        let norm = problem.residual(&scratch.trial, &mut scratch.trial_r);
        outcome.evaluations += 1;
        let trial_slope = dot(&scratch.trial_r, &scratch.step);
        if norm.is_finite() && trial_slope <= overshoot * slope.abs() {
            z.copy_from_slice(&scratch.trial);
            std::mem::swap(&mut scratch.r, &mut scratch.trial_r);
            outcome.norm = norm;
            problem.accept();
            return true;
        }
        outcome.halvings += 1;
        // Where the slope would vanish if it were linear in the length.
        let secant = slope / (slope - trial_slope);
        let shrink = if secant.is_finite() {
            secant.clamp(0.1, 0.5)
        } else {
            0.1
        };
        length *= shrink;
    }
    false
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
