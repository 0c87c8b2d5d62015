//! The wheel servos: how fast they turn, and whether they can be believed.

use embedded_io_async::{Read, Write};

mod health;
mod motors;
mod odometer;
mod poll;
mod speed;
mod standstill;

pub use health::{ServoCounters, WheelHealth};
pub use motors::DriveState;
pub use odometer::Odometer;
pub use poll::{WheelReading, WheelStatus, Wheels};
pub use speed::Speedometer;
pub use standstill::Standstill;

/// Driven wheels of the boards here: left and right.
pub const WHEELS: usize = 2;

/// The servos' port, and the switch of their supply.
pub trait SwitchedPort: Read + Write {
    /// Switches the servos' supply. Without it they forget everything that they were told.
    fn set_supply(&mut self, on: bool);
}

/// A wheel's servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Servo {
    /// On the servo bus.
    pub id: u8,
    /// It counts backwards when the robot drives forward, whatever its own drive mode makes of
    /// that.
    pub reversed: bool,
}

#[cfg(test)]
mod motors_tests;
