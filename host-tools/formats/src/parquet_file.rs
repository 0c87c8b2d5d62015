//! Parquet: rows out of its columns, some thousand at a time.

use std::fs::File;
use std::path::Path;

use parquet::errors::ParquetError;
use parquet::file::metadata::ParquetMetaData;
use parquet::file::reader::{FileReader, SerializedFileReader};

use crate::ahead::Ahead;
use crate::cell::{Cell, Taker, Values};
use crate::error::{Error, Result};
use crate::guarded::guarded;
use crate::parquet_column::is_flat;
use crate::parquet_lanes::Lanes;
use crate::positioned::Positioned;

/// Most columns: as many as the command's own text format takes.
const MOST_COLUMNS: usize = 4096;

/// Batches of rows that are decoded before other threads are asked to help.
const ALONE: u32 = 8;

pub(super) fn damaged(error: ParquetError) -> Error {
    let text = error.to_string();
    if text.contains("Corrupt footer") || text.contains("EOF") {
        let message = format!(
            "is cut off or damaged ({text}): a Parquet file has its directory at its end, and is read whole or not at all"
        );
        return Error::Truncated(message);
    }
    Error::damaged("Parquet", error)
}

/// The crate has assertions on what files say of themselves (negative lengths, for one); those that
/// are not seen beforehand end here.
pub(super) fn contradicts_itself() -> Error {
    Error::damaged("Parquet", "its directory contradicts itself")
}

/// Whether the directory's lengths and places are within the file.
fn check(metadata: &ParquetMetaData, length: u64) -> Result<()> {
    let within = |number: i64| u64::try_from(number).is_ok_and(|number| number <= length);
    let groups = metadata.row_groups();
    let columns = groups.iter().flat_map(|group| group.columns());
    let is_right = groups.iter().all(|group| group.num_rows() >= 0)
        && columns.into_iter().all(|column| {
            within(column.data_page_offset())
                && within(column.compressed_size())
                && column.dictionary_page_offset().is_none_or(within)
                && column.num_values() >= 0
        });
    if is_right { Ok(()) } else { Err(Error::damaged("Parquet", "its directory points outside of it")) }
}

/// Hands out columns and rows. Columns that are neither numbers nor text are left out.
pub(crate) fn read(path: &Path, taker: &mut dyn Taker) -> Result<()> {
    let mut columns = Columns::open(path)?;
    taker.columns(columns.names())?;
    let mut values = vec![Values::Unread; columns.names().len()];
    let mut row = Vec::with_capacity(values.len());
    loop {
        let count = columns.next(&mut values)?;
        if count == 0 {
            return Ok(());
        }
        for place in 0..count {
            row.clear();
            row.extend(values.iter_mut().map(|column| cell(column, place)));
            taker.row(&row)?;
        }
    }
}

fn cell(values: &mut Values, place: usize) -> Cell {
    match values {
        Values::Numbers(numbers) => Cell::Number(numbers[place]),
        Values::Texts(texts) => texts[place].take().map_or(EMPTY, Cell::Text),
        Values::Unread => EMPTY,
    }
}

/// A Parquet file by its columns, some thousand rows at a time. Columns that are neither numbers
/// nor text are left out. Threads of rayon's pool that have nothing to do decode ahead.
pub struct Columns {
    lanes: Ahead<Lanes>,
    names: Vec<String>,
    rows: u64,
}

impl Columns {
    /// Opens a file.
    ///
    /// # Errors
    /// What the operating system refuses; a file that is cut off or damaged, or has no column of
    /// numbers or text.
    pub fn open(path: &Path) -> Result<Self> {
        guarded(|| Self::open_unguarded(path)).unwrap_or_else(|| Err(contradicts_itself()))
    }

    fn open_unguarded(path: &Path) -> Result<Self> {
        let file = File::open(path)?;
        let length = file.metadata()?.len();
        let reader = SerializedFileReader::new(Positioned::new(file, length)).map_err(damaged)?;
        let metadata = reader.metadata().file_metadata();
        check(reader.metadata(), length)?;
        let schema = metadata.schema_descr_ptr();
        let places: Vec<usize> =
            (0..schema.num_columns()).filter(|&place| is_flat(&schema.column(place))).collect();
        if places.is_empty() || places.len() > MOST_COLUMNS {
            let message =
                format!("has {} columns of numbers; expected between 1 and {MOST_COLUMNS}", places.len());
            return Err(Error::Choice(message));
        }
        let names = places.iter().map(|&place| schema.column(place).name().to_owned()).collect();
        let rows = u64::try_from(metadata.num_rows()).unwrap_or(0);
        Ok(Self { lanes: Ahead::new(Lanes::new(reader, places), ALONE), names, rows })
    }

    /// Their names.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Rows of the file, as its directory says.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// From the next group of rows on that is opened, only these columns are read.
    ///
    /// # Panics
    /// If there are not as many as columns.
    pub fn only(&mut self, is_wanted: &[bool]) {
        assert_eq!(is_wanted.len(), self.names.len(), "one word a column");
        self.lanes.with(|lanes| lanes.only(is_wanted));
    }

    /// The next rows of each column that is read; how many, 0 at the end.
    ///
    /// # Errors
    /// A file that is damaged, or cannot be read.
    ///
    /// # Panics
    /// If there are not as many `values` as columns.
    pub fn next(&mut self, values: &mut [Values]) -> Result<usize> {
        assert_eq!(values.len(), self.names.len(), "one a column");
        self.lanes.with(|lanes| lanes.give_back(values));
        let Some(next) = self.lanes.take_next() else { return Ok(0) };
        let (count, columns) = next?;
        for (values, column) in values.iter_mut().zip(columns) {
            *values = column;
        }
        Ok(count)
    }
}

const EMPTY: Cell = Cell::Number(f64::NAN);
