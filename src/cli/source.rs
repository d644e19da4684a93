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
    triangles(&folder.unwrap_or(Path::new("")).join(file))
}

/// The bytes of a file of triangles; an error is one line with its path.
pub(super) fn triangles(path: &Path) -> Result<Vec<u8>, String> {
    let failed = |reason: String| format!("cannot read {}: {reason}", path.display());
    let file = File::open(path).map_err(|error| failed(error.to_string()))?;
    bounded(file, LARGEST).map_err(failed)
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

/// All bytes of a source that has at most so many, a number of MiB.
fn bounded(source: impl Read, most: u64) -> Result<Vec<u8>, String> {
    let mut bytes = vec![];
    let read = source.take(most + 1).read_to_end(&mut bytes);
    read.map_err(|error| error.to_string())?;
    match bytes.len() as u64 > most {
        true => Err(format!("it is longer than {} MiB", most >> 20)),
        false => Ok(bytes),
    }
}

fn text(name: &str, source: impl Read) -> Result<String, CliError> {
    let refuse = |reason: &str| CliError::Input(format!("cannot read {name}: {reason}"));
    let bytes = bounded(source, LONGEST).map_err(|reason| refuse(&reason))?;
    String::from_utf8(bytes).map_err(|_| refuse("it is not UTF-8 text"))
}
