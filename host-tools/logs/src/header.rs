//! The first line of a log: its columns.

use std::collections::HashSet;
use std::path::Path;

use support::context::Context;
use support::error::{Error, Result};

use super::columnar::{Columnar, Table};
use super::source::{Line, Source, carriage_returns};
use super::{foreign, scan};

/// An opened log of which only the header was read.
pub struct Header {
    pub(super) from: From,
    pub(super) columns: Vec<String>,
}

/// Where rows come from.
// Without that feature tables of columns are never read, and take no room.
#[cfg_attr(not(feature = "every-format"), allow(clippy::large_enum_variant))]
pub(super) enum From {
    Text(Source),
    Columns(Columnar),
}

impl Header {
    /// Opens a log and reads its header.
    ///
    /// # Errors
    /// The file does not exist or is a folder, is empty, is no UTF-8 text, has no comma-separated
    /// header or names a column twice.
    pub fn open(context: &Context, path: &Path) -> Result<Self> {
        if let Some(rows) = foreign::open(context, path)? {
            return Self::of_columns(Columnar::of_file(context, path, rows));
        }
        let mut source = Source::open(context, path)?;
        let columns = match source.next_line()? {
            Line::End => {
                Err(Error::failed("is empty; expected a run log: a CSV header and at least two rows"))
            }
            Line::Whole(start, end) => parse(source.bytes(start, end)),
            Line::Cut(start, end) if source.bytes(start, end).contains(&b'\r') => Err(carriage_returns()),
            Line::Cut(start, end) => parse(source.bytes(start, end)).and_then(|_| {
                Err(Error::failed("ends within its header; expected a CSV header and at least two rows")
                    .at_line(1))
            }),
        }
        .map_err(|error| error.in_file(source.path()))?;
        Ok(Self { from: From::Text(source), columns })
    }

    /// Of columns in memory; `name` is what errors call them.
    ///
    /// # Errors
    /// A column is there twice.
    pub fn of_table(context: &Context, name: impl AsRef<Path>, table: Table) -> Result<Self> {
        Self::of_columns(Columnar::of_table(context, name.as_ref(), table))
    }

    fn of_columns((columnar, columns): (Columnar, Vec<String>)) -> Result<Self> {
        check_names(&columns).map_err(|error| error.in_file(columnar.path()))?;
        Ok(Self { from: From::Columns(columnar), columns })
    }

    /// All column names, in the order of the file.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Whether the log has the column `name`.
    pub fn has(&self, name: &str) -> bool {
        self.columns.iter().any(|column| column == name)
    }

    /// Path of the log.
    pub fn path(&self) -> &Path {
        self.from.path()
    }
}

impl From {
    /// What was looked for in a bag and not found, and how robot.toml may name it.
    pub(super) fn lacks(&self) -> Option<&str> {
        match self {
            Self::Text(_) => None,
            Self::Columns(columnar) => columnar.lacks(),
        }
    }

    pub(super) fn path(&self) -> &Path {
        match self {
            Self::Text(source) => source.path(),
            Self::Columns(columnar) => columnar.path(),
        }
    }

    /// Of the row handed out last, counted from 1.
    pub(super) fn line_number(&self) -> u64 {
        match self {
            Self::Text(source) => source.line_number(),
            Self::Columns(columnar) => columnar.line_number(),
        }
    }

    /// Bytes read and in all.
    pub(super) fn progress(&self) -> (u64, Option<u64>) {
        match self {
            Self::Text(source) => (source.consumed(), source.size()),
            Self::Columns(columnar) => columnar.progress(),
        }
    }
}

/// Most columns: more are no log, and every row would be looked through for a handful.
const MOST_COLUMNS: usize = 4096;

fn parse(line: &[u8]) -> Result<Vec<String>> {
    let not_text = |what: &str| {
        Error::failed(format!(
            "is {what}; expected a run log: CSV text with a header such as time_s,wheel1_rad_s,power_w"
        ))
    };
    if line.starts_with(&[0xFF, 0xFE]) || line.starts_with(&[0xFE, 0xFF]) {
        return Err(not_text("UTF-16 text: save it as UTF-8 (iconv -f UTF-16 -t UTF-8 old.csv > new.csv)"));
    }
    if line.contains(&0) {
        return Err(not_text("not text"));
    }
    let text = std::str::from_utf8(line).map_err(|_| not_text("not UTF-8 text"))?;
    if line.trim_ascii_end().contains(&b'\r') {
        return Err(carriage_returns());
    }
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let columns: Vec<String> = scan::Fields::new(text.as_bytes())
        .map(|field| String::from_utf8_lossy(&scan::unquote(field)).into_owned())
        .collect();
    if let [only] = &columns[..]
        && let Some(separator) = only.chars().find(|c| matches!(c, ';' | '\t' | '|'))
    {
        let message = format!(
            "fields are separated by {separator:?}; expected commas between fields and a point in numbers"
        );
        return Err(Error::failed(message).at_line(1));
    }
    if let Some(number) = columns.iter().find(|column| fast_float2::parse::<f64, _>(column.as_str()).is_ok())
    {
        let message =
            format!("the first line holds the number {number}; expected a header with the columns' names");
        return Err(Error::failed(message).at_line(1));
    }
    if columns.len() > MOST_COLUMNS {
        let message = format!("the header has {} columns; expected at most {MOST_COLUMNS}", columns.len());
        return Err(Error::failed(message).at_line(1));
    }
    check_names(&columns)?;
    Ok(columns)
}

fn check_names(columns: &[String]) -> Result<()> {
    let mut seen = HashSet::with_capacity(columns.len());
    for column in columns {
        if !column.is_empty() && !seen.insert(column.as_str()) {
            let message = "the header names this column twice; expected every name once";
            return Err(Error::failed(message).at_line(1).in_column(column));
        }
    }
    Ok(())
}
