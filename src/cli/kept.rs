//! Whether a run kept the tolerance that it was planned for.

use serde_json::{Value, json};

use super::CliError;
use super::explain::cpu;
use super::output::significant;
use super::plan::failed;
use crate::chart::plan::{Plan, SecondLook, Tolerance, check};

/// The answer, by a second look with half the step on twice the triangles.
pub(super) struct Kept {
    tolerance: Tolerance,
    look: SecondLook,
}

impl Kept {
    /// Runs the second look.
    pub(super) fn check(plan: &Plan, tolerance: Tolerance) -> Result<Self, CliError> {
        let look = check(plan, &mut cpu).map_err(failed)?;
        Ok(Self { tolerance, look })
    }

    fn holds(&self) -> bool {
        self.look.error <= self.tolerance.0
    }
}

/// A line of the summary.
pub(super) fn text(kept: Option<&Kept>) -> String {
    let Some(kept) = kept else {
        return String::new();
    };
    let verdict = match kept.holds() {
        true => "kept",
        false => "MISSED",
    };
    format!(
        "tolerance of {} {verdict}: half the step on twice the triangles changes what is observed by {} %, which tells of \
         an error of {} %\n",
        kept.tolerance,
        significant(1e2 * kept.look.change, 2),
        significant(1e2 * kept.look.error, 2)
    )
}

/// The summary with the answer.
pub(super) fn with_check(mut summary: Value, kept: Option<&Kept>) -> Value {
    if let Some(kept) = kept {
        summary["tolerance"] = json!({
            "asked": kept.tolerance.0,
            "change": kept.look.change,
            "error": kept.look.error,
            "kept": kept.holds(),
        });
    }
    summary
}
