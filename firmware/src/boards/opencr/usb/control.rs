//! The control pipe: transfers that the host may leave at any point.

use core::future::poll_fn;
use core::task::Poll;

use embassy_usb::driver::{ControlPipe as UsbControlPipe, EndpointError};

use super::PACKET_BYTES;
use super::endpoint::copy;
use super::hardware;
use super::state::STATE;

/// Every wait ends with a bus reset or the next SETUP packet: [`EndpointError::Disabled`].
pub(super) struct ControlPipe;

/// Waits until `work` gives something, or the transfer is overtaken.
async fn unless_overtaken<T>(mut work: impl FnMut() -> Option<T>) -> Result<T, EndpointError> {
    poll_fn(|context| {
        STATE.control().from_host.register(context.waker());
        STATE.control().to_host.register(context.waker());
        // The next SETUP packet comes before or after, not within.
        critical_section::with(|_| {
            if STATE.is_overtaken() {
                return Poll::Ready(Err(EndpointError::Disabled));
            }
            work().map_or(Poll::Pending, |done| Poll::Ready(Ok(done)))
        })
    })
    .await
}

/// A packet for the host, when it has fetched the one before.
async fn send(bytes: &[u8]) -> Result<(), EndpointError> {
    unless_overtaken(|| hardware::is_sent(0).then(|| hardware::send(0, bytes))).await
}

impl UsbControlPipe for ControlPipe {
    fn max_packet_size(&self) -> usize {
        PACKET_BYTES
    }

    async fn setup(&mut self) -> [u8; 8] {
        poll_fn(|context| {
            STATE.control().from_host.register(context.waker());
            STATE.take_setup().map_or(Poll::Pending, Poll::Ready)
        })
        .await
    }

    async fn data_out(
        &mut self,
        buffer: &mut [u8],
        _first: bool,
        _last: bool,
    ) -> Result<usize, EndpointError> {
        hardware::arm(0);
        let packet = unless_overtaken(|| STATE.control().take()).await?;
        copy(packet.as_slice(), buffer)
    }

    async fn data_in(&mut self, bytes: &[u8], _first: bool, is_last: bool) -> Result<(), EndpointError> {
        send(bytes).await?;
        if is_last {
            // The host's empty packet says that it has all.
            hardware::arm(0);
            unless_overtaken(|| STATE.control().take()).await?;
        }
        Ok(())
    }

    async fn accept(&mut self) {
        let _ = send(&[]).await;
    }

    async fn reject(&mut self) {
        let _ = unless_overtaken(|| {
            hardware::reject();
            Some(())
        })
        .await;
    }

    /// The core wants the address before the status stage, in which it still answers to the old
    /// one.
    async fn accept_set_address(&mut self, address: u8) {
        let set = unless_overtaken(|| {
            hardware::set_address(address);
            Some(())
        });
        if set.await.is_ok() {
            self.accept().await;
        }
    }
}
