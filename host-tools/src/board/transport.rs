//! A way for bytes to a board and back.

use std::time::Duration;

use crate::error::Result;

/// Bytes both ways.
pub trait Transport {
    /// Sends all of `bytes`.
    ///
    /// # Errors
    /// The board is gone.
    fn send(&mut self, bytes: &[u8]) -> Result<()>;

    /// Waits at most `limit` for something; 0 bytes when nothing came.
    ///
    /// # Errors
    /// The board is gone.
    fn receive(&mut self, buffer: &mut [u8], limit: Duration) -> Result<usize>;

    /// Time as the other side counts it.
    fn now(&self) -> Duration;
}
