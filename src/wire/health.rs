//! How a run does, for the tools that watch robots: `/diagnostics` and `/rosout`.

use super::cdr::CdrError;
use super::messages::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus, KeyValue};
use super::messages::rcl_interfaces::Log;
use super::packets::{Packet, packet};
use super::{Counters, channels, header, stamp};
use crate::sim::StepReport;

/// Name of the node and of its logger.
const NODE: &str = "toile";

/// How grave a line of the log is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// What is expected.
    Info,
    /// What may become a problem.
    Warning,
    /// What went wrong.
    Error,
}

/// A line for `/rosout` at a simulated time \[s\].
pub fn log(level: Level, text: &str, time: f64) -> Result<Packet, CdrError> {
    let level = match level {
        Level::Info => Log::INFO,
        Level::Warning => Log::WARN,
        Level::Error => Log::ERROR,
    };
    let message = Log {
        stamp: stamp(time),
        level,
        name: NODE.to_string(),
        msg: text.to_string(),
        ..Log::default()
    };
    packet(&channels::LOG, time, &message)
}

/// The state of the run for `/diagnostics`: an error if a step did not converge or missed its tolerance, a warning if
/// something was dropped, malformed or late.
pub fn diagnostics(report: &StepReport, counters: &Counters) -> Result<Packet, CdrError> {
    let counts = [
        ("overruns", counters.overruns),
        ("dropped_live", counters.dropped_live),
        ("dropped_commands", counters.dropped_commands),
        ("malformed_commands", counters.malformed_commands),
    ];
    let troubles: Vec<_> = counts.iter().filter(|(_, count)| *count > 0).collect();
    let (level, message) = match (report.converged, troubles.is_empty()) {
        (false, _) => (
            DiagnosticStatus::ERROR,
            "the step did not converge, or missed its step_tolerance".to_string(),
        ),
        (true, true) => (DiagnosticStatus::OK, "running".to_string()),
        (true, false) => {
            let names: Vec<_> = troubles
                .iter()
                .map(|(name, n)| format!("{n} {name}"))
                .collect();
            (DiagnosticStatus::WARN, names.join(", ").replace('_', " "))
        }
    };
    let value = |(key, value): (&str, String)| KeyValue {
        key: key.to_string(),
        value,
    };
    let values = [
        ("step", report.step.to_string()),
        ("time [s]", report.time.to_string()),
        ("residual [-]", format!("{:.3e}", report.residual)),
        ("contacts [-]", report.contacts.to_string()),
    ];
    let counts = counts.map(|(key, count)| (key, count.to_string()));
    let message = DiagnosticArray {
        header: header(report.time),
        status: vec![DiagnosticStatus {
            level,
            name: format!("{NODE}: simulation"),
            message,
            hardware_id: String::new(),
            values: values.into_iter().chain(counts).map(value).collect(),
        }],
    };
    packet(&channels::DIAGNOSTICS, report.time, &message)
}
