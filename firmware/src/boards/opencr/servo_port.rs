//! The servos' bus: one wire that both sides drive in turn, behind a buffer whose direction is a
//! pin.
//!
//! A servo may be set to answer at once, which is sooner than a busy task comes to turn the buffer:
//! the interrupt at the end of the last bit does ([`TurnAround`]).

use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::interrupt::typelevel;
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{DMA1_CH1, DMA1_CH3, PC9, PC10, PC11, PF15, USART3};
use embassy_stm32::usart::{self, RingBufferedUartRx, Uart, UartTx};
use embassy_stm32::{Peri, pac};
use embedded_io_async::{ErrorType, Read, Write};

use super::Irqs;
use crate::parameters::SERVO_BAUD;
use crate::wheels::SwitchedPort;

/// Bytes that may arrive while nobody reads: 2.5 ms at full speed, more than a sync read's two
/// answers.
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
}

/// The driver's two halves.
struct Driver {
    tx: UartTx<'static, Async>,
    rx: RingBufferedUartRx<'static>,
}

impl Parts {
    /// Sets the peripheral up, its receiver running into the ring. `None` for a rate that the clock
    /// cannot divide to: never.
    #[expect(unsafe_code, reason = "the HAL has no way to give a driver's parts and its ring back")]
    fn start(&mut self) -> Option<Driver> {
        static mut RING: [u8; RING_BYTES] = [0; RING_BYTES];
        let mut config = usart::Config::default();
        config.baudrate = SERVO_BAUD;
        // SAFETY: these parts are the only ones, and the driver made of their copies before this
        // one has been dropped: its DMA is off.
        let (uart, ring) = unsafe {
            let uart = Uart::new(
                self.usart.clone_unchecked(),
                self.rx.clone_unchecked(),
                self.tx.clone_unchecked(),
                self.tx_dma.clone_unchecked(),
                self.rx_dma.clone_unchecked(),
                Irqs,
                config,
            );
            (uart.ok()?, &mut *core::ptr::addr_of_mut!(RING))
        };
        let (tx, rx) = uart.split();
        Some(Driver { tx, rx: rx.into_ring_buffered(ring) })
    }
}

/// Sends and receives on the servos' bus.
///
/// [`Write::write`] takes the bus until its last bit is sent, for which [`Write::flush`] waits. The receiver runs all the time, into a
/// ring that DMA fills. After an error it is set up anew: the driver would resume the ring where it
/// stopped, and what the ring then holds is not what came.
pub struct ServoPort {
    parts: Parts,
    driver: Option<Driver>,
    /// High: the board talks.
    direction: Output<'static>,
    /// High: the servos have their supply. Dropping it would cut them off.
    supply: Output<'static>,
}

impl ServoPort {
    /// Sets the port up and switches the servos' supply on.
    pub(super) fn new(mut parts: Parts, direction: Peri<'static, PC9>, supply: Peri<'static, PF15>) -> Self {
        Self {
            driver: parts.start(),
            parts,
            direction: Output::new(direction, Level::Low, Speed::VeryHigh),
            supply: Output::new(supply, Level::High, Speed::Low),
        }
    }

    /// The driver; after an error a new one.
    fn driver(&mut self) -> Result<&mut Driver, usart::Error> {
        if self.driver.is_none() {
            self.driver = self.parts.start();
        }
        self.driver.as_mut().ok_or(usart::Error::Overrun)
    }
}

impl SwitchedPort for ServoPort {
    fn set_supply(&mut self, on: bool) {
        self.supply.set_level(Level::from(on));
    }
}

impl ErrorType for ServoPort {
    type Error = usart::Error;
}

impl Read for ServoPort {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Self::Error> {
        // Whoever gave up between a write and its flush must not keep the servos from answering.
        self.direction.set_low();
        let result = self.driver()?.rx.read(buffer).await;
        if result.is_err() {
            self.driver = None;
        }
        result
    }
}

impl Write for ServoPort {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
        if bytes.is_empty() {
            return Ok(0);
        }
        self.driver()?;
        // From here on the flag means the end of these bytes.
        pac::USART3.icr().write(|register| register.set_tc(true));
        self.direction.set_high();
        critical_section::with(|_| pac::USART3.cr1().modify(|register| register.set_tcie(true)));
        self.driver()?.tx.write(bytes).await?;
        Ok(bytes.len())
    }

    async fn flush(&mut self) -> Result<(), Self::Error> {
        self.driver()?.tx.flush().await
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
