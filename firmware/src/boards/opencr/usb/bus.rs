//! The bus as the USB stack sees it.

use core::future::poll_fn;
use core::task::Poll;

use embassy_usb::driver::{Bus as UsbBus, Direction, EndpointAddress, Event, Unsupported};

use super::driver::Kinds;
use super::hardware;
use super::state::STATE;

/// Started with the first [`UsbBus::poll`].
pub(super) struct Bus {
    to_host: Kinds,
    from_host: Kinds,
    is_started: bool,
}

impl Bus {
    pub(super) const fn new(to_host: Kinds, from_host: Kinds) -> Self {
        Self { to_host, from_host, is_started: false }
    }
}

/// A number behind the control pipe's that the chip has. The control pipe's own is never set up,
/// down or stalled by a request.
fn data(index: usize) -> Option<usize> {
    (index > 0 && STATE.endpoint(index).is_some()).then_some(index)
}

impl UsbBus for Bus {
    /// Resets only. A board on a battery does nothing else in suspend, and that the bus's supply
    /// goes cannot be seen.
    async fn poll(&mut self) -> Event {
        if !self.is_started {
            self.is_started = true;
            hardware::start().await;
            return Event::PowerDetected;
        }
        poll_fn(|context| {
            STATE.bus.register(context.waker());
            if STATE.take_reset() { Poll::Ready(Event::Reset) } else { Poll::Pending }
        })
        .await
    }

    fn endpoint_set_enabled(&mut self, address: EndpointAddress, enabled: bool) {
        let Some(index) = data(address.index()) else { return };
        let Some(endpoint) = STATE.endpoint(index) else { return };
        let kind = |kinds: &Kinds| kinds.get(index).copied().flatten().filter(|_| enabled);
        match address.direction() {
            Direction::In => {
                hardware::enable_sending(index, kind(&self.to_host));
                endpoint.to_host.wake();
            }
            Direction::Out => {
                endpoint.clear();
                hardware::enable_receiving(index, kind(&self.from_host));
                endpoint.from_host.wake();
            }
        }
    }

    fn endpoint_set_stalled(&mut self, address: EndpointAddress, stalled: bool) {
        if let Some(index) = data(address.index()) {
            match address.direction() {
                Direction::In => hardware::stall_sending(index, stalled),
                Direction::Out => hardware::stall_receiving(index, stalled),
            }
        }
    }

    fn endpoint_is_stalled(&mut self, address: EndpointAddress) -> bool {
        data(address.index()).is_some_and(|index| match address.direction() {
            Direction::In => hardware::is_sending_stalled(index),
            Direction::Out => hardware::is_receiving_stalled(index),
        })
    }

    async fn enable(&mut self) {}

    async fn disable(&mut self) {}

    async fn remote_wakeup(&mut self) -> Result<(), Unsupported> {
        Err(Unsupported)
    }
}
