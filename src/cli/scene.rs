//! `toile scene`: a built-in scene as TOML, or the physics that a scene needs.

use clap::Args;

use super::{CliError, output, source};
use crate::scene::{Term, library, needs};

/// Arguments of `toile scene`.
#[derive(Args)]
pub(super) struct SceneArgs {
    /// Name of a built-in scene (see `toile list scenes`); with --needs also a TOML file or `-`.
    scene: String,
    /// Instead of the TOML, which physics the scene pays for, and why.
    #[arg(long)]
    needs: bool,
}

impl SceneArgs {
    pub(super) fn run(&self) -> Result<(), CliError> {
        if self.needs {
            return self.explain();
        }
        match library::text(&self.scene) {
            Some(text) => output::print(text),
            None => {
                let known: Vec<_> = library::names().collect();
                let message = format!(
                    "{} is not a built-in scene ({})",
                    self.scene,
                    known.join(", ")
                );
                Err(CliError::Input(message))
            }
        }
    }

    /// Every term: the reason for it, or that it is left out.
    fn explain(&self) -> Result<(), CliError> {
        let (scene, _) = source::scene(&self.scene, &[])?;
        let needs = needs(&scene);
        let row = |term: Term| {
            let kept = needs.iter().find(|(needed, _)| *needed == term);
            let reason = kept.map_or("left out: it costs nothing", |(_, reason)| reason);
            vec![term.name().to_string(), reason.to_string()]
        };
        output::print(&output::table(&Term::ALL.map(row)))
    }
}
