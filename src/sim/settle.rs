//! Equilibrium by gradient flow.

use super::integrate::Rule;
use super::measure;
use super::simulation::{Engine, Simulation};
use super::step::{Diverged, diverged, take};
use crate::math::newton::Limits;

/// Flow steps after which `settle` gives up.
const MOST_FLOW_STEPS: u64 = 400;
/// Flow step below which `settle` gives up \[s\].
const LEAST_FLOW_STEP: f64 = 1e-6;
/// Flow step at which inertia no longer counts \[s\].
const STIFFEST_FLOW_STEP: f64 = 100.0;

impl Simulation {
    /// Finds an equilibrium from the present state by implicit gradient flow with a growing step, to a residual
    /// of `tolerance` of the weight. The state comes to rest there; friction keeps its bonds. Returns the number
    /// of flow steps.
    pub fn settle(&mut self, tolerance: f64) -> Result<u64, Diverged> {
        let Engine::Implicit(_, solver) = &mut self.engine else {
            panic!("settle() needs an implicit scheme");
        };
        let rule = Rule::GradientFlow;
        let (model, mut tau) = (&self.model, self.model.scene.method.dt);
        let limits = Limits {
            tolerance,
            iterations: model.scene.method.max_iterations,
        };
        let mut report = self.report.clone();
        for count in 1..=MOST_FLOW_STEPS {
            let solved = solver.solve(model, &self.state, rule, (0.0, tau), &limits);
            if !solved.outcome.converged {
                tau *= 0.25;
                if tau < LEAST_FLOW_STEP {
                    return Err(diverged(model, &self.state, &solved, tau));
                }
                continue;
            }
            take(&mut self.state, rule, &solved, tau);
            tau *= 2.0;
            // When one Newton solve of the bare equations changes nothing more, this is the equilibrium.
            if tau > STIFFEST_FLOW_STEP && solved.outcome.iterations <= 1 {
                self.state.history.dt = 0.0;
                measure::measure(model, &self.state, &solved.touch, &mut report);
                self.report = report;
                return Ok(count);
            }
        }
        let solved = solver.solve(model, &self.state, rule, (0.0, tau), &limits);
        Err(diverged(model, &self.state, &solved, tau))
    }
}
