//! The fabric that a laboratory verb works on: of the catalogue, or of a file, with single constants replaced.

use std::fs;
use std::path::Path;

use serde::Deserialize;

use super::CliError;
use crate::fabric;
use crate::scene::{FabricSpec, Override, library, parse};

/// The one table of a document that counts here: a scene's fabric, or what `toile identify` prints.
#[derive(Deserialize)]
struct Document {
    fabric: toml::Table,
}

/// Reads and checks a fabric as strictly as that of a scene.
pub(super) fn fabric(name: &str, set: &[String]) -> Result<FabricSpec, CliError> {
    let mut overrides = match fabric::find(name) {
        Some(_) => vec![Override::new(
            "fabric.name",
            name,
            &format!("--fabric {name}"),
        )],
        None => read(name)?,
    };
    for text in set {
        if !text.starts_with("fabric.") {
            return Err(CliError::Input(format!(
                "--set {text}: an instrument takes only keys of the fabric, such as fabric.poisson=symmetrised"
            )));
        }
        overrides.push(Override::parse(text)?);
    }
    // Any scene will do: what matters is that its checks pass over the fabric.
    let base = library::text("free-fall").unwrap_or_default();
    let (scene, _) = parse(base, &overrides)?;
    Ok(scene.fabric)
}

fn read(name: &str) -> Result<Vec<Override>, CliError> {
    if !Path::new(name).exists() {
        let known: Vec<_> = fabric::catalogue().into_iter().map(|f| f.name).collect();
        return Err(CliError::Input(format!(
            "--fabric {name}: neither of the catalogue ({}) nor a file",
            known.join(", ")
        )));
    }
    let refuse = |reason: String| CliError::Input(format!("cannot read fabric {name}: {reason}"));
    let text = fs::read_to_string(name).map_err(|error| refuse(error.to_string()))?;
    let document: Document = toml::from_str(&text).map_err(|error| refuse(one_line(&error)))?;
    let constant = |(key, value): (&String, &toml::Value)| {
        let (key, value) = (format!("fabric.{key}"), value.to_string());
        Override::new(&key, &value, &format!("{name}: {key} = {value}"))
    };
    Ok(document.fabric.iter().map(constant).collect())
}

/// What is wrong with a document, without the excerpt that TOML's messages carry.
pub(super) fn one_line(error: &toml::de::Error) -> String {
    error
        .message()
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
}
