//! The document as a tree of values that remember where they were written.

use std::collections::BTreeMap;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::error::{Origin, Problem, SceneError};

/// A value and where it was written.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub value: Value,
    pub origin: Origin,
}

/// A value of the document.
#[derive(Clone, Debug)]
pub(super) enum Value {
    Table(BTreeMap<String, Node>),
    Array(Vec<Node>),
    /// Anything without parts.
    Leaf(toml::Value),
    /// A whole number beyond 64 bits, as written.
    HugeInteger(String),
}

impl Node {
    /// Reads a document.
    pub(super) fn document(text: &str) -> Result<Node, SceneError> {
        let table = DeTable::parse(text).map_err(|error| syntax(text, &error))?;
        Ok(Node {
            value: Value::Table(entries(table.get_ref(), text)),
            origin: Origin::Document,
        })
    }

    /// Takes a value made by the program.
    pub(super) fn from_value(value: toml::Value, origin: &Origin) -> Node {
        let value = match value {
            toml::Value::Table(table) => Value::Table(
                table
                    .into_iter()
                    .map(|(key, value)| (key, Node::from_value(value, origin)))
                    .collect(),
            ),
            toml::Value::Array(items) => Value::Array(
                items
                    .into_iter()
                    .map(|item| Node::from_value(item, origin))
                    .collect(),
            ),
            leaf => Value::Leaf(leaf),
        };
        Node {
            value,
            origin: origin.clone(),
        }
    }

    /// The same value, written elsewhere.
    pub(super) fn with_origin(&self, origin: &Origin) -> Node {
        let value = match &self.value {
            Value::Table(table) => Value::Table(
                table
                    .iter()
                    .map(|(key, node)| (key.clone(), node.with_origin(origin)))
                    .collect(),
            ),
            Value::Array(items) => {
                Value::Array(items.iter().map(|item| item.with_origin(origin)).collect())
            }
            leaf => leaf.clone(),
        };
        Node {
            value,
            origin: origin.clone(),
        }
    }

    /// The plain value, for serde.
    pub(super) fn to_value(&self) -> toml::Value {
        match &self.value {
            Value::Table(table) => toml::Value::Table(
                table
                    .iter()
                    .map(|(key, node)| (key.clone(), node.to_value()))
                    .collect(),
            ),
            Value::Array(items) => toml::Value::Array(items.iter().map(Node::to_value).collect()),
            Value::Leaf(leaf) => leaf.clone(),
            Value::HugeInteger(text) => toml::Value::String(text.clone()),
        }
    }

    /// The value as one short line of TOML.
    pub(super) fn shown(&self) -> String {
        let text = match &self.value {
            Value::HugeInteger(text) => text.clone(),
            _ => one_line(&self.to_value()),
        };
        match text.char_indices().nth(60) {
            Some((cut, _)) => format!("{}...", &text[..cut]),
            None => text,
        }
    }

    /// The TOML type, with an article.
    pub(super) fn type_name(&self) -> &'static str {
        match &self.value {
            Value::Table(_) => "a table",
            Value::Array(_) => "an array",
            Value::HugeInteger(_) => "a whole number beyond 64 bits",
            Value::Leaf(leaf) => match leaf {
                toml::Value::String(_) => "a string",
                toml::Value::Integer(_) => "a whole number",
                toml::Value::Float(_) => "a number",
                toml::Value::Boolean(_) => "a boolean",
                _ => "a date",
            },
        }
    }

    /// Whether the value is short enough to say something in a message: no table.
    pub(super) fn is_leaf(&self) -> bool {
        !matches!(self.value, Value::Table(_))
    }

    /// The number, if it is one.
    pub(super) fn number(&self) -> Option<f64> {
        match &self.value {
            Value::Leaf(toml::Value::Float(value)) => Some(*value),
            Value::Leaf(toml::Value::Integer(value)) => Some(*value as f64),
            _ => None,
        }
    }

    /// The text, if it is text.
    pub(super) fn text(&self) -> Option<&str> {
        match &self.value {
            Value::Leaf(toml::Value::String(text)) => Some(text),
            _ => None,
        }
    }

    /// The entries of a table in this one.
    pub(super) fn entries_mut(&mut self, key: &str) -> Option<&mut BTreeMap<String, Node>> {
        let Value::Table(table) = &mut self.value else {
            return None;
        };
        match &mut table.get_mut(key)?.value {
            Value::Table(entries) => Some(entries),
            _ => None,
        }
    }

    /// Where the value under a dotted key was written; the nearest table above it if it is absent.
    pub(super) fn find(&self, key: &str) -> (&Node, bool) {
        let mut node = self;
        for part in key.split('.') {
            match &node.value {
                Value::Table(table) if table.contains_key(part) => node = &table[part],
                _ => return (node, false),
            }
        }
        (node, true)
    }
}

/// `toml::Value` displays tables over several lines; messages want one.
fn one_line(value: &toml::Value) -> String {
    match value {
        toml::Value::Table(table) => {
            let entries: Vec<_> = table
                .iter()
                .map(|(key, value)| format!("{key} = {}", one_line(value)))
                .collect();
            match entries.is_empty() {
                true => "{}".to_string(),
                false => format!("{{ {} }}", entries.join(", ")),
            }
        }
        toml::Value::Array(items) => {
            let items: Vec<_> = items.iter().map(one_line).collect();
            format!("[{}]", items.join(", "))
        }
        toml::Value::String(text) => format!("\"{}\"", text.escape_debug()),
        toml::Value::Float(value) => super::quantity::short(*value),
        other => other.to_string(),
    }
}

fn entries(table: &DeTable<'_>, text: &str) -> BTreeMap<String, Node> {
    table
        .iter()
        .map(|(key, value)| {
            let origin = Origin::Line(line(text, key.span().start));
            let node = Node {
                value: convert(value, text),
                origin,
            };
            (key.get_ref().to_string(), node)
        })
        .collect()
}

fn convert(value: &Spanned<DeValue<'_>>, text: &str) -> Value {
    match value.get_ref() {
        DeValue::Table(table) => Value::Table(entries(table, text)),
        DeValue::Array(items) => Value::Array(
            items
                .iter()
                .map(|item| Node {
                    value: convert(item, text),
                    origin: Origin::Line(line(text, item.span().start)),
                })
                .collect(),
        ),
        DeValue::String(string) => Value::Leaf(toml::Value::String(string.to_string())),
        DeValue::Integer(integer) => match i64::from_str_radix(integer.as_str(), integer.radix()) {
            Ok(value) => Value::Leaf(toml::Value::Integer(value)),
            Err(_) => Value::HugeInteger(integer.to_string()),
        },
        // What the TOML grammar calls a float and Rust does not read, no range holds either.
        DeValue::Float(float) => Value::Leaf(toml::Value::Float(
            float.as_str().parse().unwrap_or(f64::NAN),
        )),
        DeValue::Boolean(value) => Value::Leaf(toml::Value::Boolean(*value)),
        DeValue::Datetime(value) => Value::Leaf(toml::Value::Datetime(*value)),
    }
}

fn syntax(text: &str, error: &toml::de::Error) -> SceneError {
    let origin = match error.span() {
        Some(span) => Origin::Line(line(text, span.start)),
        None => Origin::Document,
    };
    let reason: Vec<_> = error.message().split_whitespace().collect();
    SceneError {
        origin,
        key: String::new(),
        value: None,
        problem: Box::new(Problem::Syntax(reason.join(" "))),
    }
}

/// Line of a byte offset, from 1.
fn line(text: &str, offset: usize) -> usize {
    let before = &text.as_bytes()[..offset.min(text.len())];
    1 + before.iter().filter(|&&byte| byte == b'\n').count()
}
