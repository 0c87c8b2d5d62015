//! A log as a table: every column of numbers, and the runs' names, whatever format it came in.

use std::path::Path;

use log_formats::table::Cell;
use support::context::Context;
use support::error::Result;

use super::columnar::Values;
use super::header::From;
use super::reader::{ColumnRequest, LogReader, Role};
use super::source::Line;
use super::{Header, RUN, TIME, scan};

/// Which fields of a log's first row are numbers or empty; none where there is no row.
///
/// # Errors
/// The log cannot be opened.
pub(super) fn numbers_in_first_row(context: &Context, path: &Path) -> Result<Vec<bool>> {
    let is_number = |field: &[u8]| field.is_empty() || fast_float2::parse::<f64, _>(field).is_ok();
    let is_text_of_number =
        |text: &Option<String>| text.as_ref().is_none_or(|text| is_number(text.as_bytes()));
    match Header::open(context, path)? {
        Header { from: From::Text(mut source), .. } => Ok(match source.next_line() {
            Ok(Line::Whole(start, end) | Line::Cut(start, end)) => {
                scan::Fields::new(source.bytes(start, end))
                    .map(|field| is_number(&scan::unquote(field)))
                    .collect()
            }
            Ok(Line::End) | Err(_) => Vec::new(),
        }),
        Header { from: From::Columns(mut columnar), columns } => Ok(match columnar.advance() {
            Ok(Some(place)) => (0..columns.len())
                .map(|column| match columnar.values(column) {
                    Values::Texts(texts) => is_text_of_number(&texts[place]),
                    Values::Numbers(_) | Values::Unread => true,
                })
                .collect(),
            Ok(None) | Err(_) => Vec::new(),
        }),
    }
}

/// Rows of a log, all columns of numbers at once.
pub struct TableReader {
    reader: LogReader,
    columns: Vec<String>,
    run: Option<usize>,
    values: Vec<f64>,
}

impl TableReader {
    /// Opens a log. Columns whose first row is text are left out, but for the runs' names.
    ///
    /// # Errors
    /// As [`LogReader::open`].
    pub fn open(context: &Context, path: &Path) -> Result<Self> {
        let header = Header::open(context, path)?;
        let numbers = numbers_in_first_row(context, path)?;
        let columns = header.columns().iter().enumerate();
        let kept = columns.filter(|(place, name)| {
            !name.is_empty() && (*name == RUN || numbers.get(*place).copied().unwrap_or(true))
        });
        let columns: Vec<String> = kept.map(|(_, name)| name.clone()).collect();
        let requests: Vec<ColumnRequest> = columns
            .iter()
            .map(|name| {
                let role = match name.as_str() {
                    TIME => Role::Time,
                    RUN => Role::Run,
                    _ => Role::MaybeNumber,
                };
                ColumnRequest::required(name.clone(), role)
            })
            .collect();
        Ok(Self {
            run: columns.iter().position(|name| name == RUN),
            values: vec![f64::NAN; columns.len()],
            reader: header.read(&requests)?,
            columns,
        })
    }

    /// The columns' names.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Bytes read, and of the file, where that is known.
    pub fn progress(&self) -> (u64, Option<u64>) {
        self.reader.progress()
    }

    /// The next row into `row`, in the order of the columns; `false` at the end.
    ///
    /// # Errors
    /// As [`LogReader::next_row`].
    pub fn next_row(&mut self, row: &mut Vec<Cell>) -> Result<bool> {
        if self.reader.next_row(&mut self.values)?.is_none() {
            return Ok(false);
        }
        row.clear();
        row.extend(self.values.iter().map(|value| Cell::Number(*value)));
        if let Some(run) = self.run {
            let name = self.reader.run_names().get(self.values[run] as usize).cloned().unwrap_or_default();
            row[run] = Cell::Text(name);
        }
        Ok(true)
    }
}
