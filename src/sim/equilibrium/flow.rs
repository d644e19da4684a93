//! Gradient flow with a growing step, one Newton iteration a step.
//!
//! The stress in the geometric part of the tangent is a variable of its own, linearised along with the positions (the
//! mixed iteration of Magisano, Leonetti, Garcea 2017), so that full steps carry even where the membrane is nearly
//! inextensible. A line search on the energy would forbid them, since each leaves that membrane stretched for one
//! iteration: with it, a drape takes three to five times as many. So first the flow is bold, and steps are cut only where
//! the slope along them explodes; if that does not settle, it goes on cautiously.

use crate::math::newton::Limits;
use crate::sim::implicit::Implicit;
use crate::sim::integrate::Rule;
use crate::sim::model::Model;
use crate::sim::report::Work;
use crate::sim::state::State;
use crate::sim::step::{Diverged, failure, take};
use crate::sim::touch::Touch;

/// Flow step below which the flow has failed \[s\].
const LEAST_STEP: f64 = 1e-6;
/// Flow step beyond which the mass does not count \[s\].
const MOST_STEP: f64 = 1e4;
/// How a phase of the flow goes: slope along a step at which it is cut, growth of the step, iterations.
struct Phase {
    overshoot: f64,
    growth: f64,
    most: u64,
}

const BOLD: Phase = Phase {
    overshoot: 1e3,
    growth: 2.0,
    most: 300,
};
const CAUTIOUS: Phase = Phase {
    overshoot: 0.9,
    growth: 1.4,
    most: 1500,
};

/// Where a flow ended.
pub struct Flowed {
    pub residual: f64,
    pub touch: Touch,
}

/// Lets the state flow to a residual of `tolerance` of the weight, in the air of the time `within` the step.
pub fn flow(
    model: &Model,
    solver: &mut Implicit,
    state: &mut State,
    (tolerance, within): (f64, f64),
    work: &mut Work,
) -> Result<Flowed, Diverged> {
    solver.forget();
    let rule = Rule::GradientFlow;
    let mut last = (f64::INFINITY, 0);
    for phase in [BOLD, CAUTIOUS] {
        let limits = Limits {
            tolerance,
            iterations: 1,
            overshoot: phase.overshoot,
        };
        let mut tau = model.scene.method.dt;
        for _ in 0..phase.most {
            let solved = solver.solve(model, state, rule, (within, tau), &limits);
            let outcome = &solved.outcome;
            *work += Work::of(outcome);
            if outcome.iterations == 0 {
                return Ok(Flowed {
                    residual: outcome.norm,
                    touch: solved.touch,
                });
            }
            last = (outcome.norm, solved.worst);
            if !outcome.moved {
                work.rejected += 1;
                tau *= 0.25;
                if tau < LEAST_STEP {
                    break;
                }
                solver.forget();
                continue;
            }
            work.substeps += 1;
            state.ledger.friction += take(model, state, rule, &solved, (within, tau));
            match outcome.halvings {
                0 => tau = (phase.growth * tau).min(MOST_STEP),
                1 => {}
                _ => tau *= 0.5,
            }
        }
    }
    let advice = "no state of rest was found; try a finer mesh there, a larger method.tolerance, or supports that hold \
                  the sheet";
    Err(failure(model, state, last, advice.into()))
}
