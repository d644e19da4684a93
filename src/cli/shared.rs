//! What went through shared memory in a run.

use serde_json::{Value, json};

use crate::node::shared_memory::Counts;

/// Adds the counts to a JSON summary.
pub(super) fn with_counts(mut summary: Value, counts: Option<&Counts>) -> Value {
    if let Some(counts) = counts {
        let [published, dropped, received, refused] = counts.all();
        summary["shared_memory"] = json!({
            "published": published,
            "dropped": dropped,
            "received": received,
            "refused": refused,
            "failure": counts.failure(),
        });
    }
    summary
}

/// Says on standard error what went wrong.
pub(super) fn warn(counts: Option<&Counts>) {
    let Some(counts) = counts else {
        return;
    };
    let [_, dropped, received, refused] = counts.all();
    if dropped > 0 {
        let reason = counts.failure().unwrap_or_else(|| "no memory".to_string());
        eprintln!("warning: {dropped} messages were not published over shared memory: {reason}");
    }
    if refused > 0 {
        eprintln!("warning: {refused} of {received} requests over shared memory were refused");
    }
}
