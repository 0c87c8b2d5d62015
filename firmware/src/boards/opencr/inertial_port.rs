//! The inertial sensor's bus: SPI1 on PA5, PA6 and PB5, chosen by PA4.

use embassy_stm32::Peri;
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{DMA2_CH0, DMA2_CH3, PA4, PA5, PA6, PB5, SPI1};
use embassy_stm32::spi::mode::Master;
use embassy_stm32::spi::{Config, MODE_3, Spi};
use embassy_stm32::time::Hertz;
use embassy_time::{Duration, with_timeout};
use embedded_hal_async::spi::{ErrorKind, ErrorType, Operation, SpiDevice};

use crate::boards::opencr::Irqs;

/// The slowest that both chips take for every register (MPU-9250: 1 MHz): 108 MHz / 128.
const CLOCK: Hertz = Hertz(900_000);
/// A reading of fifteen bytes takes 0.14 ms.
const TIMEOUT: Duration = Duration::from_millis(2);

/// Peripheral, pins and channels.
pub(super) struct Parts {
    pub(super) spi: Peri<'static, SPI1>,
    pub(super) clock: Peri<'static, PA5>,
    pub(super) out: Peri<'static, PB5>,
    pub(super) into: Peri<'static, PA6>,
    pub(super) select: Peri<'static, PA4>,
    pub(super) tx_dma: Peri<'static, DMA2_CH3>,
    pub(super) rx_dma: Peri<'static, DMA2_CH0>,
}

/// One chip on its own bus. Transactions end after a time, whatever the peripheral does.
pub struct InertialPort {
    bus: Spi<'static, Async, Master>,
    select: Output<'static>,
}

impl InertialPort {
    pub(super) fn new(parts: Parts) -> Self {
        let mut config = Config::default();
        config.mode = MODE_3;
        config.frequency = CLOCK;
        let Parts { spi, clock, out, into, select, tx_dma, rx_dma } = parts;
        Self {
            bus: Spi::new(spi, clock, out, into, tx_dma, rx_dma, Irqs, config),
            select: Output::new(select, Level::High, Speed::Low),
        }
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
        self.select.set_low();
        let done = with_timeout(TIMEOUT, self.bus.transfer_in_place(words)).await;
        self.select.set_high();
        match done {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) | Err(_) => Err(ErrorKind::Other),
        }
    }
}
