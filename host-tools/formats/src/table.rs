//! Files that hold rows already: Parquet, and MCAP of one topic in JSON that has a time column.

use std::path::Path;

use crate::bag::Bag;
pub use crate::cell::{Cell, Taker, Values};
use crate::ending::Ending;
use crate::error::{Error, Result};
use crate::json;
use crate::readers;
pub use crate::readers::Columns;
use crate::topic::Encoding;

/// The column of time in a table of rows.
pub const TIME: &str = "time_s";

/// Hands out a Parquet file.
///
/// # Errors
/// A file that is cut off or damaged, has no column of numbers, and what the taker reports.
pub fn parquet(path: &Path, taker: &mut dyn Taker) -> Result<()> {
    readers::rows(path, taker)
}

/// The topic of a bag that is a table: the only one, in JSON, with a time column.
pub fn topic(bag: &Bag) -> Option<usize> {
    let tables: Vec<usize> = bag
        .topics()
        .iter()
        .enumerate()
        .filter(|(_, topic)| is_table(&topic.encoding))
        .map(|(place, _)| place)
        .collect();
    match tables[..] {
        [only] => Some(only),
        _ => None,
    }
}

fn is_table(encoding: &Encoding) -> bool {
    matches!(encoding, Encoding::Json { schema } if json::paths(schema).iter().any(|path| path == TIME))
}

/// Hands out the messages of a topic in JSON as rows; the columns are the schema's properties.
///
/// # Errors
/// Messages that are no JSON, and what the taker reports.
pub fn json_topic(bag: &Bag, topic: usize, taker: &mut dyn Taker) -> Result<Ending> {
    let Encoding::Json { schema } = &bag.topics()[topic].encoding else {
        return Err(Error::Unsupported(format!("topic {} is not in JSON", bag.topics()[topic].name)));
    };
    let schema = json::parse(schema.as_bytes())?;
    let properties = schema.get("properties").and_then(serde_json::Value::as_object);
    let columns: Vec<String> = properties.into_iter().flatten().map(|(name, _)| name.clone()).collect();
    taker.columns(&columns)?;
    let mut row = Vec::with_capacity(columns.len());
    bag.read(&[topic], &mut |_, _, message| {
        json::members(message, &columns, &mut row)?;
        taker.row(&row)?;
        Ok(true)
    })
}
