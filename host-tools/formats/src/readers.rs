//! Each format by its reader.

use std::path::Path;

use crate::cell::Taker;
use crate::ending::{Each, Ending};
use crate::error::{Error, Result};
use crate::format::Format;
pub use crate::parquet_file::Columns;
use crate::topic::Topic;
use crate::{dataflash, mcap_file, parquet_file, ros1, sqlite, ulog, vesc_tool};

/// Topics of a file of a bag.
///
/// # Errors
/// A table, damage, or a file that was cut off, where that is not allowed.
pub(crate) fn topics(path: &Path, format: Format, allow_cut: bool) -> Result<Vec<Topic>> {
    match format {
        Format::Mcap => mcap_file::topics(path, allow_cut),
        Format::Sqlite => sqlite::topics(path),
        Format::Ulog => ulog::topics(path, allow_cut),
        Format::Ros1 => ros1::topics(path, allow_cut),
        Format::Dataflash => dataflash::topics(path, allow_cut),
        Format::VescTool => vesc_tool::topics(path),
        _ => Err(Error::Unsupported(format!("is {}, a table; expected a bag", format.name()))),
    }
}

/// Hands out the messages of some topics of a file of a bag.
///
/// # Errors
/// Damage, and what `each` reports.
pub(crate) fn messages(
    path: &Path,
    format: Format,
    topics: &[Topic],
    wanted: &[usize],
    each: &mut Each<'_>,
) -> Result<Ending> {
    match format {
        Format::Mcap => mcap_file::read(path, topics, wanted, each),
        Format::Sqlite => sqlite::read(path, topics, wanted, each),
        Format::Ros1 => ros1::read(path, topics, wanted, each),
        Format::Dataflash => dataflash::read(path, topics, wanted, each),
        Format::VescTool => vesc_tool::read(path, topics, wanted, each),
        _ => ulog::read(path, topics, wanted, each),
    }
}

/// Hands out the rows of a Parquet file.
///
/// # Errors
/// Damage, and what the taker reports.
pub(crate) fn rows(path: &Path, taker: &mut dyn Taker) -> Result<()> {
    parquet_file::read(path, taker)
}
