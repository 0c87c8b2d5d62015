//! The two boards that the same tasks run on: what differs between them ends here.

#[cfg(feature = "opencr")]
pub mod opencr;
#[cfg(feature = "virtual")]
pub mod virtual_board;
