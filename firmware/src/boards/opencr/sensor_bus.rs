//! The power sensors' bus, I2C1, which comes back from what bus and driver can run into.
//!
//! The driver waits for a free bus inside a poll and starves every other task meanwhile, up to its time limit
//! (embassy-rs/embassy#7052): so it is only asked when the bus is free. And its peripheral does not come back by itself from a
//! timeout: so it is taken down, the bus is cleared by clocking the device that holds it (UM10204, 3.1.16), and the driver is set
//! up anew. While the bus is held there is no driver at all: a transaction then looks at the lines and fails.

mod parts;

use embassy_stm32::i2c::Error;
use embassy_stm32::peripherals::{DMA1_CH0, DMA1_CH6, I2C1, PB7, PB8};
use embassy_stm32::{Peri, pac};
use embassy_time::{Duration, Timer};
use embedded_hal_async::i2c::{ErrorType, Operation};

use crate::tasks::BusCounters;
use parts::{Driver, Parts, Started};

/// The stop that ends a transaction takes some 2 µs.
const FREE_WITHIN: Duration = Duration::from_micros(20);

/// The sensors' bus.
pub struct SensorBus {
    /// While there is no driver: not set up yet, or to be cleared and set up again, once no line is held low.
    parts: Option<Parts>,
    started: Option<Started>,
    has_run: bool,
    counters: &'static BusCounters,
}

impl SensorBus {
    pub(super) fn new(
        i2c: Peri<'static, I2C1>,
        scl: Peri<'static, PB8>,
        sda: Peri<'static, PB7>,
        tx_dma: Peri<'static, DMA1_CH6>,
        rx_dma: Peri<'static, DMA1_CH0>,
        counters: &'static BusCounters,
    ) -> Self {
        let parts = Parts::new(i2c, scl, sda, tx_dma, rx_dma);
        Self { parts: Some(parts), started: None, has_run: false, counters }
    }

    /// The driver, if the lines are free. The first time too: a board that was reset within a transaction finds a sensor
    /// that holds one.
    async fn driver(&mut self) -> Result<&mut Driver, Error> {
        if let Some(parts) = &mut self.parts
            && parts.clear_lines().await
            && let Some(parts) = self.parts.take()
        {
            self.started = Some(parts.start());
            if self.has_run {
                self.counters.count_recovery();
            }
            self.has_run = true;
        }
        if self.started.is_some() && !is_free().await {
            self.stop();
        }
        // From here on the flag means that this transaction was stopped.
        pac::I2C1.icr().write(|register| register.set_stopcf(true));
        self.started.as_mut().map(Started::driver).ok_or(Error::Bus)
    }

    /// Takes the peripheral down where it cannot be trusted any more. The next transaction sets it up again.
    fn check<T>(&mut self, result: Result<T, Error>) -> Result<T, Error> {
        let result = match result {
            Err(Error::Timeout) if is_refused() => Err(Error::Nack),
            other => other,
        };
        match result {
            // A sensor that does not answer is no fault of the bus.
            Ok(_) | Err(Error::Nack | Error::ZeroLengthTransfer) => {}
            Err(error) => {
                if self.started.is_some() {
                    defmt::warn!("sensor bus: {}", error);
                    self.stop();
                }
            }
        }
        result
    }

    fn stop(&mut self) {
        if let Some(started) = self.started.take() {
            self.parts = Some(started.stop());
        }
    }
}

/// Whether nobody uses the bus any more.
async fn is_free() -> bool {
    let is_busy = || pac::I2C1.isr().read().busy();
    if is_busy() {
        Timer::after(FREE_WITHIN).await;
    }
    !is_busy()
}

/// Whether what timed out was no fault of the bus, but a sensor that did not acknowledge.
///
/// A repeated start that is not acknowledged the driver does not see: it waits for the bytes alone, until its time is over. The
/// peripheral has seen it, and ended the transaction with a stop (RM0385, I2C controller, NACK reception): the bus is free, and the
/// flag is set, which a line that is held low does not let happen.
fn is_refused() -> bool {
    let status = pac::I2C1.isr().read();
    status.stopf() && !status.busy()
}

impl ErrorType for SensorBus {
    type Error = Error;
}

impl embedded_hal_async::i2c::I2c for SensorBus {
    async fn read(&mut self, address: u8, bytes: &mut [u8]) -> Result<(), Error> {
        let result = self.driver().await?.read(address, bytes).await;
        self.check(result)
    }

    async fn write(&mut self, address: u8, bytes: &[u8]) -> Result<(), Error> {
        let result = self.driver().await?.write(address, bytes).await;
        self.check(result)
    }

    async fn write_read(&mut self, address: u8, sent: &[u8], received: &mut [u8]) -> Result<(), Error> {
        let result = self.driver().await?.write_read(address, sent, received).await;
        self.check(result)
    }

    async fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), Error> {
        let result = self.driver().await?.transaction(address, operations).await;
        self.check(result)
    }
}
