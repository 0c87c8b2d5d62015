//! The link to the host: a serial port over USB (CDC ACM) with the IDs that the stock firmware has.

use embassy_stm32::Peri;
use embassy_stm32::peripherals::{PA11, PA12, USB_OTG_FS};
use embassy_stm32::usb::{self, Driver};
use embassy_usb::Builder;
use embassy_usb::class::cdc_acm::{BufferedReceiver, CdcAcmClass, Sender, State};
use embassy_usb::driver::EndpointError;
use embedded_io_async::{ErrorKind, ErrorType, Read, Write};
use static_cell::StaticCell;

use super::Irqs;
use crate::tasks::Connection;

/// STMicroelectronics, virtual COM port: what the udev rule of the TurtleBot3 looks for.
const VENDOR: u16 = 0x0483;
const PRODUCT: u16 = 0x5740;
/// Of a full-speed bulk endpoint.
const PACKET_BYTES: usize = 64;

type Otg = Driver<'static, USB_OTG_FS>;

/// Answers the host's requests to the device.
pub struct UsbDevice(embassy_usb::UsbDevice<'static, Otg>);

impl UsbDevice {
    /// Never ends.
    pub async fn run(&mut self) -> ! {
        self.0.run().await
    }
}

/// Bytes from and to the host.
///
/// Where no host has set the port up, or it was pulled, reading and writing fail at once:
/// [`Connection::wait_connection`] waits for one.
pub struct UsbLink {
    sender: Sender<'static, Otg>,
    receiver: BufferedReceiver<'static, Otg>,
    /// The last packet sent was full, so the host's transfer is still open.
    is_open_ended: bool,
}

/// No host.
#[derive(Debug, Clone, Copy, PartialEq, Eq, defmt::Format)]
pub struct NotConnected;

impl core::fmt::Display for NotConnected {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        formatter.write_str("no host on the link")
    }
}

impl core::error::Error for NotConnected {}

impl embedded_io_async::Error for NotConnected {
    fn kind(&self) -> ErrorKind {
        ErrorKind::NotConnected
    }
}

pub(super) fn new(
    peripheral: Peri<'static, USB_OTG_FS>,
    plus: Peri<'static, PA12>,
    minus: Peri<'static, PA11>,
) -> (UsbLink, UsbDevice) {
    static RECEIVED: StaticCell<[u8; 256]> = StaticCell::new();
    static CONFIGURATION: StaticCell<[u8; 256]> = StaticCell::new();
    static CONTROL: StaticCell<[u8; 64]> = StaticCell::new();
    static PACKET: StaticCell<[u8; PACKET_BYTES]> = StaticCell::new();
    static STATE: StaticCell<State<'static>> = StaticCell::new();

    let mut config = usb::Config::default();
    // The bus's supply is wired to PD3, not to the pin that the peripheral watches.
    config.vbus_detection = false;
    let driver = Driver::new_fs(peripheral, Irqs, plus, minus, RECEIVED.init([0; 256]), config);

    let mut device = embassy_usb::Config::new(VENDOR, PRODUCT);
    device.manufacturer = Some("ROBOTIS OpenCR");
    device.product = Some("Power and payload estimation");
    let mut builder =
        Builder::new(driver, device, CONFIGURATION.init([0; 256]), &mut [], &mut [], CONTROL.init([0; 64]));
    let class = CdcAcmClass::new(&mut builder, STATE.init(State::new()), PACKET_BYTES as u16);
    let device = builder.build();
    let (sender, receiver) = class.split();
    let receiver = receiver.into_buffered(PACKET.init([0; PACKET_BYTES]));
    (UsbLink { sender, receiver, is_open_ended: false }, UsbDevice(device))
}

impl Connection for UsbLink {
    /// Waits until a host has set the port up.
    async fn wait_connection(&mut self) {
        self.is_open_ended = false;
        self.receiver.wait_connection().await;
    }
}

impl ErrorType for UsbLink {
    type Error = NotConnected;
}

impl Read for UsbLink {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Self::Error> {
        self.receiver.read(buffer).await.map_err(|_| NotConnected)
    }
}

impl Write for UsbLink {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
        let count = bytes.len().min(PACKET_BYTES);
        let packet = bytes.get(..count).unwrap_or(bytes);
        match self.sender.write_packet(packet).await {
            Ok(()) => {
                self.is_open_ended = count == PACKET_BYTES;
                Ok(count)
            }
            Err(EndpointError::Disabled | EndpointError::BufferOverflow) => Err(NotConnected),
        }
    }

    /// Ends the host's transfer: one whose last packet is full does not end by itself.
    async fn flush(&mut self) -> Result<(), Self::Error> {
        if core::mem::take(&mut self.is_open_ended) {
            self.sender.write_packet(&[]).await.map_err(|_| NotConnected)?;
        }
        Ok(())
    }
}
