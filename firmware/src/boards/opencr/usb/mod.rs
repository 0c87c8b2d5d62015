//! USB, full speed, as a device: [`UsbLink`] is what the tasks use of it, over a driver of the
//! chip's OTG_FS of our own.
//!
//! embassy's driver (embassy-usb-synopsys-otg 0.3, as 0.4) waits without end in a control transfer
//! that the host does not finish, and sees no bus reset meanwhile (embassy-rs/embassy#2751): a
//! cable that bounces kills the link until power is off. It panics on a SETUP packet of other than
//! 8 bytes and on requests to endpoints that the chip has not. Here a bus reset and a new SETUP
//! packet end whatever is under way, every wait for the peripheral is bounded, and what is not of
//! USB's form is left out.
//!
//! Sources: RM0385, chapter 37 (OTG_FS); USB 2.0, 8.5.3 (control transfers), 9.1.1 (reset). The
//! order of accesses to registers is that of embassy's driver and of ST's.

mod bus;
mod control;
mod driver;
mod endpoint;
mod hardware;
mod interrupt;
mod link;
mod state;

use driver::Driver;
pub(super) use interrupt::Interrupt;
pub(super) use link::new;
pub use link::{UsbDevice, UsbLink};

/// Endpoints of OTG_FS in each direction, the control pipe's among them.
const ENDPOINTS: usize = 6;
/// The greatest packet of a full-speed control or bulk endpoint.
const PACKET_BYTES: usize = 64;
/// The endpoints that send a port's data, as the builder numbers them: each port has one for
/// notifications before it.
const DATA_TO_HOST: [usize; 2] = [2, 4];
/// What these hand over at once: as many packets as the peripheral's memory has room for, so that
/// a long answer takes few interrupts.
const TRANSFER_BYTES: usize = 4 * PACKET_BYTES;
