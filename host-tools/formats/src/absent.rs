//! In place of the readers where they are not built: [`Format::of`] knows every format still, so
//! that the error names it.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use crate::cell::{Taker, Values};
use crate::ending::{Each, Ending};
use crate::error::{Error, Result};
use crate::format::Format;
use crate::topic::Topic;

fn refused(format: Format) -> Error {
    Error::Unsupported(format!(
        "is {}, and this program reads tables in text alone; expected CSV: gmr convert makes it of any log",
        format.name()
    ))
}

/// # Errors
/// Always.
pub(crate) fn topics(_: &Path, format: Format, _: bool) -> Result<Vec<Topic>> {
    Err(refused(format))
}

/// # Errors
/// Always.
pub(crate) fn messages(
    _: &Path,
    format: Format,
    _: &[Topic],
    _: &[usize],
    _: &mut Each<'_>,
) -> Result<Ending> {
    Err(refused(format))
}

/// # Errors
/// Always.
pub(crate) fn rows(path: &Path, _: &mut dyn Taker) -> Result<()> {
    Columns::open(path).map(|_| ())
}

/// A Parquet file: there is none here.
pub enum Columns {}

impl Columns {
    /// Opens a file.
    ///
    /// # Errors
    /// Always: the file's format is not read here.
    pub fn open(path: &Path) -> Result<Self> {
        let mut head = Vec::new();
        File::open(path)?.take(Format::HEAD_BYTES as u64).read_to_end(&mut head)?;
        Err(refused(Format::of(&head).unwrap_or(Format::Parquet)))
    }

    /// Their names.
    pub fn names(&self) -> &[String] {
        match *self {}
    }

    /// Rows of the file.
    pub fn rows(&self) -> u64 {
        match *self {}
    }

    /// From the next group of rows on that is opened, only these columns are read.
    pub fn only(&mut self, _: &[bool]) {
        match *self {}
    }

    /// The next rows of each column that is read; how many, 0 at the end.
    ///
    /// # Errors
    /// None.
    pub fn next(&mut self, _: &mut [Values]) -> Result<usize> {
        match *self {}
    }
}
