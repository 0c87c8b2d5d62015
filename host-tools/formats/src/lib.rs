//! Rows of named columns out of the logs that robots write.
//!
//! | format | what is read |
//! |---|---|
//! | MCAP | bags of ROS 2 (CDR, by the schema that the file carries), messages in JSON, and tables that [`write`](mod@write) wrote |
//! | SQLite | bags of ROS 2 (`.db3`); definitions from the bag, or of common messages from here |
//! | ROS 1 | its bags of version 2.0 |
//! | ULog | logs of PX4 |
//! | DataFlash | logs of ArduPilot |
//! | VESC Tool | its tables with semicolons |
//! | Parquet | tables |
//!
//! A [`Bag`], one file or the [`folder`] of a split recording, has topics whose messages arrive one
//! by one; [`merge`](mod@merge) makes rows of them on the clock of one topic. A [`table`] has rows
//! already. Everything is read as a stream: memory does not grow with the file. Nothing here knows
//! what the numbers mean.
#![deny(clippy::print_stderr, clippy::print_stdout)]

pub mod ahead;
mod bag;
mod cdr;
mod cell;
mod dataflash;
mod ending;
mod error;
mod extract;
mod field;
pub mod folder;
mod format;
mod guarded;
mod json;
pub mod json_rows;
mod mcap_file;
pub mod merge;
mod parquet_column;
mod parquet_file;
mod parquet_lanes;
mod positioned;
mod ros1;
mod sqlite;
pub mod table;
mod topic;
mod ulog;
mod vesc_tool;
pub mod write;

pub use bag::Bag;
pub use ending::Ending;
pub use error::{Error, Result};
pub use extract::{Extractor, paths};
pub use field::Field;
pub use format::Format;
pub use topic::{Encoding, Serialization, Topic};
