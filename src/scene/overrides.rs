//! Overrides: single keys replaced from outside the document.

use std::collections::BTreeMap;

use super::error::{Origin, Problem, SceneError};
use super::tree::{Node, Value};

/// A key of the scene given from outside the document, usually on the command line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Override {
    /// Dotted key.
    key: String,
    /// TOML value, or plain text.
    value: String,
    /// How the user wrote it.
    shown: String,
}

impl Override {
    /// The override that an option stands for, such as `method.dt` for `--dt 1e-3`.
    pub fn new(key: &str, value: &str, shown: &str) -> Self {
        Self {
            key: key.to_string(),
            value: value.to_string(),
            shown: shown.to_string(),
        }
    }

    /// Reads `KEY=VALUE` as given to `--set`.
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        let shown = format!("--set {text}");
        match text.split_once('=') {
            Some((key, value)) => Ok(Self::new(key.trim(), value.trim(), &shown)),
            None => Err(SceneError {
                origin: Origin::Override(shown),
                key: String::new(),
                value: None,
                problem: Box::new(Problem::Conflict(
                    "must be KEY=VALUE, such as damping=0 or fabric.name=F5".to_string(),
                )),
            }),
        }
    }

    /// Keys of the document that this override takes the place of, besides its own.
    ///
    /// A document's constants describe its own fabric, not the one named instead; a mesh is given by
    /// triangles or by edge length; a new kind of outline, region or shape has other sizes.
    fn displaces(&self, sibling: &str) -> bool {
        let (table, key) = self.key.rsplit_once('.').unwrap_or(("", &self.key));
        match (table, key) {
            ("fabric", "name") => !matches!(sibling, "twist" | "poisson"),
            ("sheet", "edge") => sibling == "triangles",
            ("sheet", "triangles") => sibling == "edge",
            (_, "kind") => ["outline", "region", "shape"]
                .iter()
                .any(|tagged| table.ends_with(tagged)),
            _ => false,
        }
    }

    fn error(&self, key: &str, problem: Problem) -> SceneError {
        SceneError {
            origin: Origin::Override(self.shown.clone()),
            key: key.to_string(),
            value: None,
            problem: Box::new(problem),
        }
    }

    /// The value as TOML, or as text if it is not TOML, so that `fabric.name=F5` needs no quotes.
    fn node(&self) -> Node {
        let origin = Origin::Override(self.shown.clone());
        let document = format!("value = {}", self.value);
        let parsed = Node::document(&document)
            .ok()
            .and_then(|node| match node.value {
                Value::Table(mut table) if table.len() == 1 => table.remove("value"),
                _ => None,
            });
        match parsed {
            Some(node) => node.with_origin(&origin),
            None => Node {
                value: Value::Leaf(toml::Value::String(self.value.clone())),
                origin,
            },
        }
    }
}

/// Puts overrides into a document, later ones over earlier ones.
pub(super) fn apply(document: &mut Node, overrides: &[Override]) -> Result<(), SceneError> {
    for change in overrides {
        let table = parent(document, change)?;
        // Only what the document says is displaced: of two overrides neither undoes the other.
        table.retain(|key, node| {
            matches!(node.origin, Origin::Override(_)) || !change.displaces(key)
        });
    }
    for change in overrides {
        let key = change.key.rsplit('.').next().unwrap_or(&change.key);
        parent(document, change)?.insert(key.to_string(), change.node());
    }
    Ok(())
}

/// The table that holds the key, made if need be.
fn parent<'a>(
    document: &'a mut Node,
    change: &Override,
) -> Result<&'a mut BTreeMap<String, Node>, SceneError> {
    let parts: Vec<_> = change.key.split('.').collect();
    if parts.iter().any(|part| part.is_empty()) {
        let reason = format!("`{}` is not a dotted key such as method.dt", change.key);
        return Err(change.error("", Problem::Conflict(reason)));
    }
    let mut node = document;
    for depth in 0..parts.len() - 1 {
        let table = table_of(node, &parts[..depth], change)?;
        node = table
            .entry(parts[depth].to_string())
            .or_insert_with(|| Node {
                value: Value::Table(BTreeMap::new()),
                origin: Origin::Override(change.shown.clone()),
            });
    }
    table_of(node, &parts[..parts.len() - 1], change)
}

fn table_of<'a>(
    node: &'a mut Node,
    path: &[&str],
    change: &Override,
) -> Result<&'a mut BTreeMap<String, Node>, SceneError> {
    let found = node.type_name();
    match &mut node.value {
        Value::Table(table) => Ok(table),
        _ => {
            let expected = "a table".to_string();
            Err(change.error(&path.join("."), Problem::WrongType { expected, found }))
        }
    }
}
