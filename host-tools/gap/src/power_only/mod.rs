//! Logs of power only: the motion is unknown, so only a change of the static power shows.
//!
//! Motion lifts the power and lets it fall again. The level that the power keeps returning to is a
//! **rest**. A step is a lasting change of that level: before it the power returns to one, after it
//! to the other. It is named where at least two open runs show steps of one size, and confirmed by
//! the locked runs at rest, with the size of the open ones. A robot that stands, and then keeps
//! moving with equal pauses at a lower speed, would look the same: the logs cannot tell.

mod answer;
mod gap;
mod read;
mod rests;

pub use answer::investigate;
pub use read::{PowerRun, is_power_only, read};
pub use rests::{Rest, Rests, Step};
