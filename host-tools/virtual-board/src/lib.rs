//! The firmware on an emulated core, and around it the simulated robot with the chips that the
//! firmware talks to.
//!
//! ```text
//! board ── qemu, pipes ── exchange ─┬─ robot ─┬─ ina219_chip  power sensors, register by register
//!   │                               │         ├─ mpu9250_chip  inertial sensor, likewise
//!   │                               │         ├─ servo_bus, servo  wheels, packet by packet
//!   └─ terminal, pace               │         └─ lockstep  the plant, to any microsecond
//!                                   └─ flash  the store's sectors
//! ```
//!
//! Its face: [`session::session`], a board that runs until its time is over.
//!
//! It runs on Linux. What needs no emulator, FIFO or pseudo terminal runs anywhere. The plant and
//! its power tree stay in [`plant`]: the paper's experiment reads the same rails without a board.
#![deny(clippy::print_stderr, clippy::print_stdout)]

#[cfg(target_os = "linux")]
pub mod board;
pub mod exchange;
pub mod faults;
pub mod flash;
pub mod ina219_chip;
pub mod lockstep;
pub mod mpu9250_chip;
#[cfg(target_os = "linux")]
mod one_core;
pub mod pace;
#[cfg(target_os = "linux")]
pub mod pipes;
#[cfg(target_os = "linux")]
pub mod qemu;
pub mod robot;
pub mod servo;
pub mod servo_bus;
#[cfg(target_os = "linux")]
pub mod session;
#[cfg(target_os = "linux")]
pub mod terminal;
pub mod truth;
