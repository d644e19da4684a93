//! Text and overrides in, checked scene out; and back.

use serde::Deserialize;

use super::check;
use super::cross;
use super::error::{Origin, Problem, SceneError};
use super::keys::SCENE;
use super::meshes::{self, Reader};
use super::method::OutputSpec;
use super::overrides::{self, Override};
use super::spec::Scene;
use super::tree::{Node, Value};
use super::warning::{Warning, warnings};

/// Reads a scene from TOML with overrides put in, and checks it.
pub fn parse(text: &str, overrides: &[Override]) -> Result<(Scene, Vec<Warning>), SceneError> {
    parse_with(text, overrides, &meshes::no_files)
}

/// The same for a scene that may name files of triangles, which `read` reads.
pub fn parse_with(
    text: &str,
    overrides: &[Override],
    read: Reader,
) -> Result<(Scene, Vec<Warning>), SceneError> {
    let mut document = Node::document(text)?;
    overrides::apply(&mut document, overrides)?;
    from_document(&mut document, read)
}

impl Scene {
    /// Checks a scene made by the program as strictly as one that was read.
    pub fn check(&self) -> Result<Vec<Warning>, SceneError> {
        let value = toml::Value::try_from(self).map_err(|error| internal(&error.to_string()))?;
        let mut document = Node::from_value(value, &Origin::Document);
        from_document(&mut document, &meshes::no_files).map(|(_, warnings)| warnings)
    }

    /// The scene as TOML, every key written out; [`parse`] gives the same scene back.
    ///
    /// # Panics
    /// If a seed exceeds the 63 bits of a TOML integer, which [`Scene::check`] refuses.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("a checked scene is TOML")
    }
}

fn from_document(document: &mut Node, read: Reader) -> Result<(Scene, Vec<Warning>), SceneError> {
    check::table(document, "", SCENE)?;
    meshes::load(document, read)?;
    fit_default_rate(document);
    let scene =
        Scene::deserialize(document.to_value()).map_err(|error| internal(&error.to_string()))?;
    cross::check(&scene, document)?;
    let warnings = warnings(&scene);
    Ok((scene, warnings))
}

/// A scene that says nothing of its output rate gets the default, or every step if steps are longer.
fn fit_default_rate(document: &mut Node) {
    let (rate, given) = document.find("output.rate");
    let (dt, longer) = document.find("method.dt");
    let Some(dt) = dt.number().filter(|_| longer && !given) else {
        return;
    };
    let origin = rate.origin.clone();
    if dt * OutputSpec::default().rate <= 1.0 {
        return;
    }
    let rate = Node::from_value(toml::Value::Float(1.0 / dt), &origin);
    if let Value::Table(entries) = &mut document.value {
        let output = entries.entry("output".to_string()).or_insert_with(|| Node {
            value: Value::Table(Default::default()),
            origin,
        });
        if let Value::Table(output) = &mut output.value {
            output.insert("rate".to_string(), rate);
        }
    }
}

/// The key table let something through that the scene's type does not take (or seeds beyond 63 bits).
fn internal(reason: &str) -> SceneError {
    let reason: Vec<_> = reason.split_whitespace().collect();
    SceneError {
        origin: Origin::Document,
        key: String::new(),
        value: None,
        problem: Box::new(Problem::Conflict(reason.join(" "))),
    }
}
