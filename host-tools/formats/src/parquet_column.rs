//! A column of Parquet within a group of rows, as numbers or texts.

use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type as Physical};
use parquet::column::reader::ColumnReader;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::schema::types::ColumnDescriptor;

use crate::cell::Values;

/// A number or text in each row, or none.
pub(super) fn is_flat(column: &ColumnDescriptor) -> bool {
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

/// A column that is being read.
pub(super) struct Column {
    reader: ColumnReader,
    scale: f64,
    is_text: bool,
}

impl Column {
    /// From its first row on.
    pub(super) fn new(descriptor: &ColumnDescriptor, reader: ColumnReader) -> Self {
        let is_text = descriptor.physical_type() == Physical::BYTE_ARRAY;
        Self { reader, scale: time_scale(descriptor), is_text }
    }

    /// The next `count` rows.
    ///
    /// # Errors
    /// Pages that are not what they say.
    pub(super) fn fill(&mut self, count: usize, values: &mut Values) -> Result<(), ParquetError> {
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
                read!(reader, texts, None, |value: ByteArray| Some(
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
