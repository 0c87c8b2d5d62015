//! The inertial sensor's bus: SPI1 on PA5, PA6 and PB5, chosen by PA4. The HAL's driver sets the
//! peripheral up; DMA moves the bytes, and who waits is woken once, by the last of them.

use core::future::poll_fn;
use core::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use core::task::Poll;

use embassy_stm32::Peri;
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::interrupt::typelevel::{self, Interrupt};
use embassy_stm32::mode::Blocking;
use embassy_stm32::pac::SPI1;
use embassy_stm32::pac::dma::vals::Dir;
use embassy_stm32::peripherals::{self, DMA2_CH0, DMA2_CH3, PA4, PA5, PA6, PB5};
use embassy_stm32::spi::mode::Master;
use embassy_stm32::spi::{Config, MODE_3, Spi};
use embassy_stm32::time::Hertz;
use embassy_sync::waitqueue::AtomicWaker;
use embedded_hal_async::spi::{ErrorKind, ErrorType, Operation, SpiDevice};

use super::streams::{Controller, Manner, Stream};
use super::time::Limit;

/// The slowest that both chips take for every register (MPU-9250: 1 MHz): 108 MHz / 128.
const CLOCK: Hertz = Hertz(900_000);
/// A reading of fifteen bytes takes 0.14 ms.
const LIMIT_US: u32 = 2000;
/// The longest transaction.
const MOST_BYTES: usize = 16;
/// What the peripheral keeps of what it has received.
const FIFO_BYTES: usize = 4;
const RECEIVING: Stream = Stream { controller: Controller::Two, number: 0, channel: 3 };
const SENDING: Stream = Stream { controller: Controller::Two, number: 3, channel: 3 };

struct Wire {
    sent: [AtomicU8; MOST_BYTES],
    received: [AtomicU8; MOST_BYTES],
    is_over: AtomicBool,
    waker: AtomicWaker,
}

static WIRE: Wire = Wire {
    sent: [const { AtomicU8::new(0) }; MOST_BYTES],
    received: [const { AtomicU8::new(0) }; MOST_BYTES],
    is_over: AtomicBool::new(true),
    waker: AtomicWaker::new(),
};

/// Peripheral and pins.
pub(super) struct Parts {
    pub(super) spi: Peri<'static, peripherals::SPI1>,
    pub(super) clock: Peri<'static, PA5>,
    pub(super) out: Peri<'static, PB5>,
    pub(super) into: Peri<'static, PA6>,
    pub(super) select: Peri<'static, PA4>,
}

/// One chip on its own bus. Transactions end after a time, whatever the peripheral does.
pub struct InertialPort {
    /// Keeps clock and pins; it moves no bytes.
    _driver: Spi<'static, Blocking, Master>,
    select: Output<'static>,
    limit: Limit,
}

impl InertialPort {
    #[expect(unsafe_code, reason = "enables an interrupt: no critical section relies on its being masked")]
    pub(super) fn new(
        parts: Parts,
        // Nobody else has the streams that are used here.
        _streams: (Peri<'static, DMA2_CH0>, Peri<'static, DMA2_CH3>),
        limit: Limit,
    ) -> Self {
        let mut config = Config::default();
        config.mode = MODE_3;
        config.frequency = CLOCK;
        let Parts { spi, clock, out, into, select } = parts;
        let driver = Spi::new_blocking(spi, clock, out, into, config);
        RECEIVING.connect(SPI1.dr16().as_ptr().cast());
        SENDING.connect(SPI1.dr16().as_ptr().cast());
        SPI1.cr2().modify(|register| {
            register.set_rxdmaen(true);
            register.set_txdmaen(true);
        });
        // SAFETY: see above.
        unsafe { typelevel::DMA2_STREAM0::enable() };
        let select = Output::new(select, Level::High, Speed::Low);
        Self { _driver: driver, select, limit }
    }
}

impl ErrorType for InertialPort {
    type Error = ErrorKind;
}

impl SpiDevice for InertialPort {
    /// The one shape that a register device needs, in place: each other would be more of the
    /// driver's code in the image.
    async fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        let [Operation::TransferInPlace(words)] = operations else { return Err(ErrorKind::Other) };
        if words.len() > MOST_BYTES {
            return Err(ErrorKind::Other);
        }
        self.select.set_low();
        let done = self.limit.within(LIMIT_US, transfer(words)).await;
        self.select.set_high();
        done.ok_or(ErrorKind::Other)
    }
}

/// Sends the bytes and puts what came meanwhile into their places.
async fn transfer(words: &mut [u8]) {
    WIRE.sent.iter().zip(&*words).for_each(|(place, byte)| place.store(*byte, Ordering::Relaxed));
    WIRE.is_over.store(false, Ordering::Relaxed);
    SPI1.cr1().modify(|register| register.set_spe(false));
    // What a transaction that was given up has left.
    for _ in 0..FIFO_BYTES {
        if SPI1.sr().read().rxne() {
            let _ = SPI1.dr16().read();
        }
    }
    RECEIVING.begin(&WIRE.received, words.len(), Dir::PERIPHERAL_TO_MEMORY, Manner::Telling);
    SENDING.begin(&WIRE.sent, words.len(), Dir::MEMORY_TO_PERIPHERAL, Manner::Once);
    SPI1.cr1().modify(|register| register.set_spe(true));
    poll_fn(|context| {
        WIRE.waker.register(context.waker());
        if WIRE.is_over.load(Ordering::Acquire) { Poll::Ready(()) } else { Poll::Pending }
    })
    .await;
    words.iter_mut().zip(&WIRE.received).for_each(|(place, byte)| *place = byte.load(Ordering::Relaxed));
}

/// The interrupt behind the last byte that is received.
pub(super) struct Received;

#[expect(unsafe_code, reason = "the HAL declares handlers unsafe; this one is called for its interrupt only")]
impl typelevel::Handler<typelevel::DMA2_STREAM0> for Received {
    unsafe fn on_interrupt() {
        RECEIVING.clear();
        WIRE.is_over.store(true, Ordering::Release);
        WIRE.waker.wake();
    }
}
