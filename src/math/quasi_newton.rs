//! L-BFGS from a given inverse (Nocedal 1980; for elastic steps Liu, Bouaziz, Kavan 2017,
//! doi:10.1145/2990496): a matrix that stays the same stands in for the tangent, the last few steps correct it.

use std::collections::VecDeque;

use super::newton::{Limits, Outcome, Problem, Scratch, dot, line_search};

/// Steps remembered: more cost more than they save.
const REMEMBERED: usize = 10;
/// Least cosine between a step and the change of the residual along it for the pair to be kept.
const LEAST_CURVATURE: f64 = 1e-8;

/// A step and what it changed.
struct Pair {
    step: Vec<f64>,
    change: Vec<f64>,
    /// 1 / (step · change).
    inverse: f64,
}

/// Solves r(z) = 0 from the given z, which holds the best iterate on return. `inverse` applies the inverse of the
/// constant matrix in place; it counts as a solve.
pub fn quasi_newton(
    problem: &mut impl Problem,
    mut inverse: impl FnMut(&mut [f64]),
    z: &mut [f64],
    limits: &Limits,
    scratch: &mut Scratch,
) -> Outcome {
    let mut outcome = Outcome::default();
    scratch.resize(z.len());
    let mut pairs: VecDeque<Pair> = VecDeque::with_capacity(REMEMBERED + 1);
    outcome.norm = problem.residual(z, &mut scratch.r);
    outcome.evaluations += 1;
    loop {
        outcome.converged = outcome.norm <= limits.tolerance;
        if outcome.converged || outcome.iterations as usize >= limits.iterations {
            return outcome;
        }
        outcome.iterations += 1;
        scratch.step.copy_from_slice(&scratch.r);
        direction(&mut scratch.step, &pairs, &mut inverse);
        outcome.solves += 1;
        let before = z.to_vec();
        outcome.moved = line_search(problem, z, limits.overshoot, scratch, &mut outcome);
        if !outcome.moved {
            // What was remembered may point astray; the constant matrix alone never does.
            if pairs.is_empty() {
                return outcome;
            }
            pairs.clear();
            outcome.norm = problem.residual(z, &mut scratch.r);
            outcome.evaluations += 1;
            continue;
        }
        // The line search leaves the residual before in the place of the trial's.
        let step: Vec<f64> = z.iter().zip(&before).map(|(a, b)| a - b).collect();
        let changes = scratch.r.iter().zip(&scratch.trial_r);
        let change: Vec<f64> = changes.map(|(a, b)| a - b).collect();
        let along = dot(&step, &change);
        let scale = (dot(&step, &step) * dot(&change, &change)).sqrt();
        if along > LEAST_CURVATURE * scale {
            let inverse = 1.0 / along;
            pairs.push_back(Pair {
                step,
                change,
                inverse,
            });
            if pairs.len() > REMEMBERED {
                pairs.pop_front();
            }
        }
    }
}

/// Turns a residual into the step that L-BFGS takes from it, by its two loops.
fn direction(q: &mut [f64], pairs: &VecDeque<Pair>, inverse: &mut impl FnMut(&mut [f64])) {
    let mut weights = Vec::with_capacity(pairs.len());
    for pair in pairs.iter().rev() {
        let weight = pair.inverse * dot(&pair.step, q);
        add(q, -weight, &pair.change);
        weights.push(weight);
    }
    inverse(q);
    for (pair, weight) in pairs.iter().zip(weights.iter().rev()) {
        let back = pair.inverse * dot(&pair.change, q);
        add(q, weight - back, &pair.step);
    }
    q.iter_mut().for_each(|c| *c = -*c);
}

fn add(sum: &mut [f64], factor: f64, vector: &[f64]) {
    for (a, b) in sum.iter_mut().zip(vector) {
        *a += factor * b;
    }
}
