//! Boards: how bytes get to one, and the virtual one.

pub mod transport;
pub mod virtual_flash;
pub mod virtual_robot;
pub mod virtual_servo;
pub mod virtual_servo_bus;
