//! Parquet: rows out of its columns, some thousand at a time.

use std::fs::File;
use std::path::Path;

use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type as Physical};
use parquet::column::reader::ColumnReader;
use parquet::errors::ParquetError;
use parquet::file::metadata::ParquetMetaData;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use crate::cell::{Cell, Taker};
use crate::error::{Error, Result};
use crate::guarded::guarded;

/// Rows at a time.
const BATCH: usize = 4096;

/// Most columns: as many as the command's own text format takes.
const MOST_COLUMNS: usize = 4096;

fn damaged(error: ParquetError) -> Error {
    let text = error.to_string();
    if text.contains("Corrupt footer") || text.contains("EOF") {
        let message = format!(
            "is cut off or damaged ({text}): a Parquet file has its directory at its end, and is read whole or not at all"
        );
        return Error::Truncated(message);
    }
    Error::damaged("Parquet", error)
}

/// Hands out columns and rows. Columns that are neither numbers nor text are left out.
pub(crate) fn read(path: &Path, taker: &mut dyn Taker) -> Result<()> {
    without_panics(|| read_unguarded(path, taker))
}

/// The crate has assertions on what files say of themselves (negative lengths, for one); those that
/// are not seen beforehand end here.
fn without_panics<T>(read: impl FnOnce() -> Result<T>) -> Result<T> {
    guarded(read).unwrap_or_else(|| Err(Error::damaged("Parquet", "its directory contradicts itself")))
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

fn read_unguarded(path: &Path, taker: &mut dyn Taker) -> Result<()> {
    let mut columns = Columns::open_unguarded(path)?;
    taker.columns(columns.names())?;
    let mut values = vec![Values::Unread; columns.names().len()];
    let mut row = Vec::with_capacity(values.len());
    loop {
        let count = columns.next_unguarded(&mut values)?;
        if count == 0 {
            return Ok(());
        }
        for place in 0..count {
            row.clear();
            row.extend(values.iter_mut().map(|column| column.take(place)));
            taker.row(&row)?;
        }
    }
}

/// Some rows of a column.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// NaN where a row has none.
    Numbers(Vec<f64>),
    /// None where a row has none.
    Texts(Vec<Option<String>>),
    /// Nobody asked for it.
    Unread,
}

impl Values {
    fn take(&mut self, place: usize) -> Cell {
        match self {
            Self::Numbers(numbers) => Cell::Number(numbers[place]),
            Self::Texts(texts) => texts[place].take().map_or(EMPTY, Cell::Text),
            Self::Unread => EMPTY,
        }
    }

    fn len(&self) -> Option<usize> {
        match self {
            Self::Numbers(numbers) => Some(numbers.len()),
            Self::Texts(texts) => Some(texts.len()),
            Self::Unread => None,
        }
    }
}

/// A Parquet file by its columns, some thousand rows at a time. Columns that are neither numbers
/// nor text are left out.
pub struct Columns {
    reader: SerializedFileReader<File>,
    names: Vec<String>,
    /// Of each, in the file.
    places: Vec<usize>,
    is_wanted: Vec<bool>,
    /// The group that is read next.
    group: usize,
    /// Of the group that is being read; none of a column that nobody asked for.
    readers: Vec<Option<Column>>,
    left: usize,
}

impl Columns {
    /// Opens a file.
    ///
    /// # Errors
    /// What the operating system refuses; a file that is cut off or damaged, or has no column of
    /// numbers or text.
    pub fn open(path: &Path) -> Result<Self> {
        without_panics(|| Self::open_unguarded(path))
    }

    fn open_unguarded(path: &Path) -> Result<Self> {
        let file = File::open(path)?;
        let length = file.metadata()?.len();
        let reader = SerializedFileReader::new(file).map_err(damaged)?;
        check(reader.metadata(), length)?;
        let schema = reader.metadata().file_metadata().schema_descr_ptr();
        let places: Vec<usize> =
            (0..schema.num_columns()).filter(|&place| is_flat(&schema.column(place))).collect();
        if places.is_empty() || places.len() > MOST_COLUMNS {
            let message =
                format!("has {} columns of numbers; expected between 1 and {MOST_COLUMNS}", places.len());
            return Err(Error::Choice(message));
        }
        let names = places.iter().map(|&place| schema.column(place).name().to_owned()).collect();
        let is_wanted = vec![true; places.len()];
        Ok(Self { reader, names, places, is_wanted, group: 0, readers: Vec::new(), left: 0 })
    }

    /// Their names.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Rows of the file, as its directory says.
    pub fn rows(&self) -> u64 {
        u64::try_from(self.reader.metadata().file_metadata().num_rows()).unwrap_or(0)
    }

    /// From the next group of rows on, only these columns are read.
    ///
    /// # Panics
    /// If there are not as many as columns.
    pub fn only(&mut self, is_wanted: &[bool]) {
        assert_eq!(is_wanted.len(), self.names.len(), "one word a column");
        self.is_wanted.copy_from_slice(is_wanted);
    }

    /// The next rows of each column that is read; how many, 0 at the end.
    ///
    /// # Errors
    /// A file that is damaged, or cannot be read.
    ///
    /// # Panics
    /// If there are not as many `values` as columns.
    pub fn next(&mut self, values: &mut [Values]) -> Result<usize> {
        without_panics(|| self.next_unguarded(values))
    }

    fn next_unguarded(&mut self, values: &mut [Values]) -> Result<usize> {
        assert_eq!(values.len(), self.names.len(), "one a column");
        while self.left == 0 {
            if self.group == self.reader.num_row_groups() {
                return Ok(0);
            }
            self.open_group().map_err(damaged)?;
        }
        let count = BATCH.min(self.left);
        for (column, values) in self.readers.iter_mut().zip(values.iter_mut()) {
            match column {
                Some(column) => column.fill(count, values).map_err(damaged)?,
                None => *values = Values::Unread,
            }
            if values.len().is_some_and(|length| length != count) {
                return Err(Error::Damaged("is a Parquet file with columns of different lengths".to_owned()));
            }
        }
        self.left -= count;
        Ok(count)
    }

    fn open_group(&mut self) -> Result<(), ParquetError> {
        let schema = self.reader.metadata().file_metadata().schema_descr_ptr();
        let group = self.reader.get_row_group(self.group)?;
        let columns = self.places.iter().zip(&self.is_wanted).map(|(&place, is_wanted)| {
            let open = || {
                let column = schema.column(place);
                let is_text = column.physical_type() == Physical::BYTE_ARRAY;
                let reader = group.get_column_reader(place)?;
                Ok(Column { reader, scale: time_scale(&column), is_text })
            };
            is_wanted.then(open).transpose()
        });
        self.readers = columns.collect::<Result<Vec<_>, ParquetError>>()?;
        self.left = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
        self.group += 1;
        Ok(())
    }
}

const EMPTY: Cell = Cell::Number(f64::NAN);

/// A number or text in each row, or none.
fn is_flat(column: &ColumnDescriptor) -> bool {
    let is_text = matches!(column.logical_type_ref(), Some(LogicalType::String))
        || column.converted_type() == ConvertedType::UTF8;
    let is_number = !matches!(
        column.physical_type(),
        Physical::BYTE_ARRAY | Physical::FIXED_LEN_BYTE_ARRAY | Physical::INT96
    );
    column.max_rep_level() == 0 && column.path().parts().len() == 1 && (is_number || is_text)
}

/// What a column's integers are multiplied by: times become seconds.
fn time_scale(column: &ColumnDescriptor) -> f64 {
    match column.logical_type_ref() {
        Some(LogicalType::Timestamp(time)) => seconds(time.unit),
        Some(LogicalType::Time(time)) => seconds(time.unit),
        _ => 1.0,
    }
}

fn seconds(unit: TimeUnit) -> f64 {
    match unit {
        TimeUnit::MILLIS => 1e-3,
        TimeUnit::MICROS => 1e-6,
        TimeUnit::NANOS => 1e-9,
    }
}

struct Column {
    reader: ColumnReader,
    scale: f64,
    is_text: bool,
}

impl Column {
    /// The next `count` rows.
    fn fill(&mut self, count: usize, values: &mut Values) -> Result<(), ParquetError> {
        /// Into `$into`, with `$empty` where a row has none.
        macro_rules! read {
            ($reader:expr, $into:expr, $empty:expr, $value:expr) => {{
                let (mut levels, mut read) = (Vec::with_capacity(count), Vec::with_capacity(count));
                $reader.read_records(count, Some(&mut levels), None, &mut read)?;
                let mut read = read.into_iter().map($value);
                // A level of 0 says that the row has none; a column that must have one has no
                // levels.
                if levels.is_empty() || levels.iter().all(|level| *level > 0) {
                    $into.extend(read);
                } else {
                    let each = levels
                        .iter()
                        .map(|level| if *level > 0 { read.next().unwrap_or($empty) } else { $empty });
                    $into.extend(each);
                }
            }};
        }
        let scale = self.scale;
        if self.is_text {
            let mut texts = Vec::with_capacity(count);
            if let ColumnReader::ByteArrayColumnReader(reader) = &mut self.reader {
                read!(reader, texts, None, |value: parquet::data_type::ByteArray| Some(
                    String::from_utf8_lossy(value.data()).into_owned()
                ));
            }
            *values = Values::Texts(texts);
            return Ok(());
        }
        let mut numbers = match std::mem::replace(values, Values::Unread) {
            Values::Numbers(numbers) => numbers,
            _ => Vec::with_capacity(count),
        };
        numbers.clear();
        match &mut self.reader {
            ColumnReader::BoolColumnReader(reader) => {
                read!(reader, numbers, f64::NAN, |is| f64::from(u8::from(is)));
            }
            ColumnReader::Int32ColumnReader(reader) => {
                read!(reader, numbers, f64::NAN, |value| f64::from(value) * scale);
            }
            ColumnReader::Int64ColumnReader(reader) => {
                read!(reader, numbers, f64::NAN, |value| value as f64 * scale);
            }
            ColumnReader::FloatColumnReader(reader) => read!(reader, numbers, f64::NAN, f64::from),
            ColumnReader::DoubleColumnReader(reader) => read!(reader, numbers, f64::NAN, |value| value),
            _ => numbers.resize(count, f64::NAN),
        }
        *values = Values::Numbers(numbers);
        Ok(())
    }
}
