//! The wheel servos.

/// Driven wheels of the boards here: left and right.
pub const WHEELS: usize = 2;
