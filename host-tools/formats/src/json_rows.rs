//! Rows as JSON objects with their JSON schema: what PlotJuggler and Foxglove take without ROS,
//! from a file or as it comes.

use crate::cell::Cell;
use crate::error::{Error, Result};
use crate::table::TIME;

/// Where such rows are messages.
pub const TOPIC: &str = "/log";
/// What such a row is called.
pub const SCHEMA: &str = "log";
/// How its schema is written.
pub const SCHEMA_ENCODING: &str = "jsonschema";
/// How it is written.
pub const ENCODING: &str = "json";

/// Columns, and which of them are text.
pub struct JsonRows {
    columns: Vec<String>,
    is_text: Vec<bool>,
    message: Vec<u8>,
}

/// A row as a message.
pub struct JsonRow<'a> {
    /// An object; what is not known is not in it.
    pub message: &'a [u8],
    /// Its time, ns: counted from 1970 by whoever shows it.
    pub time_ns: u64,
}

fn failed(error: impl std::fmt::Display) -> Error {
    Error::Io(std::io::Error::other(error.to_string()))
}

impl JsonRows {
    /// Rows of these columns.
    ///
    /// # Errors
    /// No column of time.
    pub fn new(columns: &[String], is_text: &[bool]) -> Result<Self> {
        if !columns.iter().any(|column| column == TIME) {
            return Err(Error::Choice(format!(
                "has no column {TIME}; expected one, as messages need a time"
            )));
        }
        Ok(Self { columns: columns.to_vec(), is_text: is_text.to_vec(), message: Vec::new() })
    }

    /// The JSON schema of all of them.
    pub fn schema(&self) -> String {
        let property = |(name, is_text): (&String, &bool)| {
            let kind = if *is_text { "string" } else { "number" };
            (name.clone(), serde_json::json!({ "type": kind }))
        };
        let properties: serde_json::Map<_, _> =
            self.columns.iter().zip(&self.is_text).map(property).collect();
        serde_json::json!({ "type": "object", "properties": properties }).to_string()
    }

    /// A row.
    ///
    /// # Errors
    /// What JSON cannot say.
    pub fn row(&mut self, row: &[Cell]) -> Result<JsonRow<'_>> {
        self.message.clear();
        let mut time = 0.0;
        for ((name, is_text), cell) in self.columns.iter().zip(&self.is_text).zip(row) {
            if name == TIME {
                time = cell.number();
            }
            if !cell.is_there() {
                continue;
            }
            self.message.push(if self.message.is_empty() { b'{' } else { b',' });
            serde_json::to_writer(&mut self.message, name).map_err(failed)?;
            self.message.push(b':');
            let written = if *is_text {
                serde_json::to_writer(&mut self.message, &cell.text())
            } else {
                serde_json::to_writer(&mut self.message, &cell.number())
            };
            written.map_err(failed)?;
        }
        self.message.extend_from_slice(if self.message.is_empty() { b"{}" } else { b"}" });
        Ok(JsonRow { message: &self.message, time_ns: (time.max(0.0) * 1e9) as u64 })
    }
}
