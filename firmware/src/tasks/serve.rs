//! Answers the host.

use embassy_futures::yield_now;
use embassy_time::Instant;
use embedded_io_async::{Read, Write};

use super::shared::{Reporter, Shared};
use crate::link::{Device, LONGEST_ANSWER, State, Step};
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

/// Serves one host after the other, as `port`.
pub async fn serve<L: Connection>(link: L, buffers: &mut Buffers, shared: &Shared, port: Reporter) -> ! {
    serve_by(link, buffers, shared, port, || Instant::now().as_micros()).await
}

/// By any clock, µs since start.
async fn serve_by<L: Connection>(
    mut link: L,
    buffers: &mut Buffers,
    shared: &Shared,
    port: Reporter,
    now: fn() -> u64,
) -> ! {
    loop {
        shared.rest(port);
        link.wait_connection().await;
        info!("link: a host");
        buffers.device.clear();
        while answer(&mut link, buffers, shared, port, now).await.is_ok() {}
        info!("link: no host");
    }
}

/// Takes what the host has sent and answers it.
async fn answer<L: Connection>(
    link: &mut L,
    buffers: &mut Buffers,
    shared: &Shared,
    port: Reporter,
    now: fn() -> u64,
) -> Result<(), L::Error> {
    let Buffers { device, answer } = buffers;
    let mut received = [0; READ_BYTES];
    shared.rest(port);
    let count = link.read(&mut received).await?;
    shared.report(port, now());
    let mut rest = received.get(..count).unwrap_or(&[]);
    while !rest.is_empty() {
        let taken = device.feed(rest);
        rest = rest.get(taken..).unwrap_or(&[]);
        let with = |work: &mut dyn FnMut(&mut State<'_>)| {
            shared.with(|state| {
                state.time_us = now();
                work(state);
            });
        };
        while let Some(step) = device.step_with(with, answer) {
            if let Step::Answer(length) = step {
                let sent = send(link, answer.get(..length).unwrap_or(&[])).await;
                if sent.is_err() {
                    shared.with(|state| {
                        state.counters.link_abandoned = state.counters.link_abandoned.saturating_add(1);
                    });
                }
                sent?;
            }
            // A host that floods the link must not keep the samples from their time.
            yield_now().await;
        }
    }
    // Bytes of no packet are a flood too.
    yield_now().await;
    Ok(())
}

async fn send<L: Connection>(link: &mut L, answer: &[u8]) -> Result<(), L::Error> {
    link.write_all(answer).await?;
    link.flush().await
}

#[cfg(test)]
mod tests {
    use core::cell::Cell;
    use core::convert::Infallible;
    use core::pin::pin;
    use core::task::{Context, Waker};

    use embedded_io_async::ErrorType;

    use super::*;

    /// A host that always has more of the same, and takes every answer.
    struct Flood<'a> {
        bytes: &'a [u8],
        reads: &'a Cell<usize>,
    }

    impl ErrorType for Flood<'_> {
        type Error = Infallible;
    }

    impl Read for Flood<'_> {
        async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
            self.reads.set(self.reads.get() + 1);
            assert!(self.reads.get() < 1000, "nobody else has a turn");
            let count = buffer.len().min(self.bytes.len());
            buffer[..count].copy_from_slice(&self.bytes[..count]);
            Ok(count)
        }
    }

    impl Write for Flood<'_> {
        async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
            Ok(bytes.len())
        }

        async fn flush(&mut self) -> Result<(), Infallible> {
            Ok(())
        }
    }

    impl Connection for Flood<'_> {
        async fn wait_connection(&mut self) {}
    }

    /// One packet a turn, whole or broken: pings, headers that begin nothing, and noise.
    #[test]
    fn a_flood_leaves_turns_for_others() {
        let ping: &[u8] = b"\xFF\xFF\xFD\x00\xC8\x03\x00\x01\x3B\xFA";
        let pings = ping.repeat(6);
        let headers = b"\xFF\xFF\xFD\x00\x01\xFF\xFF".repeat(9);
        for bytes in [&pings[..], &headers[..], &[0x55; 64]] {
            let (reads, shared, mut buffers) = (Cell::new(0), Shared::new(&mut []), Buffers::new());
            let mut serving = pin!(serve_by(
                Flood { bytes, reads: &reads },
                &mut buffers,
                &shared,
                Reporter::NodePort,
                || 0,
            ));
            let mut turns = 0;
            while reads.get() < 2 {
                turns += 1;
                assert!(serving.as_mut().poll(&mut Context::from_waker(Waker::noop())).is_pending());
                let packets = shared.with(|state| state.counters.link_packets + state.counters.link_broken);
                assert!(packets <= turns, "{packets} packets in {turns} turns");
            }
        }
    }
}
