//! Parts of a step as long as a tolerance on their error allows: `method.step_tolerance`.
//!
//! A part is a power of two of ticks, so that parts fill a step exactly, start where their length divides, and a
//! constant matrix serves many. They at most double from one to the next, below the 1 + sqrt 2 of BDF2. What the
//! controller knows is the state: the last part's length and error, which a keyframe holds.

use super::integrate::{Rule, exponent, local_error};
use super::model::Model;
use super::state::State;

/// Share of the tolerance that a part of twice the length is to be expected below, or it is not tried.
const CAUTION: f64 = 0.8;

/// The tolerance and what it is kept with.
pub struct ErrorControl<'a> {
    model: &'a Model,
    rule: Rule,
    /// Error in position that a part may add \[m\].
    tolerance: f64,
}

impl<'a> ErrorControl<'a> {
    /// That of a scene which asks for it.
    pub fn of(model: &'a Model, rule: Rule) -> Option<Self> {
        let tolerance = model.scene.method.step_tolerance?;
        Some(Self {
            model,
            rule,
            tolerance,
        })
    }

    /// Error of the part that ends in a state, over the tolerance.
    fn excess(&self, rule: Rule, end: &State) -> f64 {
        local_error(rule, end, &self.model.masses, &self.model.dofs) / self.tolerance
    }

    /// Ticks of the first part of a step of `ticks`, each of which takes `tick` \[s\]: those of the part before, or twice
    /// as many. Without a past it is the whole step.
    pub fn first(&self, state: &State, ticks: u32, tick: f64) -> u32 {
        let before = state.history.dt;
        if before == 0.0 {
            return ticks;
        }
        let longest = before * if self.may_double(state) { 2.0 } else { 1.0 };
        let mut size = ticks;
        // Half a tick for rounding.
        while size > 1 && f64::from(size) * tick > longest + 0.5 * tick {
            size /= 2;
        }
        size
    }

    /// Whether a part of twice the length may follow the one that ends in `state`.
    pub fn may_double(&self, state: &State) -> bool {
        let growth = f64::from(1u32 << exponent(self.rule));
        self.excess(self.rule, state) * growth <= CAUTION
    }

    /// Ticks with which a part of `size` from `start` to `end` is to be tried again, if its error is too large: as many as
    /// its order asks for. After a jump of the velocity the order is one and more tries follow.
    pub fn smaller(&self, start: &State, end: &State, size: u32) -> Option<u32> {
        let rule = self.rule.possible(start);
        let mut excess = self.excess(rule, end);
        if excess <= 1.0 {
            return None;
        }
        let mut size = size;
        while excess > 1.0 && size > 1 {
            size /= 2;
            excess /= f64::from(1u32 << exponent(rule));
        }
        Some(size)
    }
}
