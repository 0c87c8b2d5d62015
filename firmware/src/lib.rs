//! What the robot's controller board does, generic over the bus traits of `embedded-hal-async`: it
//! compiles for the board and is tested on the host.
#![cfg_attr(not(test), no_std)]
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing))]

#[cfg(target_os = "none")]
pub mod boards;
mod bytes;
pub mod control_table;
pub mod drive;
pub mod dynamixel;
pub mod estimation;
pub mod exchange;
pub mod inertial;
pub mod items;
pub mod link;
mod log;
pub mod measurement;
pub mod parameters;
pub mod power_sensors;
pub mod record;
pub mod reset;
pub mod store;
pub mod tasks;
#[cfg(test)]
mod testing;
mod time;
pub mod totals;
pub mod wheels;
