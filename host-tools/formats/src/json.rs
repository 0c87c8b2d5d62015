//! Numbers out of JSON messages.

use serde_json::Value;

use crate::error::{Error, Result};
use crate::field::Step;

/// A message as JSON.
///
/// # Errors
/// It is none.
pub(crate) fn parse(message: &[u8]) -> Result<Value> {
    serde_json::from_slice(message).map_err(|error| Error::Damaged(format!("a message is no JSON: {error}")))
}

/// The number at a path; NaN where there is none.
pub(crate) fn number(message: &Value, steps: &[Step]) -> f64 {
    let mut at = message;
    let mut above = message;
    for step in steps {
        let next = match step {
            Step::Member(name) => at.get(name),
            Step::Index(index) => at.get(index),
            Step::Named(name) => {
                let names = above.get("name").and_then(Value::as_array);
                let place = names.and_then(|names| names.iter().position(|here| here.as_str() == Some(name)));
                place.and_then(|place| at.get(place))
            }
        };
        let Some(next) = next else { return f64::NAN };
        above = at;
        at = next;
    }
    match at {
        Value::Bool(is) => f64::from(u8::from(*is)),
        other => other.as_f64().unwrap_or(f64::NAN),
    }
}

/// Paths of the numbers that a schema names.
pub(crate) fn paths(schema: &str) -> Vec<String> {
    let mut paths = Vec::new();
    if let Ok(schema) = serde_json::from_str::<Value>(schema) {
        add_paths(&schema, "", &mut paths);
    }
    paths
}

fn add_paths(schema: &Value, prefix: &str, paths: &mut Vec<String>) {
    let kind = schema.get("type").and_then(Value::as_str);
    match kind {
        Some("number" | "integer" | "boolean") => paths.push(prefix.to_owned()),
        Some("array") => {
            if let Some(items) = schema.get("items") {
                add_paths(items, &format!("{prefix}[]"), paths);
            }
        }
        _ => {
            for (name, member) in schema.get("properties").and_then(Value::as_object).into_iter().flatten() {
                let dot = if prefix.is_empty() { "" } else { "." };
                add_paths(member, &format!("{prefix}{dot}{name}"), paths);
            }
        }
    }
}
