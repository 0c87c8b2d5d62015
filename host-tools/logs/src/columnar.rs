//! Rows of a log that is kept by columns: of a Parquet file, or of another program's memory.

use std::path::{Path, PathBuf};

pub use log_formats::table::Values;
use support::context::Context;
use support::error::{Error, Result};

use super::foreign::{self, Rows};

/// Columns of equal length in memory, by name.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    names: Vec<String>,
    values: Vec<Values>,
}

impl Table {
    /// Of numbers, NaN where a row has none.
    ///
    /// # Errors
    /// Columns of different lengths; more or fewer names than columns.
    pub fn new(names: Vec<String>, columns: Vec<Vec<f64>>) -> Result<Self> {
        let values: Vec<Values> = columns.into_iter().map(Values::Numbers).collect();
        let table = Self { names, values };
        let rows = table.rows();
        if table.names.len() != table.values.len() || table.values.iter().any(|column| length(column) != rows)
        {
            return Err(Error::failed("columns differ in length; expected one length"));
        }
        Ok(table)
    }

    fn rows(&self) -> usize {
        self.values.first().map_or(0, length)
    }
}

fn length(values: &Values) -> usize {
    match values {
        Values::Numbers(numbers) => numbers.len(),
        Values::Texts(texts) => texts.len(),
        Values::Unread => 0,
    }
}

enum From {
    Rows(Rows),
    /// Handed out at once.
    Memory(Option<Vec<Values>>),
}

/// Reads rows one by one.
pub(super) struct Columnar {
    context: Context,
    path: PathBuf,
    from: From,
    /// Some of the next rows.
    batch: Vec<Values>,
    /// How many, and which of them is the next.
    count: usize,
    next: usize,
    rows: u64,
    size: Option<u64>,
    total: u64,
}

impl Columnar {
    /// Of a file, with its columns' names.
    pub(super) fn of_file(context: &Context, path: &Path, rows: Rows) -> (Self, Vec<String>) {
        let (names, total) = match &rows {
            Rows::File(columns) => (columns.names().to_vec(), columns.rows()),
            Rows::Spool(spool) => (spool.names().to_vec(), spool.rows()),
        };
        let size = std::fs::metadata(path).ok().map(|metadata| metadata.len());
        (Self::new(context, path, From::Rows(rows), names.len(), total, size), names)
    }

    /// Of memory, with its columns' names; `name` is what errors call it.
    pub(super) fn of_table(context: &Context, name: &Path, table: Table) -> (Self, Vec<String>) {
        let total = table.rows() as u64;
        let size = Some(8 * total * table.values.len() as u64);
        (
            Self::new(context, name, From::Memory(Some(table.values)), table.names.len(), total, size),
            table.names,
        )
    }

    fn new(
        context: &Context,
        path: &Path,
        from: From,
        columns: usize,
        total: u64,
        size: Option<u64>,
    ) -> Self {
        let batch = vec![Values::Unread; columns];
        Self {
            context: context.clone(),
            path: path.to_owned(),
            from,
            batch,
            count: 0,
            next: 0,
            rows: 0,
            size,
            total,
        }
    }

    /// What was looked for in a bag and not found, and how robot.toml may name it.
    pub(super) fn lacks(&self) -> Option<&str> {
        match &self.from {
            From::Rows(Rows::Spool(spool)) => spool.lacks(),
            _ => None,
        }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Line of the row handed out last, were it text: the header is line 1.
    pub(super) fn line_number(&self) -> u64 {
        self.rows + 1
    }

    /// Bytes read, as far as rows tell, and of the file.
    pub(super) fn progress(&self) -> (u64, Option<u64>) {
        let share = self.rows as f64 / self.total.max(1) as f64;
        ((share * self.size.unwrap_or(0) as f64) as u64, self.size)
    }

    /// Only these columns are read.
    pub(super) fn only(&mut self, is_wanted: &[bool]) {
        if let From::Rows(Rows::File(columns)) = &mut self.from {
            columns.only(is_wanted);
        }
    }

    /// Goes on to the next row: its place in [`values`](Self::values). None at the end.
    #[inline]
    pub(super) fn advance(&mut self) -> Result<Option<usize>> {
        if self.next == self.count {
            self.refill()?;
            if self.count == 0 {
                return Ok(None);
            }
        }
        self.next += 1;
        self.rows += 1;
        Ok(Some(self.next - 1))
    }

    fn refill(&mut self) -> Result<()> {
        self.context.point();
        self.next = 0;
        self.count = match &mut self.from {
            From::Rows(Rows::File(columns)) => {
                columns.next(&mut self.batch).map_err(|error| foreign::wrong(error).in_file(&self.path))?
            }
            From::Rows(Rows::Spool(spool)) => {
                spool.read(self.rows, &mut self.batch).map_err(|error| Error::io(&self.path, &error))?
            }
            From::Memory(values) => match values.take() {
                Some(values) => {
                    self.batch = values;
                    self.batch.first().map_or(0, length)
                }
                None => 0,
            },
        };
        Ok(())
    }

    /// The rows at hand of a column.
    #[inline]
    pub(super) fn values(&self, column: usize) -> &Values {
        &self.batch[column]
    }
}
