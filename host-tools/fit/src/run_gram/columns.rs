//! A run's sums as columns, for tables and the engines that add tables up: a number a column, four
//! of text.
//!
//! Names are the paths of the JSON with `_` between: `eq18_products_17`, `summary_distance_m`.

use std::sync::LazyLock;

use serde::Serialize;
use serde_json::Value;
use support::error::{Error, Result};

use super::run::{FORMAT, RunGram};

/// Columns of text: the run's name, and JSON of what groups it, of how it was read and of its
/// payloads.
pub const TEXTS: [&str; 4] = ["run", "keys", "setting", "summary_masses"];

/// Where they are in a gram.
const TEXT_POINTERS: [&str; 4] = ["/run", "/keys", "/setting", "/summary/masses"];

/// What the numbers of two runs make of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Merge {
    /// Their sum.
    Sum,
    /// The least.
    Min,
    /// The greatest.
    Max,
}

/// A column of numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Number {
    /// Its name.
    pub name: String,
    /// What becomes of it when runs are added up.
    pub merge: Merge,
    pointer: String,
    is_count: bool,
}

impl Number {
    /// Whether it is a whole number, from 0 on.
    pub fn is_count(&self) -> bool {
        self.is_count
    }
}

/// Parts that a run may be without.
const OPTIONAL: [&str; 2] = ["/local", "/summary/commanded"];

struct Layout {
    blank: Value,
    numbers: Vec<Number>,
}

static LAYOUT: LazyLock<Layout> = LazyLock::new(|| {
    let blank = serde_json::to_value(RunGram::blank()).unwrap_or_default();
    let mut numbers = Vec::new();
    collect(&blank, "", &mut numbers);
    Layout { blank, numbers }
});

fn collect(value: &Value, pointer: &str, into: &mut Vec<Number>) {
    if TEXT_POINTERS.contains(&pointer) {
        return;
    }
    match value {
        Value::Object(fields) => {
            fields.iter().for_each(|(name, field)| collect(field, &format!("{pointer}/{name}"), into));
        }
        Value::Array(items) => {
            items
                .iter()
                .enumerate()
                .for_each(|(place, item)| collect(item, &format!("{pointer}/{place}"), into));
        }
        _ => into.push(Number {
            name: pointer[1..].replace('/', "_"),
            merge: merge_of(pointer),
            pointer: pointer.to_owned(),
            // The one that may be missing is a line.
            is_count: value.is_u64() || value.is_null(),
        }),
    }
}

fn merge_of(pointer: &str) -> Merge {
    match pointer {
        // Of one format, and bins of one width.
        "/format"
        | "/summary/speeds/width"
        | "/summary/turns/width"
        | "/summary/span_s/0"
        | "/summary/exclusions/first_non_finite_line" => Merge::Min,
        "/summary/span_s/1" | "/summary/fastest_rad_s" => Merge::Max,
        _ => Merge::Sum,
    }
}

/// All columns of numbers.
pub fn names() -> &'static [Number] {
    &LAYOUT.numbers
}

/// A run in columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Flat {
    /// In the order of [`TEXTS`].
    pub texts: [String; 4],
    /// In the order of [`names`]; NaN where the run has none.
    pub numbers: Vec<f64>,
}

impl Flat {
    /// Of a run.
    ///
    /// # Errors
    /// It cannot be written down.
    pub fn of(gram: &RunGram) -> Result<Self> {
        let value = serde_json::to_value(gram).map_err(|error| Error::failed(error.to_string()))?;
        let text = |pointer: &&str| match value.pointer(pointer) {
            Some(Value::String(text)) => text.clone(),
            Some(other) => other.to_string(),
            None => "{}".to_owned(),
        };
        let number =
            |column: &Number| value.pointer(&column.pointer).and_then(Value::as_f64).unwrap_or(f64::NAN);
        Ok(Self {
            texts: TEXT_POINTERS.each_ref().map(text),
            numbers: LAYOUT.numbers.iter().map(number).collect(),
        })
    }

    /// The run.
    ///
    /// # Errors
    /// Numbers and texts that no run has; another format.
    pub fn gram(&self) -> Result<RunGram> {
        let mut value = LAYOUT.blank.clone();
        let is_absent = |prefix: &str| {
            let mut values =
                LAYOUT.numbers.iter().zip(&self.numbers).filter(|(c, _)| c.pointer.starts_with(prefix));
            values.all(|(_, number)| number.is_nan())
        };
        let format = self.numbers.first().copied().unwrap_or(f64::NAN);
        if format != f64::from(FORMAT) {
            let message =
                format!("format {format}; expected {FORMAT}: make the grams again with this gmr gram");
            return Err(Error::failed(message));
        }
        let wrong = |why: String| Error::failed(format!("is no gram ({why}); expected what gmr gram writes"));
        for (column, number) in LAYOUT.numbers.iter().zip(&self.numbers) {
            let Some(place) = value.pointer_mut(&column.pointer) else { continue };
            *place = match (column.is_count, number.is_finite()) {
                (_, false) => Value::Null,
                (true, true) => Value::from(*number as u64),
                (false, true) => Value::from(*number),
            };
        }
        for (pointer, text) in TEXT_POINTERS.iter().zip(&self.texts) {
            let Some(place) = value.pointer_mut(pointer) else { continue };
            *place = match *pointer {
                "/run" => Value::from(text.as_str()),
                _ => serde_json::from_str(text).map_err(|error| wrong(error.to_string()))?,
            };
        }
        for pointer in OPTIONAL.into_iter().filter(|pointer| is_absent(pointer)) {
            if let Some(place) = value.pointer_mut(pointer) {
                *place = Value::Null;
            }
        }
        serde_json::from_value(value).map_err(|error| wrong(error.to_string()))
    }
}
