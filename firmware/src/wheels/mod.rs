//! The wheel servos: how fast they turn, and whether they can be believed.

mod health;
mod poll;
mod speed;
mod standstill;

pub use health::{ServoCounters, WheelHealth};
pub use poll::{WheelReading, WheelStatus, Wheels};
pub use speed::Speedometer;
pub use standstill::Standstill;

/// Driven wheels of the boards here: left and right.
pub const WHEELS: usize = 2;

/// A wheel's servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Servo {
    /// On the servo bus.
    pub id: u8,
    /// It counts backwards when the robot drives forward, whatever its own drive mode makes of that.
    pub reversed: bool,
}
