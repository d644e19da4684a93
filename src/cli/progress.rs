//! The bar of a long run: on a terminal only.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::output;
use crate::node::Progress;

/// Parts of the bar; its unit is simulated time, so equal parts are equal time.
const PARTS: u64 = 1000;

/// Shows simulated time, speed against real time, and an estimate of the end.
pub(super) struct Bar(ProgressBar);

impl Bar {
    /// A bar on standard error; it draws nothing when that is not a terminal.
    pub(super) fn new(scene: &str) -> Self {
        let bar = ProgressBar::with_draw_target(Some(PARTS), ProgressDrawTarget::stderr());
        if let Ok(style) = ProgressStyle::with_template("{prefix} [{wide_bar}] {msg}") {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_prefix(scene.to_string());
        bar.set_message("building the sheet");
        Self(bar)
    }

    /// After each step.
    pub(super) fn show(&self, progress: &Progress) {
        let done = (progress.time / progress.duration).clamp(0.0, 1.0);
        self.0.set_message(line(progress));
        self.0.set_position((done * PARTS as f64) as u64);
    }
}

impl Drop for Bar {
    /// The summary or the error takes its place.
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// A bar in thousandths of something, on standard error; nothing when that is not a terminal.
pub(super) fn share_bar(message: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(PARTS), ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("[{bar:32}] {msg}") {
        bar.set_style(style.progress_chars("=> "));
    }
    bar.set_message(message.to_string());
    bar
}

fn line(progress: &Progress) -> String {
    let speed = progress.time / progress.wall_seconds.max(1e-9);
    let left = (progress.duration - progress.time).max(0.0) / speed.max(1e-9);
    // An estimate beyond a century is none, and Duration holds no infinity.
    let left = indicatif::HumanDuration(Duration::from_secs_f64(left.min(3e9)));
    let speed = output::significant(speed, 2);
    format!(
        "{:.3} of {:.3} s, {speed} x real time, {left:#} left",
        progress.time, progress.duration
    )
}
