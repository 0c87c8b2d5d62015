#![no_std]
//! Power and payload models.
