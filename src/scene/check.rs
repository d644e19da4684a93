//! The document against the key table: unknown, missing, mistyped, out of range.

use std::collections::BTreeMap;

use super::error::{Problem, SceneError};
use super::keys::{Key, Kind, names};
use super::ranges::{NAME, Range, is_name};
use super::spelling::nearest;
use super::tree::{Node, Value};

/// Checks a table and all below it; the first refusal ends it.
pub(super) fn table(node: &Node, path: &str, keys: &[Key]) -> Result<(), SceneError> {
    let entries = entries(node, path, || format!("a table of {}", names(keys)))?;
    known(entries, path, keys, &[])?;
    each(node, entries, path, keys)
}

/// Refuses keys that are neither in the table nor among `also`.
fn known(
    entries: &BTreeMap<String, Node>,
    path: &str,
    keys: &[Key],
    also: &[&'static str],
) -> Result<(), SceneError> {
    let allowed: Vec<_> = also
        .iter()
        .copied()
        .chain(keys.iter().map(|key| key.name))
        .collect();
    for (name, node) in entries {
        if !allowed.contains(&name.as_str()) {
            let problem = Problem::UnknownKey {
                allowed: allowed.join(", "),
                suggestion: nearest(name, &allowed),
            };
            return Err(refuse(node, &join(path, name), problem));
        }
    }
    Ok(())
}

/// Checks every key of the table that is present, and that no required one is absent.
fn each(
    node: &Node,
    entries: &BTreeMap<String, Node>,
    path: &str,
    keys: &[Key],
) -> Result<(), SceneError> {
    for key in keys {
        let path = join(path, key.name);
        match entries.get(key.name) {
            Some(entry) => value(entry, &path, &key.kind)?,
            None if key.required => return Err(missing(node, path, key.kind.expected())),
            None => {}
        }
    }
    Ok(())
}

fn value(node: &Node, path: &str, kind: &Kind) -> Result<(), SceneError> {
    let expected = || kind.expected();
    let in_range = |good: bool| match good {
        true => Ok(()),
        false => Err(out_of_range(node, path, expected())),
    };
    match kind {
        Kind::Number(range) => {
            let number = number(node, path, &expected)?;
            in_range(range.contains(number))
        }
        Kind::Count(min, max) => match &node.value {
            Value::Leaf(toml::Value::Integer(value)) => in_range((min..=max).contains(&value)),
            Value::HugeInteger(_) => in_range(false),
            _ => Err(wrong_type(node, path, expected())),
        },
        Kind::Vector(count, range) => {
            let numbers = numbers(node, path, *count, &expected)?;
            in_range(numbers.iter().all(|value| range.contains(*value)))
        }
        Kind::Points(range) => rows(node, path, 2, range, &expected),
        Kind::Triples(range) => rows(node, path, 3, range, &expected),
        Kind::Corners => corners(node, path, &expected),
        Kind::Series(range) => {
            for item in items(node, path, &expected)? {
                if !range.contains(number(item, path, &expected)?) {
                    return Err(out_of_range(item, path, expected()));
                }
            }
            Ok(())
        }
        Kind::Text(longest) => {
            let text = text(node, path, &expected)?;
            let length = text.chars().count();
            let one_line = !text.chars().any(char::is_control);
            in_range(one_line && (1..=*longest).contains(&length))
        }
        Kind::FileName => in_range(is_file_name(text(node, path, &expected)?)),
        Kind::Axes => in_range(is_axes(text(node, path, &expected)?)),
        Kind::Choice(words) => choice(node, path, words, &expected),
        Kind::Some(words) => some(node, path, words, &expected),
        Kind::Table(keys) => table(node, path, keys),
        Kind::Named(keys) => named(node, path, keys),
        Kind::Tagged(variants) => tagged(node, path, variants, &expected),
    }
}

/// The entries of an array that must not be empty.
fn items<'a>(
    node: &'a Node,
    path: &str,
    expected: &dyn Fn() -> String,
) -> Result<&'a [Node], SceneError> {
    match &node.value {
        Value::Array(items) if items.is_empty() => Err(out_of_range(node, path, expected())),
        Value::Array(items) => Ok(items),
        _ => Err(wrong_type(node, path, expected())),
    }
}

/// An array of arrays of `count` numbers each.
fn rows(
    node: &Node,
    path: &str,
    count: usize,
    range: &Range,
    expected: &dyn Fn() -> String,
) -> Result<(), SceneError> {
    for row in items(node, path, expected)? {
        let numbers = numbers(row, path, count, expected)?;
        if !numbers.iter().all(|value| range.contains(*value)) {
            return Err(out_of_range(row, path, expected()));
        }
    }
    Ok(())
}

/// An array of arrays of three whole numbers that are not negative.
fn corners(node: &Node, path: &str, expected: &dyn Fn() -> String) -> Result<(), SceneError> {
    for row in items(node, path, expected)? {
        let whole = |node: &Node| match &node.value {
            Value::Leaf(toml::Value::Integer(index)) => u32::try_from(*index).is_ok(),
            _ => false,
        };
        let three = match &row.value {
            Value::Array(items) => items.len() == 3 && items.iter().all(whole),
            _ => return Err(wrong_type(row, path, expected())),
        };
        if !three {
            return Err(out_of_range(row, path, expected()));
        }
    }
    Ok(())
}

/// A table of tables under names of the user's choice.
fn named(node: &Node, path: &str, keys: &[Key]) -> Result<(), SceneError> {
    let entries = entries(node, path, || Kind::Named(&[]).expected())?;
    for (name, entry) in entries {
        let path = join(path, name);
        if !is_name(name) {
            let reason = format!("is not a name: must be {NAME}");
            return Err(refuse_key(entry, &path, Problem::Conflict(reason)));
        }
        table(entry, &path, keys)?;
    }
    Ok(())
}

/// A table whose `kind` decides what else is in it.
fn tagged(
    node: &Node,
    path: &str,
    variants: &[(&'static str, &'static [Key])],
    expected: &dyn Fn() -> String,
) -> Result<(), SceneError> {
    let entries = entries(node, path, expected)?;
    let kinds: Vec<_> = variants.iter().map(|(kind, _)| *kind).collect();
    let kind_path = join(path, "kind");
    let one_of = || format!("one of {}", kinds.join(", "));
    let Some(kind) = entries.get("kind") else {
        return Err(missing(node, kind_path, one_of()));
    };
    choice(kind, &kind_path, &kinds, &one_of)?;
    let keys = variants
        .iter()
        .find(|(name, _)| Some(*name) == kind.text())
        .map_or(&[][..], |(_, keys)| *keys);
    known(entries, path, keys, &["kind"])?;
    each(node, entries, path, keys)
}

fn choice(
    node: &Node,
    path: &str,
    words: &[&'static str],
    expected: &dyn Fn() -> String,
) -> Result<(), SceneError> {
    let word = text(node, path, expected)?;
    if words.contains(&word) {
        return Ok(());
    }
    let problem = Problem::NotAChoice {
        expected: expected(),
        suggestion: nearest(word, words),
    };
    Err(refuse(node, path, problem))
}

/// An array of choices without repetition.
fn some(
    node: &Node,
    path: &str,
    words: &[&'static str],
    expected: &dyn Fn() -> String,
) -> Result<(), SceneError> {
    let Value::Array(items) = &node.value else {
        return Err(wrong_type(node, path, expected()));
    };
    for (i, item) in items.iter().enumerate() {
        choice(item, path, words, expected)?;
        if items[..i].iter().any(|other| other.text() == item.text()) {
            return Err(out_of_range(node, path, expected()));
        }
    }
    Ok(())
}

fn entries<'a>(
    node: &'a Node,
    path: &str,
    expected: impl Fn() -> String,
) -> Result<&'a BTreeMap<String, Node>, SceneError> {
    match &node.value {
        Value::Table(entries) => Ok(entries),
        _ => Err(wrong_type(node, path, expected())),
    }
}

fn number(node: &Node, path: &str, expected: &dyn Fn() -> String) -> Result<f64, SceneError> {
    node.number()
        .ok_or_else(|| wrong_type(node, path, expected()))
}

fn numbers(
    node: &Node,
    path: &str,
    count: usize,
    expected: &dyn Fn() -> String,
) -> Result<Vec<f64>, SceneError> {
    match &node.value {
        Value::Array(items) if items.len() == count => items
            .iter()
            .map(|item| number(item, path, expected))
            .collect(),
        Value::Array(_) => Err(out_of_range(node, path, expected())),
        _ => Err(wrong_type(node, path, expected())),
    }
}

fn text<'a>(
    node: &'a Node,
    path: &str,
    expected: &dyn Fn() -> String,
) -> Result<&'a str, SceneError> {
    node.text()
        .ok_or_else(|| wrong_type(node, path, expected()))
}

/// A name that becomes the stem of the recording, so no separators and no leading dot or dash.
fn is_file_name(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    name.starts_with(|c: char| c.is_ascii_alphanumeric())
        && name.chars().all(plain)
        && name.len() <= 64
}

fn is_axes(axes: &str) -> bool {
    let once = |axis: char| axes.chars().filter(|c| *c == axis).count() == 1;
    !axes.is_empty() && axes.chars().all(|c| "xyz".contains(c) && once(c))
}

fn join(path: &str, name: &str) -> String {
    match path {
        "" => name.to_string(),
        _ => format!("{path}.{name}"),
    }
}

/// The refusal of a value.
pub(super) fn refuse(node: &Node, path: &str, problem: Problem) -> SceneError {
    SceneError {
        value: Some(node.shown()),
        ..refuse_key(node, path, problem)
    }
}

/// The refusal of a key, whatever its value.
pub(super) fn refuse_key(node: &Node, path: &str, problem: Problem) -> SceneError {
    SceneError {
        origin: node.origin.clone(),
        key: path.to_string(),
        value: None,
        problem: Box::new(problem),
    }
}

fn missing(table: &Node, path: String, expected: String) -> SceneError {
    refuse_key(table, &path, Problem::Missing { expected })
}

fn wrong_type(node: &Node, path: &str, expected: String) -> SceneError {
    let found = node.type_name();
    refuse(node, path, Problem::WrongType { expected, found })
}

fn out_of_range(node: &Node, path: &str, expected: String) -> SceneError {
    refuse(node, path, Problem::OutOfRange { expected })
}
