//! Where a scene comes from: built in, a TOML file, or standard input.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use super::CliError;
use crate::scene::{Origin, Override, Scene, SceneError, Warning, library, parse_with};

/// Most bytes of a file of triangles.
const LARGEST: u64 = 64 << 20;
/// Most bytes of a scene; the built-in ones have about two thousand.
const LONGEST: u64 = 1 << 20;

/// Reads and checks the scene that the user named, with the overrides put in.
pub(super) fn scene(name: &str, overrides: &[Override]) -> Result<(Scene, Vec<Warning>), CliError> {
    let text = match library::text(name) {
        Some(text) => text.to_string(),
        None => read(name)?,
    };
    parse_with(&text, overrides, &|file| beside(name, file)).map_err(|error| within(name, error))
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

/// Reads a file whose path in a scene starts from where the scene is.
fn beside(scene: &str, file: &str) -> Result<Vec<u8>, String> {
    let folder = match scene {
        "-" => None,
        scene => Path::new(scene).parent(),
    };
    let path = folder.unwrap_or(Path::new("")).join(file);
    let failed = |error: io::Error| format!("cannot read {}: {error}", path.display());
    let mut bytes = vec![];
    let mut source = File::open(&path).map_err(failed)?.take(LARGEST + 1);
    source.read_to_end(&mut bytes).map_err(failed)?;
    match bytes.len() as u64 > LARGEST {
        true => Err(format!("{} is longer than 64 MiB", path.display())),
        false => Ok(bytes),
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
