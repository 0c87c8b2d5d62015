//! Rows as Parquet, and as MCAP in JSON, which PlotJuggler and Foxglove open without ROS. Read
//! back, each number is the same.

use std::io::{Seek, Write};
use std::sync::Arc;

use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions};
use parquet::basic::{Compression as Codec, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::cell::Cell;
use crate::error::{Error, Result};
use crate::json_rows::{ENCODING, JsonRows, SCHEMA, SCHEMA_ENCODING, TOPIC};

/// Rows of a group: its columns are held until it is full.
const GROUP: usize = 1 << 16;

fn failed(error: impl std::fmt::Display) -> Error {
    Error::Io(std::io::Error::other(error.to_string()))
}

/// Columns of a Parquet file, and which of them are text.
pub struct Parquet<W: Write + Send> {
    writer: SerializedFileWriter<W>,
    is_text: Vec<bool>,
    rows: Vec<Vec<Cell>>,
}

impl<W: Write + Send> Parquet<W> {
    /// Begins a file.
    ///
    /// # Errors
    /// What cannot be written.
    pub fn new(to: W, columns: &[String], is_text: &[bool]) -> Result<Self> {
        let begin = || -> Result<SerializedFileWriter<W>, ParquetError> {
            let fields = columns.iter().zip(is_text).map(|(name, is_text)| {
                let physical = if *is_text { Physical::BYTE_ARRAY } else { Physical::DOUBLE };
                let logical = is_text.then_some(LogicalType::String);
                let field =
                    Type::primitive_type_builder(name, physical).with_repetition(Repetition::OPTIONAL);
                Ok(Arc::new(field.with_logical_type(logical).build()?))
            });
            let fields = fields.collect::<Result<Vec<_>, ParquetError>>()?;
            let schema = Arc::new(Type::group_type_builder("log").with_fields(fields).build()?);
            let properties = WriterProperties::builder().set_compression(Codec::SNAPPY).build();
            SerializedFileWriter::new(to, schema, Arc::new(properties))
        };
        Ok(Self { writer: begin().map_err(failed)?, is_text: is_text.to_vec(), rows: Vec::new() })
    }

    /// Adds a row.
    ///
    /// # Errors
    /// What cannot be written.
    pub fn row(&mut self, row: &[Cell]) -> Result<()> {
        self.rows.push(row.to_vec());
        if self.rows.len() == GROUP { self.group().map_err(failed) } else { Ok(()) }
    }

    fn group(&mut self) -> Result<(), ParquetError> {
        let mut group = self.writer.next_row_group()?;
        let mut place = 0;
        while let Some(mut column) = group.next_column()? {
            let cells = self.rows.iter().map(|row| &row[place]);
            let levels: Vec<i16> = cells.clone().map(|cell| i16::from(cell.is_there())).collect();
            let there = cells.filter(|cell| cell.is_there());
            if self.is_text[place] {
                let texts: Vec<ByteArray> =
                    there.map(|cell| ByteArray::from(cell.text().as_bytes())).collect();
                column.typed::<ByteArrayType>().write_batch(&texts, Some(&levels), None)?;
            } else {
                let numbers: Vec<f64> = there.map(Cell::number).collect();
                column.typed::<DoubleType>().write_batch(&numbers, Some(&levels), None)?;
            }
            column.close()?;
            place += 1;
        }
        group.close()?;
        self.rows.clear();
        Ok(())
    }

    /// Ends the file.
    ///
    /// # Errors
    /// What cannot be written.
    pub fn finish(mut self) -> Result<()> {
        if !self.rows.is_empty() {
            self.group().map_err(failed)?;
        }
        self.writer.close().map(|_| ()).map_err(failed)
    }
}

/// Rows as messages of one topic.
pub struct Mcap<W: Write + Seek> {
    writer: mcap::Writer<W>,
    channel: u16,
    rows: JsonRows,
    sequence: u32,
}

impl<W: Write + Seek> Mcap<W> {
    /// Begins a file.
    ///
    /// # Errors
    /// What cannot be written; no column of time.
    pub fn new(to: W, columns: &[String], is_text: &[bool]) -> Result<Self> {
        let rows = JsonRows::new(columns, is_text)?;
        let options = WriteOptions::new().compression(Some(Compression::Zstd)).profile("").library("gmr");
        let mut writer = options.create(to).map_err(failed)?;
        let schema = writer.add_schema(SCHEMA, SCHEMA_ENCODING, rows.schema().as_bytes()).map_err(failed)?;
        let channel = writer.add_channel(schema, TOPIC, ENCODING, &std::collections::BTreeMap::new());
        Ok(Self { writer, channel: channel.map_err(failed)?, rows, sequence: 0 })
    }

    /// Adds a row; its time is that of the message, counted from 1970.
    ///
    /// # Errors
    /// What cannot be written.
    pub fn row(&mut self, row: &[Cell]) -> Result<()> {
        let row = self.rows.row(row)?;
        let header = MessageHeader {
            channel_id: self.channel,
            sequence: self.sequence,
            log_time: row.time_ns,
            publish_time: row.time_ns,
        };
        self.sequence = self.sequence.wrapping_add(1);
        self.writer.write_to_known_channel(&header, row.message).map_err(failed)
    }

    /// Ends the file.
    ///
    /// # Errors
    /// What cannot be written.
    pub fn finish(mut self) -> Result<()> {
        self.writer.finish().map(|_| ()).map_err(failed)
    }
}
