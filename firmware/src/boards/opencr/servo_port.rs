//! The servos' bus: one wire that both sides drive in turn, behind a buffer whose direction is a
//! pin.
//!
//! The HAL's driver sets the peripheral up; [`wire`] moves the bytes.

mod wire;

use embassy_stm32::Peri;
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::mode::Blocking;
use embassy_stm32::peripherals::{DMA1_CH1, DMA1_CH3, PC9, PC10, PC11, PF15, USART3};
use embassy_stm32::usart::{self, Uart};
use embedded_io_async::{ErrorType, Read, Write};

use crate::parameters::SERVO_BAUD;
use crate::wheels::SwitchedPort;
pub(super) use wire::Events;

/// What the port is made of.
pub(super) struct Parts {
    pub(super) usart: Peri<'static, USART3>,
    pub(super) rx: Peri<'static, PC11>,
    pub(super) tx: Peri<'static, PC10>,
}

/// Sends and receives on the servos' bus.
///
/// [`Write::write`] takes the bus until its last bit is sent. The receiver runs all the time.
pub struct ServoPort {
    /// Keeps clock and pins; it moves no bytes. `None` for a rate that the clock cannot divide to:
    /// never.
    driver: Option<Uart<'static, Blocking>>,
    /// High: the board talks.
    direction: Output<'static>,
    /// High: the servos have their supply. Dropping it would cut them off.
    supply: Output<'static>,
}

impl ServoPort {
    /// Sets the port up and switches the servos' supply on.
    pub(super) fn new(
        parts: Parts,
        // Nobody else has the streams that `wire` uses.
        _streams: (Peri<'static, DMA1_CH1>, Peri<'static, DMA1_CH3>),
        direction: Peri<'static, PC9>,
        supply: Peri<'static, PF15>,
    ) -> Self {
        let mut config = usart::Config::default();
        config.baudrate = SERVO_BAUD;
        let driver = Uart::new_blocking(parts.usart, parts.rx, parts.tx, config).ok();
        let direction = Output::new(direction, Level::Low, Speed::VeryHigh);
        if driver.is_some() {
            wire::enable();
        }
        Self { driver, direction, supply: Output::new(supply, Level::High, Speed::Low) }
    }

    fn check(&self) -> Result<(), usart::Error> {
        self.driver.as_ref().map(|_| ()).ok_or(usart::Error::Overrun)
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
        self.check()?;
        // Whoever gave a write up must not keep the servos from answering.
        self.direction.set_low();
        wire::receive(buffer).await
    }
}

impl Write for ServoPort {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
        self.check()?;
        if bytes.is_empty() {
            return Ok(0);
        }
        self.direction.set_high();
        Ok(wire::send(bytes).await)
    }

    async fn flush(&mut self) -> Result<(), Self::Error> {
        Ok(())
    }
}
