//! Gives the endpoints out, as the USB stack asks for them.

use embassy_stm32::pac::otg::vals::Eptyp;
use embassy_usb::driver::{
    Direction, Driver as UsbDriver, EndpointAddress, EndpointAllocError, EndpointInfo, EndpointType,
};

use super::bus::Bus;
use super::control::ControlPipe;
use super::endpoint::{FromHost, ToHost};
use super::{ENDPOINTS, PACKET_BYTES};

/// What each endpoint of one direction is for; `None` is not in use. The control pipe has the
/// first.
pub(super) type Kinds = [Option<Eptyp>; ENDPOINTS];

/// The chip's OTG_FS before it is started.
pub(super) struct Driver {
    to_host: Kinds,
    from_host: Kinds,
}

impl Driver {
    pub(super) const fn new() -> Self {
        Self { to_host: [None; ENDPOINTS], from_host: [None; ENDPOINTS] }
    }
}

/// The first that is free behind the control pipe's, or the one that is asked for.
fn give(
    kinds: &mut Kinds,
    direction: Direction,
    info: (EndpointType, Option<EndpointAddress>, u16, u8),
) -> Result<EndpointInfo, EndpointAllocError> {
    let (ep_type, wanted, max_packet_size, interval_ms) = info;
    let kind = match ep_type {
        EndpointType::Bulk => Eptyp::BULK,
        EndpointType::Interrupt => Eptyp::INTERRUPT,
        EndpointType::Control | EndpointType::Isochronous => return Err(EndpointAllocError),
    };
    if usize::from(max_packet_size) > PACKET_BYTES {
        return Err(EndpointAllocError);
    }
    let (index, place) = kinds
        .iter_mut()
        .enumerate()
        .skip(1)
        .find(|(index, place)| place.is_none() && wanted.is_none_or(|wanted| wanted.index() == *index))
        .ok_or(EndpointAllocError)?;
    *place = Some(kind);
    Ok(EndpointInfo {
        addr: EndpointAddress::from_parts(index, direction),
        ep_type,
        max_packet_size,
        interval_ms,
    })
}

impl<'a> UsbDriver<'a> for Driver {
    type EndpointOut = FromHost;
    type EndpointIn = ToHost;
    type ControlPipe = ControlPipe;
    type Bus = Bus;

    fn alloc_endpoint_out(
        &mut self,
        ep_type: EndpointType,
        address: Option<EndpointAddress>,
        max_packet_size: u16,
        interval_ms: u8,
    ) -> Result<FromHost, EndpointAllocError> {
        let info = (ep_type, address, max_packet_size, interval_ms);
        give(&mut self.from_host, Direction::Out, info).map(FromHost::new)
    }

    fn alloc_endpoint_in(
        &mut self,
        ep_type: EndpointType,
        address: Option<EndpointAddress>,
        max_packet_size: u16,
        interval_ms: u8,
    ) -> Result<ToHost, EndpointAllocError> {
        let info = (ep_type, address, max_packet_size, interval_ms);
        give(&mut self.to_host, Direction::In, info).map(ToHost::new)
    }

    /// The stack's set-up asks for 64 bytes, full speed's most; the core is set up for those.
    fn start(self, _control_max_packet_size: u16) -> (Bus, ControlPipe) {
        (Bus::new(self.to_host, self.from_host), ControlPipe)
    }
}
