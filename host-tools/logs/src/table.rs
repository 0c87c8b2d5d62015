//! A log as a table: every column of numbers, and the runs' names, whatever format it came in.

use std::io::{BufRead, BufReader};
use std::path::Path;

use log_formats::table::Cell;
use support::error::Result;

use super::reader::{ColumnRequest, LogReader, Role};
use super::{Header, RUN, TIME, foreign, scan};

/// Which fields of a log's first row are numbers or empty; none where there is no row.
///
/// # Errors
/// The log cannot be opened.
pub(super) fn numbers_in_first_row(path: &Path) -> Result<Vec<bool>> {
    let first = BufReader::new(foreign::open(path)?).split(b'\n').nth(1);
    let Some(Ok(first)) = first else { return Ok(Vec::new()) };
    let is_number = |field: &[u8]| field.is_empty() || fast_float2::parse::<f64, _>(field).is_ok();
    Ok(scan::Fields::new(&first).map(|field| is_number(&scan::unquote(field))).collect())
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
    pub fn open(path: &Path) -> Result<Self> {
        let header = Header::open(path)?;
        let numbers = numbers_in_first_row(path)?;
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
