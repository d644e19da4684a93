//! `toile verify`: whether a recording is whole.

use std::path::PathBuf;

use clap::Args;

use super::{CliError, output};
use crate::node;

/// Arguments of `toile verify`.
#[derive(Args)]
pub(super) struct VerifyArgs {
    /// The recording: an MCAP file or a bag directory.
    file: PathBuf,
    /// A JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

impl VerifyArgs {
    /// Prints every fault; there being one is exit code 1.
    pub(super) fn run(&self) -> Result<(), CliError> {
        let faults = node::verify(&self.file)?;
        let file = self.file.display();
        if self.json {
            output::print_json(&serde_json::json!({ "file": self.file, "faults": faults }))?;
        } else if faults.is_empty() {
            output::print(&format!(
                "{file} is whole: checksums, index, times, and every message of every topic\n"
            ))?;
        } else {
            let lines: Vec<_> = faults.iter().map(|fault| format!("{fault}\n")).collect();
            output::print(&lines.concat())?;
        }
        match faults.len() {
            0 => Ok(()),
            count => Err(CliError::Faulty {
                file: self.file.clone(),
                count,
            }),
        }
    }
}
