//! Obstacles that are triangle meshes: files are read into the document, so that a scene needs none once it is read.

use std::collections::BTreeMap;

use super::check::{refuse, refuse_key};
use super::error::{Origin, Problem, SceneError};
use super::tree::{Node, Value};
use crate::contact::Surface;
use crate::contact::surface::Triangles;

/// Reads a file that a scene names; an error is a reason in a few words.
pub type Reader<'a> = &'a dyn Fn(&str) -> Result<Vec<u8>, String>;

/// The reader of a scene that stands alone.
pub(super) fn no_files(_: &str) -> Result<Vec<u8>, String> {
    Err("no files can be read here; give vertices and triangles instead".to_string())
}

/// Replaces every file by its triangles, and checks all triangles.
pub(super) fn load(document: &mut Node, read: Reader) -> Result<(), SceneError> {
    let Some(obstacles) = document.entries_mut("obstacle") else {
        return Ok(());
    };
    for (name, obstacle) in obstacles {
        let key = format!("obstacle.{name}.shape");
        let origin = obstacle.find("shape").0.origin.clone();
        let Some(keys) = obstacle.entries_mut("shape") else {
            continue;
        };
        if keys.get("kind").and_then(Node::text) == Some("mesh") {
            mesh(keys, &origin, &key, read)?;
        }
    }
    Ok(())
}

fn mesh(
    keys: &mut BTreeMap<String, Node>,
    origin: &Origin,
    key: &str,
    read: Reader,
) -> Result<(), SceneError> {
    let conflict = |reason: &str| Problem::Conflict(reason.to_string());
    let written = ["vertices", "triangles"].map(|name| keys.contains_key(name));
    let Some(file) = keys.remove("file") else {
        if let Some(scale) = keys.get("scale") {
            let reason = conflict("goes with file alone; vertices are in metres");
            return Err(refuse(scale, &format!("{key}.scale"), reason));
        }
        if written != [true; 2] {
            return Err(SceneError {
                origin: origin.clone(),
                key: key.to_string(),
                value: None,
                problem: Box::new(conflict(
                    "needs file (an STL or OBJ), or vertices and triangles",
                )),
            });
        }
        return inline(keys, key);
    };
    let path = format!("{key}.file");
    if written != [false; 2] {
        let reason = conflict("give a file, or vertices and triangles, not both");
        return Err(refuse(&file, &path, reason));
    }
    let scale = keys
        .remove("scale")
        .and_then(|node| node.number())
        .unwrap_or(1.0);
    let bytes = read(file.text().unwrap_or_default())
        .map_err(|reason| refuse(&file, &path, Problem::Conflict(reason)))?;
    let surface = Surface::read(&bytes, scale)
        .map_err(|error| refuse(&file, &path, Problem::Surface(error)))?;
    let Triangles {
        vertices,
        triangles,
    } = surface.into();
    let numbers = |list: Vec<toml::Value>| toml::Value::Array(list);
    let vertices = vertices
        .iter()
        .map(|p| numbers(p.map(toml::Value::Float).to_vec()));
    let whole = |index: u32| toml::Value::Integer(index.into());
    let triangles = triangles.iter().map(|t| numbers(t.map(whole).to_vec()));
    for (name, list) in [
        ("vertices", vertices.collect()),
        ("triangles", triangles.collect()),
    ] {
        let node = Node {
            value: Value::Leaf(numbers(list)),
            origin: file.origin.clone(),
        };
        keys.insert(name.to_string(), node);
    }
    Ok(())
}

/// Checks triangles that are written in the scene.
fn inline(keys: &BTreeMap<String, Node>, key: &str) -> Result<(), SceneError> {
    let entries = ["vertices", "triangles"].map(|name| (name.to_string(), keys[name].to_value()));
    let table = toml::Value::Table(entries.into_iter().collect());
    let path = format!("{key}.triangles");
    let given: Triangles = table.try_into().map_err(|error: toml::de::Error| {
        let reason = Problem::Conflict(error.message().to_string());
        refuse_key(&keys["triangles"], &path, reason)
    })?;
    match Surface::try_from(given) {
        Ok(_) => Ok(()),
        Err(error) => Err(refuse_key(
            &keys["triangles"],
            &path,
            Problem::Surface(error),
        )),
    }
}
