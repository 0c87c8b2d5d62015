//! Endpoints of data. Both fail while no host has set them up.

use core::future::poll_fn;
use core::task::Poll;

use embassy_usb::driver::{Endpoint, EndpointError, EndpointIn, EndpointInfo, EndpointOut};

use super::hardware;
use super::state::STATE;

/// To the host.
pub(super) struct ToHost {
    info: EndpointInfo,
}

/// From the host.
pub(super) struct FromHost {
    info: EndpointInfo,
}

impl ToHost {
    pub(super) const fn new(info: EndpointInfo) -> Self {
        Self { info }
    }
}

impl FromHost {
    pub(super) const fn new(info: EndpointInfo) -> Self {
        Self { info }
    }
}

impl Endpoint for ToHost {
    fn info(&self) -> &EndpointInfo {
        &self.info
    }

    async fn wait_enabled(&mut self) {
        let index = self.info.addr.index();
        poll_fn(|context| {
            if let Some(endpoint) = STATE.endpoint(index) {
                endpoint.to_host.register(context.waker());
            }
            if hardware::sends(index) { Poll::Ready(()) } else { Poll::Pending }
        })
        .await;
    }
}

impl EndpointIn for ToHost {
    /// Of as many packets as the bytes take, not one: the peripheral cuts them.
    async fn write(&mut self, bytes: &[u8]) -> Result<(), EndpointError> {
        let index = self.info.addr.index();
        if bytes.len() > hardware::most_bytes(index) {
            return Err(EndpointError::BufferOverflow);
        }
        poll_fn(|context| {
            if let Some(endpoint) = STATE.endpoint(index) {
                endpoint.to_host.register(context.waker());
            }
            // A reset comes before or after, not within.
            critical_section::with(|_| {
                if !hardware::sends(index) {
                    Poll::Ready(Err(EndpointError::Disabled))
                } else if hardware::is_sent(index) {
                    hardware::send(index, bytes);
                    Poll::Ready(Ok(()))
                } else {
                    Poll::Pending
                }
            })
        })
        .await
    }
}

impl Endpoint for FromHost {
    fn info(&self) -> &EndpointInfo {
        &self.info
    }

    async fn wait_enabled(&mut self) {
        let index = self.info.addr.index();
        poll_fn(|context| {
            if let Some(endpoint) = STATE.endpoint(index) {
                endpoint.from_host.register(context.waker());
            }
            if hardware::receives(index) { Poll::Ready(()) } else { Poll::Pending }
        })
        .await;
    }
}

impl EndpointOut for FromHost {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, EndpointError> {
        let index = self.info.addr.index();
        let endpoint = STATE.endpoint(index).ok_or(EndpointError::Disabled)?;
        poll_fn(|context| {
            endpoint.from_host.register(context.waker());
            critical_section::with(|_| {
                if !hardware::receives(index) {
                    return Poll::Ready(Err(EndpointError::Disabled));
                }
                let Some(packet) = endpoint.take() else { return Poll::Pending };
                hardware::arm(index);
                Poll::Ready(copy(packet.as_slice(), buffer))
            })
        })
        .await
    }
}

/// The bytes, where there is room for all of them.
pub(super) fn copy(from: &[u8], to: &mut [u8]) -> Result<usize, EndpointError> {
    to.get_mut(..from.len()).ok_or(EndpointError::BufferOverflow)?.copy_from_slice(from);
    Ok(from.len())
}
