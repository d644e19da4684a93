//! `toile recover`: make a recording that was cut short a whole one.

use std::path::PathBuf;

use clap::Args;

use super::{CliError, output};
use crate::node;

/// Arguments of `toile recover`.
#[derive(Args)]
pub(super) struct RecoverArgs {
    /// The recording, an MCAP file or a bag directory; it is completed in place.
    file: PathBuf,
    /// A JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

impl RecoverArgs {
    pub(super) fn run(&self) -> Result<(), CliError> {
        let recovery = node::recover(&self.file)?;
        if self.json {
            return output::print_json(&serde_json::json!(recovery));
        }
        let file = self.file.display();
        if recovery.was_complete {
            return output::print(&format!("{file} is complete, nothing was changed\n"));
        }
        output::print(&format!(
            "{file} is complete now: {} states, {} messages; {} bytes at its end were half-written and are gone\n",
            recovery.states, recovery.messages, recovery.lost
        ))
    }
}
