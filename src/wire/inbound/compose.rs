//! A message from its fields by name, for who writes commands by hand.

use serde_json::Value;

use crate::wire::{Message, cdr};

/// The bytes of a message with these fields; fields that are not given are zero or empty. Elements of lists are
/// given whole. An error is one line that names the field.
pub(super) fn compose<M: Message + Default>(fields: &Value) -> Result<Vec<u8>, String> {
    let mut message = serde_json::to_value(M::default()).map_err(|error| error.to_string())?;
    fill(&mut message, fields, "")?;
    let message: M = serde_json::from_value(message).map_err(|error| error.to_string())?;
    cdr::encode(&message).map_err(|error| error.to_string())
}

fn fill(message: &mut Value, fields: &Value, path: &str) -> Result<(), String> {
    match (message, fields) {
        (Value::Object(known), Value::Object(given)) => {
            for (name, value) in given {
                let names: Vec<_> = known.keys().cloned().collect();
                let field = known.get_mut(name);
                let field = field.ok_or_else(|| {
                    let names = names.join(", ");
                    format!("{path}{name}: there is no such field; there are {names}")
                })?;
                fill(field, value, &format!("{path}{name}."))?;
            }
            Ok(())
        }
        (field, value) if kind(field) == kind(value) => {
            *field = value.clone();
            Ok(())
        }
        (field, value) => Err(format!(
            "{} = {value}: must be {}",
            path.trim_end_matches('.'),
            kind(field)
        )),
    }
}

fn kind(value: &Value) -> &'static str {
    match value {
        Value::Null => "nothing",
        Value::Bool(_) => "true or false",
        Value::Number(_) => "a number",
        Value::String(_) => "text",
        Value::Array(_) => "a list",
        Value::Object(_) => "a table",
    }
}
