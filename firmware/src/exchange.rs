//! What crosses between the virtual board and the virtual robot: one request, one answer, in
//! lockstep.
//!
//! The board's clock stands still while the robot answers; each request carries the board's time,
//! up to which the robot moves first. Little-endian, each frame preceded by its length (u16, itself
//! not counted):
//!
//! | request | bytes |
//! |---|---|
//! | kind | u8, [`Kind`] |
//! | time | u64, µs since the board's start |
//! | body | by kind |
//!
//! | kind | body of the request | body of the answer |
//! |---|---|---|
//! | [`Kind::I2c`] | address u8, bytes to read u8, bytes to write | [`BusAnswer`] u8, bytes |
//! | [`Kind::Servo`] | bytes sent | delay until the first answering byte, µs u32; bytes received |
//! | [`Kind::Link`] | most bytes to answer u16, bytes sent to the host | bytes received from the host |
//! | [`Kind::FlashRead`] | offset u32, count u16 | bytes |
//! | [`Kind::FlashWrite`] | offset u32, bytes | u8: 0 done, 1 refused |
//! | [`Kind::FlashErase`] | from u32, to u32 | u8: 0 done, 1 refused |
//! | [`Kind::NodeLink`] | as [`Kind::Link`], on the port of the ROS node | likewise |
//! | [`Kind::ServoSupply`] | u8: 1 the servos have their supply, 0 not | nothing |
//! | [`Kind::Inertial`] | bytes to the inertial sensor | as many bytes from it |
//!
//! Every answer begins with one byte of notices: bit 0 is set while bytes from the host wait for a
//! [`Kind::Link`], bit 1 likewise for a
//! [`Kind::NodeLink`]. An answer of length 0 ends the board.

use core::ffi::CStr;

/// Where the board writes its requests: a FIFO in the emulator's folder. The board opens this one
/// first.
pub const REQUESTS: &CStr = c"board-to-robot";

/// Where it reads the answers.
pub const ANSWERS: &CStr = c"robot-to-board";

/// Longest frame, without its length.
pub const LONGEST_FRAME: usize = 4096;

/// Bit of the notices: the host has sent something.
pub const NOTICE_LINK: u8 = 1;

/// Bit of the notices: the node has sent something on its port.
pub const NOTICE_NODE: u8 = 2;

/// What a request asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// One transaction on the sensors' bus: a write, a read, or a write and a read.
    I2c = 1,
    /// Bytes on the servo bus.
    Servo = 2,
    /// Bytes on the link, both ways.
    Link = 3,
    /// Reads the store's flash.
    FlashRead = 4,
    /// Writes to it: bits only go from 1 to 0.
    FlashWrite = 5,
    /// Erases sectors of it.
    FlashErase = 6,
    /// Bytes on the port of the ROS node, both ways.
    NodeLink = 7,
    /// Switches the servos' supply.
    ServoSupply = 8,
    /// One transaction on the inertial sensor's bus, bytes both ways at once.
    Inertial = 9,
}

impl Kind {
    /// `None` for a code that this version does not know.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            1 => Self::I2c,
            2 => Self::Servo,
            3 => Self::Link,
            4 => Self::FlashRead,
            5 => Self::FlashWrite,
            6 => Self::FlashErase,
            7 => Self::NodeLink,
            8 => Self::ServoSupply,
            9 => Self::Inertial,
            _ => return None,
        })
    }
}

/// How a transaction on the sensors' bus ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum BusAnswer {
    /// Done.
    Done = 0,
    /// Nobody acknowledged the address.
    NoAcknowledge = 1,
    /// The bus is stuck: a line is held low.
    Stuck = 2,
}

impl BusAnswer {
    /// `None` for a code that this version does not know.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            0 => Self::Done,
            1 => Self::NoAcknowledge,
            2 => Self::Stuck,
            _ => return None,
        })
    }
}
