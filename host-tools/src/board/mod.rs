//! Boards: how bytes get to one, and the virtual one.

pub mod qemu;
pub mod transport;
pub mod virtual_board;
pub mod virtual_exchange;
pub mod virtual_flash;
pub mod virtual_pace;
pub mod virtual_pipes;
pub mod virtual_robot;
pub mod virtual_servo;
pub mod virtual_servo_bus;
pub mod virtual_terminal;
pub mod virtual_truth;
