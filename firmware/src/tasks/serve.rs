//! Answers the host.

use embassy_time::Instant;
use embedded_io_async::{Read, Write};

use super::shared::Shared;
use crate::link::{Device, LONGEST_ANSWER};
use crate::log::info;

/// Bytes read at once: a packet of the bus that the link may be on.
const READ_BYTES: usize = 64;

/// Bytes from and to a host that comes and goes. Reading and writing fail while there is none.
pub trait Connection: Read + Write {
    /// Waits until there is one.
    fn wait_connection(&mut self) -> impl Future<Output = ()>;
}

/// What answering needs; too large for a stack.
pub struct Buffers {
    device: Device,
    answer: [u8; LONGEST_ANSWER],
}

impl Default for Buffers {
    fn default() -> Self {
        Self::new()
    }
}

impl Buffers {
    /// Nothing received yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { device: Device::new(), answer: [0; LONGEST_ANSWER] }
    }
}

/// Serves one host after the other.
pub async fn serve<L: Connection>(mut link: L, buffers: &mut Buffers, shared: &Shared) -> ! {
    loop {
        link.wait_connection().await;
        info!("link: a host");
        buffers.device.clear();
        while answer(&mut link, buffers, shared).await.is_ok() {}
        info!("link: no host");
    }
}

/// Takes what the host has sent and answers it.
async fn answer<L: Connection>(link: &mut L, buffers: &mut Buffers, shared: &Shared) -> Result<(), L::Error> {
    let Buffers { device, answer } = buffers;
    let mut received = [0; READ_BYTES];
    let count = link.read(&mut received).await?;
    let mut rest = received.get(..count).unwrap_or(&[]);
    while !rest.is_empty() {
        let taken = device.feed(rest);
        rest = rest.get(taken..).unwrap_or(&[]);
        while let Some(length) = shared.with(|state| {
            state.time_us = Instant::now().as_micros();
            device.answer(state, answer)
        }) {
            link.write_all(answer.get(..length).unwrap_or(&[])).await?;
            link.flush().await?;
        }
    }
    Ok(())
}
