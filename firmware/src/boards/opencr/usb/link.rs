//! The links to the host: two serial ports over USB (CDC ACM) with the IDs that the stock firmware
//! has. The first is where the stock firmware's would be and belongs to the ROS node; the second is
//! for `gmr` beside it. Both answer to the same table.

use embassy_futures::select::{Either, Either3, select, select3};
use embassy_stm32::Peri;
use embassy_stm32::peripherals::{PA11, PA12, USB_OTG_FS};
use embassy_time::{Duration, Instant, Timer};
use embassy_usb::Builder;
use embassy_usb::class::cdc_acm::{BufferedReceiver, CdcAcmClass, ControlChanged, Sender, State};
use embedded_io_async::{ErrorKind, ErrorType, Read, Write};
use static_cell::StaticCell;

use super::state::STATE;
use super::{DATA_TO_HOST, Driver, PACKET_BYTES, TRANSFER_BYTES, hardware};
use crate::boards::opencr::loader;
use crate::tasks::{Connection, Reporter, Shared};

/// STMicroelectronics, virtual COM port: what the udev rule of the TurtleBot3 looks for.
const VENDOR: u16 = 0x0483;
const PRODUCT: u16 = 0x5740;

/// How long an answer may wait for the host to fetch it. The node gives up after 34 ms and takes
/// what comes later for the answer to its next question, which it does not survive: late is worse
/// than never.
const PATIENCE: Duration = Duration::from_millis(20);

/// Packets of a session that has ended which may still be in the driver's hands.
const MOST_STALE_READS: usize = 4;

/// How often somebody looks whether resets of the bus are taken note of, which takes some
/// microseconds.
const LOOK: Duration = Duration::from_millis(50);

/// Answers the host's requests to the device.
pub struct UsbDevice(embassy_usb::UsbDevice<'static, Driver>);

impl UsbDevice {
    /// Never ends.
    pub async fn run(&mut self, shared: &Shared) -> ! {
        match select(self.0.run(), report(shared)).await {
            Either::First(never) | Either::Second(never) => never,
        }
    }
}

/// Reports for as long as no reset of the bus is left waiting.
async fn report(shared: &Shared) -> ! {
    let mut has_waited = false;
    loop {
        let waits = STATE.has_reset();
        if !(waits && has_waited) {
            shared.report(Reporter::Usb, Instant::now().as_micros());
        }
        has_waited = waits;
        Timer::after(LOOK).await;
    }
}

/// Bytes from and to the host.
///
/// Where no host has set the port up, where it was pulled, or the program on the host has closed
/// the port, reading and writing fail: [`Connection::wait_connection`] waits for the next one, to
/// whom nothing of the old answers is sent.
pub struct UsbLink {
    sender: Sender<'static, Driver>,
    receiver: BufferedReceiver<'static, Driver>,
    control: ControlChanged<'static>,
    in_endpoint: usize,
    /// A program has the port open, by its DTR line. Some never raise it: only its fall counts.
    has_terminal: bool,
    /// Until when the answer that is being written has to be fetched.
    deadline: Option<Instant>,
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

/// The node's port, and `gmr`'s.
pub(in crate::boards::opencr) fn new(
    _peripheral: Peri<'static, USB_OTG_FS>,
    plus: Peri<'static, PA12>,
    minus: Peri<'static, PA11>,
) -> ([UsbLink; 2], UsbDevice) {
    static CONFIGURATION: StaticCell<[u8; 256]> = StaticCell::new();
    static CONTROL: StaticCell<[u8; 64]> = StaticCell::new();
    static PACKETS: StaticCell<[[u8; PACKET_BYTES]; 2]> = StaticCell::new();
    static STATES: StaticCell<[State<'static>; 2]> = StaticCell::new();

    hardware::take_pins(plus, minus);
    let mut device = embassy_usb::Config::new(VENDOR, PRODUCT);
    device.manufacturer = Some("ROBOTIS OpenCR");
    device.product = Some("Power and payload estimation");
    let mut builder = Builder::new(
        Driver::new(),
        device,
        CONFIGURATION.init([0; 256]),
        &mut [],
        &mut [],
        CONTROL.init([0; 64]),
    );
    let [first, second] = STATES.init([State::new(), State::new()]);
    let [first_packet, second_packet] = PACKETS.init([[0; PACKET_BYTES]; 2]);
    let [first_in, second_in] = DATA_TO_HOST;
    let links = [
        UsbLink::new(CdcAcmClass::new(&mut builder, first, PACKET_BYTES as u16), first_packet, first_in),
        UsbLink::new(CdcAcmClass::new(&mut builder, second, PACKET_BYTES as u16), second_packet, second_in),
    ];
    (links, UsbDevice(builder.build()))
}

impl UsbLink {
    fn new(
        class: CdcAcmClass<'static, Driver>,
        packet: &'static mut [u8; PACKET_BYTES],
        in_endpoint: usize,
    ) -> Self {
        let (sender, receiver, control) = class.split_with_control();
        Self {
            sender,
            receiver: receiver.into_buffered(packet),
            control,
            in_endpoint,
            has_terminal: false,
            deadline: None,
            is_open_ended: false,
        }
    }

    /// Hands the host as much as goes at once, or gives the whole answer up.
    async fn send(&mut self, bytes: &[u8]) -> Result<(), NotConnected> {
        let deadline = *self.deadline.get_or_insert_with(|| Instant::now() + PATIENCE);
        let closed = closed(&self.control, &mut self.has_terminal);
        let outcome = select3(closed, self.sender.write_packet(bytes), Timer::at(deadline)).await;
        if let Either3::Second(Ok(())) = outcome {
            return Ok(());
        }
        self.give_up();
        Err(NotConnected)
    }

    /// Takes back what the host has not fetched.
    fn give_up(&mut self) {
        hardware::abandon(self.in_endpoint);
        self.deadline = None;
        self.is_open_ended = false;
    }
}

/// Waits until the program that has the port open closes it.
async fn closed(control: &ControlChanged<'_>, has_terminal: &mut bool) {
    loop {
        let had_terminal = core::mem::replace(has_terminal, control.dtr());
        if had_terminal && !*has_terminal {
            return;
        }
        control.control_changed().await;
    }
}

impl Connection for UsbLink {
    /// Waits until a host has set the port up, and throws away what the last one left.
    async fn wait_connection(&mut self) {
        self.receiver.wait_connection().await;
        self.give_up();
        for _ in 0..MOST_STALE_READS {
            // Of a program that has the port open it may be the first question.
            if self.control.dtr() {
                break;
            }
            let mut stale = [0; PACKET_BYTES];
            let stale = select(self.receiver.read(&mut stale), core::future::ready(())).await;
            if !matches!(stale, Either::First(Ok(_))) {
                break;
            }
        }
    }
}

impl ErrorType for UsbLink {
    type Error = NotConnected;
}

impl Read for UsbLink {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Self::Error> {
        let closed = closed(&self.control, &mut self.has_terminal);
        match select(closed, self.receiver.read(buffer)).await {
            Either::First(()) => {
                self.give_up();
                Err(NotConnected)
            }
            Either::Second(result) => {
                let count = result.map_err(|_| NotConnected)?;
                let received = buffer.get(..count).unwrap_or(&[]);
                loader::look_for_call(self.receiver.line_coding().data_rate(), received);
                Ok(count)
            }
        }
    }
}

impl Write for UsbLink {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
        let count = bytes.len().min(TRANSFER_BYTES);
        self.send(bytes.get(..count).unwrap_or(bytes)).await?;
        self.is_open_ended = count > 0 && count.is_multiple_of(PACKET_BYTES);
        Ok(count)
    }

    /// Ends the host's transfer: one whose last packet is full does not end by itself.
    async fn flush(&mut self) -> Result<(), Self::Error> {
        if core::mem::take(&mut self.is_open_ended) {
            self.send(&[]).await?;
        }
        self.deadline = None;
        Ok(())
    }
}
