//! Where a scene comes from: built in, a TOML file, or standard input.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use super::CliError;
use crate::scene::{Origin, Override, Scene, SceneError, Warning, library, parse};

/// Most bytes of a scene; the built-in ones have about two thousand.
const LONGEST: u64 = 1 << 20;

/// Reads and checks the scene that the user named, with the overrides put in.
pub(super) fn scene(name: &str, overrides: &[Override]) -> Result<(Scene, Vec<Warning>), CliError> {
    let text = match library::text(name) {
        Some(text) => text.to_string(),
        None => read(name)?,
    };
    parse(&text, overrides).map_err(|error| within(name, error))
}

/// An error of the document names the document; one of an override names the override already.
fn within(name: &str, error: SceneError) -> CliError {
    let name = match name {
        "-" => "standard input",
        name => name,
    };
    match error.origin {
        Origin::Override(_) => error.into(),
        Origin::Line(_) | Origin::Document => CliError::Input(format!("{name}: {error}")),
    }
}

fn read(name: &str) -> Result<String, CliError> {
    let failed = |error: io::Error| CliError::Input(format!("cannot read scene {name}: {error}"));
    if name == "-" {
        return text("scene -", io::stdin().lock());
    }
    if !Path::new(name).exists() {
        let known: Vec<_> = library::names().collect();
        return Err(CliError::Input(format!(
            "{name} is neither a file nor a built-in scene ({})",
            known.join(", ")
        )));
    }
    text(&format!("scene {name}"), File::open(name).map_err(failed)?)
}

/// The text of a file of the user's.
pub(super) fn file(path: &Path) -> Result<String, CliError> {
    let name = path.display().to_string();
    let file = File::open(path)
        .map_err(|error| CliError::Input(format!("cannot open {name}: {error}")))?;
    text(&name, file)
}

fn text(name: &str, source: impl Read) -> Result<String, CliError> {
    let refuse = |reason: &str| CliError::Input(format!("cannot read {name}: {reason}"));
    let mut bytes = vec![];
    source
        .take(LONGEST + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| refuse(&error.to_string()))?;
    if bytes.len() as u64 > LONGEST {
        return Err(refuse("it is longer than 1 MiB"));
    }
    String::from_utf8(bytes).map_err(|_| refuse("it is not UTF-8 text"))
}
