//! The servos' bus: one wire that both sides drive in turn, behind a buffer whose direction is a pin.
//!
//! A servo may be set to answer at once, which is sooner than a busy task comes to turn the buffer: the interrupt at the end of the
//! last bit does ([`TurnAround`]).

use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::interrupt::typelevel;
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{DMA1_CH1, DMA1_CH3, PC9, PC10, PC11, PF15, USART3};
use embassy_stm32::usart::{self, RingBufferedUartRx, Uart, UartTx};
use embassy_stm32::{Peri, pac};
use embedded_io_async::{ErrorType, Read, Write};
use static_cell::StaticCell;

use super::Irqs;
use crate::parameters::SERVO_BAUD;

/// Bytes that may arrive while nobody reads: 2.5 ms at full speed, more than a sync read's two answers.
const RING_BYTES: usize = 256;

/// The direction's pin of port C.
const DIRECTION: usize = 9;

/// What the port is made of.
pub(super) struct Parts {
    pub(super) usart: Peri<'static, USART3>,
    pub(super) rx: Peri<'static, PC11>,
    pub(super) tx: Peri<'static, PC10>,
    pub(super) tx_dma: Peri<'static, DMA1_CH3>,
    pub(super) rx_dma: Peri<'static, DMA1_CH1>,
    pub(super) direction: Peri<'static, PC9>,
    pub(super) power: Peri<'static, PF15>,
}

/// Sends and receives on the servos' bus.
///
/// [`Write::write`] takes the bus until its last bit is sent, for which [`Write::flush`] waits. The receiver runs all the time, into a
/// ring that DMA fills.
pub struct ServoPort {
    tx: UartTx<'static, Async>,
    rx: RingBufferedUartRx<'static>,
    /// High: the board talks.
    direction: Output<'static>,
    /// High: the servos have their supply. Dropping it would cut them off.
    _power: Output<'static>,
}

impl ServoPort {
    /// Sets the port up and switches the servos' supply on.
    pub(super) fn new(parts: Parts) -> Self {
        static RING: StaticCell<[u8; RING_BYTES]> = StaticCell::new();
        let mut config = usart::Config::default();
        config.baudrate = SERVO_BAUD;
        let uart = Uart::new(parts.usart, parts.rx, parts.tx, parts.tx_dma, parts.rx_dma, Irqs, config);
        #[expect(
            clippy::unwrap_used,
            reason = "fails only for a rate that the clock above cannot divide to: never"
        )]
        let (tx, rx) = uart.unwrap().split();
        Self {
            tx,
            rx: rx.into_ring_buffered(RING.init([0; RING_BYTES])),
            direction: Output::new(parts.direction, Level::Low, Speed::VeryHigh),
            _power: Output::new(parts.power, Level::High, Speed::Low),
        }
    }
}

impl ErrorType for ServoPort {
    type Error = usart::Error;
}

impl Read for ServoPort {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Self::Error> {
        // Whoever gave up between a write and its flush must not keep the servos from answering.
        self.direction.set_low();
        self.rx.read(buffer).await
    }
}

impl Write for ServoPort {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
        if bytes.is_empty() {
            return Ok(0);
        }
        // From here on the flag means the end of these bytes.
        pac::USART3.icr().write(|register| register.set_tc(true));
        self.direction.set_high();
        critical_section::with(|_| pac::USART3.cr1().modify(|register| register.set_tcie(true)));
        self.tx.write(bytes).await?;
        Ok(bytes.len())
    }

    async fn flush(&mut self) -> Result<(), Self::Error> {
        self.tx.flush().await
    }
}

/// Gives the bus to the servos as soon as nothing is being sent.
pub(super) struct TurnAround;

#[expect(unsafe_code, reason = "the HAL declares handlers unsafe; this one is called for its interrupt only")]
impl typelevel::Handler<typelevel::USART3> for TurnAround {
    unsafe fn on_interrupt() {
        if pac::USART3.isr().read().tc() {
            pac::GPIOC.bsrr().write(|register| register.set_br(DIRECTION, true));
        }
    }
}
