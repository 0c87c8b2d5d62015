#![no_std]
//! Firmware logic, generic over the bus traits.
