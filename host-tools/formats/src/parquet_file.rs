//! Parquet: rows out of its columns, some thousand at a time.

use std::fs::File;
use std::panic::AssertUnwindSafe;
use std::path::Path;

use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type as Physical};
use parquet::column::reader::ColumnReader;
use parquet::errors::ParquetError;
use parquet::file::metadata::ParquetMetaData;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use crate::cell::{Cell, Taker};
use crate::error::{Error, Result};

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
    // The crate has assertions on what files say of themselves (negative lengths, for one); those that are not seen beforehand end here.
    let read = std::panic::catch_unwind(AssertUnwindSafe(|| read_unguarded(path, taker)));
    read.unwrap_or_else(|_| Err(Error::damaged("Parquet", "its directory contradicts itself")))
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
    let file = File::open(path)?;
    let length = file.metadata()?.len();
    let reader = SerializedFileReader::new(file).map_err(damaged)?;
    check(reader.metadata(), length)?;
    let schema = reader.metadata().file_metadata().schema_descr_ptr();
    let wanted: Vec<usize> =
        (0..schema.num_columns()).filter(|&place| is_flat(&schema.column(place))).collect();
    let names: Vec<String> = wanted.iter().map(|&place| schema.column(place).name().to_owned()).collect();
    if wanted.is_empty() || wanted.len() > MOST_COLUMNS {
        let message =
            format!("has {} columns of numbers; expected between 1 and {MOST_COLUMNS}", wanted.len());
        return Err(Error::Choice(message));
    }
    taker.columns(&names)?;
    let mut row = Vec::with_capacity(wanted.len());
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group).map_err(damaged)?;
        let columns = wanted.iter().map(|&place| {
            let scale = time_scale(&schema.column(place));
            Ok(Column { reader: group.get_column_reader(place)?, scale, cells: Vec::new() })
        });
        let mut columns = columns.collect::<Result<Vec<_>, ParquetError>>().map_err(damaged)?;
        let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
        let mut done = 0;
        while done < rows {
            let count = BATCH.min(rows - done);
            for column in &mut columns {
                column.fill(count).map_err(damaged)?;
                if column.cells.len() != count {
                    return Err(Error::Damaged(
                        "is a Parquet file with columns of different lengths".to_owned(),
                    ));
                }
            }
            for place in 0..count {
                row.clear();
                row.extend(
                    columns.iter_mut().map(|column| std::mem::replace(&mut column.cells[place], EMPTY)),
                );
                taker.row(&row)?;
            }
            done += count;
        }
    }
    Ok(())
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
    cells: Vec<Cell>,
}

impl Column {
    /// The next `count` cells.
    fn fill(&mut self, count: usize) -> Result<(), ParquetError> {
        macro_rules! read {
            ($reader:expr, $cell:expr) => {{
                let (mut levels, mut values) = (Vec::with_capacity(count), Vec::with_capacity(count));
                let (read, _, _) = $reader.read_records(count, Some(&mut levels), None, &mut values)?;
                let mut values = values.into_iter().map($cell);
                if levels.is_empty() {
                    self.cells.extend(values.take(read));
                } else {
                    // A level of 0 says that the row has none.
                    self.cells.extend(
                        levels.iter().map(
                            |level| {
                                if *level > 0 { values.next().unwrap_or(EMPTY) } else { EMPTY }
                            },
                        ),
                    );
                }
            }};
        }
        self.cells.clear();
        let scale = self.scale;
        match &mut self.reader {
            ColumnReader::BoolColumnReader(reader) => {
                read!(reader, |is| Cell::Number(f64::from(u8::from(is))))
            }
            ColumnReader::Int32ColumnReader(reader) => {
                read!(reader, |value| Cell::Number(f64::from(value) * scale))
            }
            ColumnReader::Int64ColumnReader(reader) => {
                read!(reader, |value| Cell::Number(value as f64 * scale))
            }
            ColumnReader::FloatColumnReader(reader) => read!(reader, |value| Cell::Number(f64::from(value))),
            ColumnReader::DoubleColumnReader(reader) => read!(reader, Cell::Number),
            ColumnReader::ByteArrayColumnReader(reader) => {
                read!(reader, |value: parquet::data_type::ByteArray| Cell::Text(
                    String::from_utf8_lossy(value.data()).into_owned()
                ));
            }
            _ => self.cells.resize(count, EMPTY),
        }
        Ok(())
    }
}
