//! The link to the host.

use embedded_io_async::{Read, Write};

/// Bytes from and to a host that comes and goes.
pub trait Connection: Read + Write {
    /// Waits until there is one.
    fn wait_connection(&mut self) -> impl Future<Output = ()>;
}
