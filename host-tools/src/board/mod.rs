//! Boards: how bytes get to one, and the virtual one.
//!
//! The virtual board runs on Linux; everything that needs no emulator, no FIFO and no pseudo terminal runs anywhere.

#[cfg(target_os = "linux")]
mod one_core;
#[cfg(target_os = "linux")]
pub mod qemu;
pub mod transport;
#[cfg(target_os = "linux")]
pub mod virtual_board;
pub mod virtual_exchange;
pub mod virtual_flash;
pub mod virtual_pace;
#[cfg(target_os = "linux")]
pub mod virtual_pipes;
pub mod virtual_robot;
pub mod virtual_servo;
pub mod virtual_servo_bus;
#[cfg(target_os = "linux")]
pub mod virtual_terminal;
pub mod virtual_truth;
