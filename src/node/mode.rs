//! Whether a run goes on or stands.

/// Whether a run goes on or stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    /// Steps follow each other at the run's pace.
    Running,
    /// No step is taken.
    Paused,
}
