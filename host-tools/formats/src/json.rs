//! JSON messages: whole, as rows, and what a schema says of them.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error as _, MapAccess, Visitor};
use serde_json::Value;
use serde_json::value::RawValue;

use crate::cell::Cell;
use crate::error::{Error, Result};

/// A message as JSON.
///
/// # Errors
/// It is none.
pub(crate) fn parse(message: &[u8]) -> Result<Value> {
    serde_json::from_slice(message).map_err(no_json)
}

pub(crate) fn no_json(error: serde_json::Error) -> Error {
    Error::Damaged(format!("a message is no JSON: {error}"))
}

/// The members of a message by these names, in their order; numbers that are none where it has
/// none. A tree of every message would take longer than all that follows.
///
/// # Errors
/// It is no JSON.
pub(crate) fn members(message: &[u8], names: &[String], row: &mut Vec<Cell>) -> Result<()> {
    row.clear();
    row.resize(names.len(), Cell::Number(f64::NAN));
    if message.trim_ascii_start().first() != Some(&b'{') {
        return parse(message).map(drop);
    }
    let mut reader = serde_json::Deserializer::from_slice(message);
    let read = Members { names, row }.deserialize(&mut reader).and_then(|()| reader.end());
    read.map_err(no_json)
}

struct Members<'a> {
    names: &'a [String],
    row: &'a mut [Cell],
}

impl<'de> DeserializeSeed<'de> for Members<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, from: D) -> std::result::Result<(), D::Error> {
        from.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for Members<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<(), A::Error> {
        // Members come in the schema's order, mostly.
        let mut expected = 0;
        let place = |expected: usize, name: &str| match self.names.get(expected) {
            Some(next) if next == name => Some(expected),
            _ => self.names.iter().position(|here| here == name),
        };
        while let Some(place) = map.next_key_seed(Name(|name: &str| place(expected, name)))? {
            let value: &RawValue = map.next_value()?;
            if let Some(place) = place {
                self.row[place] = cell(value.get()).map_err(A::Error::custom)?;
                expected = place + 1;
            }
        }
        Ok(())
    }
}

/// What is made of a member's name.
pub(crate) struct Name<F>(pub(crate) F);

impl<'de, T, F: FnOnce(&str) -> T> DeserializeSeed<'de> for Name<F> {
    type Value = T;

    fn deserialize<D: Deserializer<'de>>(self, from: D) -> std::result::Result<T, D::Error> {
        from.deserialize_str(self)
    }
}

impl<T, F: FnOnce(&str) -> T> Visitor<'_> for Name<F> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a name")
    }

    fn visit_str<E>(self, name: &str) -> std::result::Result<T, E> {
        Ok((self.0)(name))
    }
}

/// A value as it is written.
fn cell(value: &str) -> std::result::Result<Cell, String> {
    match value.as_bytes().first() {
        Some(b'"') => serde_json::from_str(value).map(Cell::Text).map_err(|error| error.to_string()),
        Some(b'-' | b'0'..=b'9') => finite(value).map(Cell::Number),
        _ => Ok(Cell::Number(f64::NAN)),
    }
}

/// A number as it is written.
pub(crate) fn finite(value: &str) -> std::result::Result<f64, String> {
    let number = fast_float2::parse(value).ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| "number out of range".to_owned())
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

#[cfg(test)]
mod tests {
    use super::*;

    fn row(message: &str) -> Result<Vec<Cell>> {
        let mut row = vec![Cell::Number(7.0)];
        members(message.as_bytes(), &["a", "b", "c"].map(str::to_owned), &mut row).map(|()| row)
    }

    /// What a tree of the message says, bit for bit: members in any order, twice, missing, of other
    /// names and kinds.
    #[test]
    fn members_are_those_of_a_tree() {
        let messages = [
            r#"{"a":0.1,"b":-2.2250738585072014e-308,"c":123456789012345678901234567890}"#,
            r#" { "c" : 1e-400 , "x" : {"a":[1,{}]} , "a" : -0 , "b" : "A\u0042\n" } "#,
            r#"{"b":1,"b":2.5,"a":null,"c":true}"#,
            r#"{"a":[1],"b":{"c":3},"c":9007199254740993}"#,
            r#"{"\u0061":17.25}"#,
            "{}",
            "[1,2]",
            "3",
        ];
        for message in messages {
            let tree = parse(message.as_bytes()).unwrap();
            let cells = row(message).unwrap();
            for (name, cell) in ["a", "b", "c"].into_iter().zip(cells) {
                match (tree.get(name), cell) {
                    (Some(Value::String(text)), cell) => assert_eq!(cell, Cell::Text(text.clone())),
                    (value, Cell::Number(number)) => {
                        let expected = value.and_then(Value::as_f64).unwrap_or(f64::NAN);
                        let is_same = number.to_bits() == expected.to_bits();
                        assert!(is_same || number.is_nan() && expected.is_nan(), "{message} {name} {number}");
                    }
                    (_, cell) => panic!("{message} {name} {cell:?}"),
                }
            }
        }
    }

    #[test]
    fn what_is_no_json_is_refused() {
        for message in
            [r#"{"a":1"#, r#"{"a":1}}"#, r#"{"a":01}"#, r#"{"a":1e999}"#, r#"{a:1}"#, "", "{,}", "[1"]
        {
            assert!(row(message).is_err(), "{message}");
            assert!(parse(message.as_bytes()).is_err(), "{message}");
        }
        assert!(members(b"{\"a\":\"\xff\"}", &["a".to_owned()], &mut Vec::new()).is_err());
    }
}
