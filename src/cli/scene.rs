//! `toile scene`: the TOML of a built-in scene.

use clap::Args;

use super::{CliError, output};
use crate::scene::library;

/// Arguments of `toile scene`.
#[derive(Args)]
pub(super) struct SceneArgs {
    /// Name of a built-in scene (see `toile list scenes`).
    name: String,
}

impl SceneArgs {
    pub(super) fn run(&self) -> Result<(), CliError> {
        match library::text(&self.name) {
            Some(text) => output::print(text),
            None => {
                let known: Vec<_> = library::names().collect();
                let message = format!(
                    "{} is not a built-in scene ({})",
                    self.name,
                    known.join(", ")
                );
                Err(CliError::Input(message))
            }
        }
    }
}
