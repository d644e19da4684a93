//! `toile replay`: the same bits again, or where a recording differs.

use std::path::PathBuf;

use clap::Args;

use super::progress::Bar;
use super::{CliError, output, signals};
use crate::node::{self, Replay, ReplayOptions, TOLERANCE};

/// Arguments of `toile replay`.
#[derive(Args)]
pub(super) struct ReplayArgs {
    /// The recording: an MCAP file or a bag directory.
    file: PathBuf,
    /// Start from the last keyframe at or before this step instead of the beginning.
    #[arg(long, value_name = "STEP")]
    from: Option<u64>,
    /// Threads of a step; the result does not depend on it.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    /// A JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

impl ReplayArgs {
    /// Prints the verdict; a difference is exit code 1.
    pub(super) fn run(&self) -> Result<(), CliError> {
        let options = ReplayOptions {
            from: self.from,
            threads: usize::from(self.threads),
            stop: signals::stop_flag()?,
        };
        let bar = Bar::new("replay");
        let result = node::replay(&self.file, &options, &mut |progress| bar.show(progress));
        drop(bar);
        let replay = result?;
        match self.json {
            true => output::print_json(&serde_json::json!(replay))?,
            false => output::print(&self.text(&replay))?,
        }
        match replay.difference {
            None => Ok(()),
            Some(difference) => Err(CliError::Differs {
                file: self.file.clone(),
                difference,
            }),
        }
    }

    fn text(&self, replay: &Replay) -> String {
        let mut rows = vec![
            (
                "replayed",
                format!(
                    "steps {} to {}, {} states, {} commands",
                    replay.from, replay.to, replay.states, replay.commands
                ),
            ),
            ("compared", compared(replay)),
        ];
        if !replay.strict {
            rows.push(("recorded by", maker(&replay.recorded)));
            rows.push(("replayed by", maker(&replay.here)));
        }
        rows.push(("verdict", verdict(replay)));
        let rows: Vec<_> = rows
            .into_iter()
            .map(|(name, value)| vec![format!("  {name}"), value])
            .collect();
        format!("{}\n{}", self.file.display(), output::table(&rows))
    }
}

fn compared(replay: &Replay) -> String {
    match replay.strict {
        true => "every bit: the recording is of this build and this processor".to_string(),
        false => format!(
            "positions and readings to {TOLERANCE:e} m: the recording is of another build or processor"
        ),
    }
}

fn maker(about: &node::About) -> String {
    let known = |text: &str| match text {
        "" => "unknown".to_string(),
        text => text.to_string(),
    };
    format!(
        "toile {} on {}",
        known(&about.build),
        known(&about.processor)
    )
}

fn verdict(replay: &Replay) -> String {
    match (&replay.difference, &replay.bits) {
        (Some(difference), _) => format!("differs at {difference}"),
        (None, None) => "the same bits".to_string(),
        (None, Some(first)) => format!(
            "agrees, by {:.1e} m at most; the first bits differ at {first}",
            replay.largest
        ),
    }
}
