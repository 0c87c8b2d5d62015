//! Bytes to a board and back: over a serial port, or to a board that is only emulated.

use std::time::Duration;

use support::error::Result;

/// The host's end of a link.
pub trait Transport {
    /// Sends all of them.
    ///
    /// # Errors
    /// The other side is gone.
    fn send(&mut self, bytes: &[u8]) -> Result<()>;

    /// Waits at most `limit` for something; 0 bytes when nothing came.
    ///
    /// # Errors
    /// The other side is gone.
    fn receive(&mut self, buffer: &mut [u8], limit: Duration) -> Result<usize>;

    /// Time as the other side counts it: a real board's passes by itself, an emulated one's only
    /// during a receive.
    fn now(&self) -> Duration;
}

/// For a borrowed link.
impl<T: Transport> Transport for &mut T {
    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        (**self).send(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], limit: Duration) -> Result<usize> {
        (**self).receive(buffer, limit)
    }

    fn now(&self) -> Duration {
        (**self).now()
    }
}
