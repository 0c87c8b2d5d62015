//! Dynamixel protocol 2.0: the board is master of the wheel servos' bus, and a device on its USB link.

pub mod packet;
pub mod status;
