//! Logs of power only: nobody knows how the robot moved, so that of all effects only a change of
//! the static power shows.
//!
//! Motion lifts the power and lets it fall again. What does neither is the level that the power
//! keeps returning to: a **rest**. A step is a change of that level which lasts: before it the
//! power returns to the one, after it to the other. It is named where at least two open runs show
//! steps of one size, and confirmed by the locked runs at rest, the size being that of the open
//! ones. A robot that stands, and then moves on and on with equal pauses at a lower speed, would
//! look the same: the logs cannot tell.

mod answer;
mod gap;
mod read;
mod rests;

pub use answer::investigate;
pub use read::{PowerRun, is_power_only, read};
pub use rests::{Rest, Rests, Step};
