//! Dynamixel protocol 2.0: the board is master of the wheel servos' bus, and a device on its USB
//! link.

pub mod bus;
mod checksum;
pub mod packet;
pub mod status;
#[cfg(test)]
pub(crate) mod testing;
pub mod xl430;
