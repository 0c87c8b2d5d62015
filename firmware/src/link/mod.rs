//! The board as a device on its link: Dynamixel protocol 2.0, ID
//! [`BOARD_ID`](crate::control_table::BOARD_ID), no I/O.
//!
//! Bytes from the host go into a [`Device`]; what they ask for is done to the [`State`], which the
//! board's tasks fill; the answer is bytes again. For people who write the other end:
//! `docs/link.md`.

mod device;
mod fifo;
mod settings;
mod state;
mod table;
mod upload;
mod write;

pub use device::{Device, LONGEST_ANSWER, LONGEST_INSTRUCTION, Step};
pub use fifo::{Fifo, Place};
pub use settings::Settings;
pub use state::{Counters, State};
pub use table::{FIRMWARE, render};
pub use upload::Upload;
pub use write::write;
