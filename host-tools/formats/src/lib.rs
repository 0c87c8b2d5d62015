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
//!
//! Without the feature `every-format` no file is read, but messages are, as they come off a
//! network.
#![deny(clippy::print_stderr, clippy::print_stdout)]
// What only readers of files call.
#![cfg_attr(not(feature = "every-format"), allow(dead_code))]

pub mod ahead;
mod bag;
mod cdr;
mod cell;
#[cfg(feature = "every-format")]
mod dataflash;
mod ending;
mod error;
mod extract;
mod field;
pub mod folder;
mod format;
#[cfg(feature = "every-format")]
mod guarded;
mod json;
pub mod json_rows;
mod json_walk;
#[cfg(feature = "every-format")]
mod mcap_file;
pub mod merge;
#[cfg(feature = "every-format")]
mod parquet_column;
#[cfg(feature = "every-format")]
mod parquet_file;
#[cfg(feature = "every-format")]
mod parquet_lanes;
#[cfg(feature = "every-format")]
mod positioned;
#[cfg(feature = "every-format")]
mod readers;
#[cfg(not(feature = "every-format"))]
#[path = "absent.rs"]
mod readers;
#[cfg(feature = "every-format")]
mod ros1;
#[cfg(feature = "every-format")]
mod sqlite;
pub mod table;
mod topic;
#[cfg(feature = "every-format")]
mod ulog;
#[cfg(feature = "every-format")]
mod vesc_tool;
#[cfg(feature = "every-format")]
pub mod write;

pub use bag::Bag;
pub use ending::Ending;
pub use error::{Error, Result};
pub use extract::{Extractor, paths};
pub use field::Field;
pub use format::Format;
pub use topic::{Encoding, Serialization, Topic};
