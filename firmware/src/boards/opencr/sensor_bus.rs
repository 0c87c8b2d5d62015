//! The power sensors' bus, I2C1, which comes back from whatever a bus can run into.
//!
//! The HAL's driver sets the peripheral up; [`transfer`] moves the bytes. After a timeout, lost
//! arbitration or a bus error the peripheral is taken down, the bus is cleared by clocking the
//! device that holds it (UM10204, 3.1.16), and everything is set up anew. While the bus is held
//! there is no driver at all: a transaction then looks at the lines and fails.

mod parts;
mod transfer;

use embassy_stm32::i2c::Error;
use embassy_stm32::peripherals::{DMA1_CH5, DMA1_CH6, I2C1, PB7, PB8};
use embassy_stm32::{Peri, pac};
use embassy_time::{Duration, Timer};
use embedded_hal_async::i2c::{ErrorType, Operation};

use super::time::Limit;
use crate::power_sensors::{Conversion, Convert};
use crate::tasks::BusCounters;
use parts::{Parts, Started};
pub(super) use transfer::{Errors, Events};

/// A transaction of 22 bytes, a sensor's longest, takes 0.5 ms.
const LIMIT_US: u32 = 1000;
/// What each of those behind it adds: its 0.5 ms, and a fifth more.
const MORE_US: u32 = 600;
/// The stop that ends a transaction takes some 2 µs.
const FREE_WITHIN: Duration = Duration::from_micros(20);

/// The sensors' bus.
pub struct SensorBus {
    /// While there is no driver: not set up yet, or to be cleared and set up again, once no line is
    /// held low.
    parts: Option<Parts>,
    started: Option<Started>,
    has_run: bool,
    limit: Limit,
    counters: &'static BusCounters,
}

impl SensorBus {
    pub(super) fn new(
        i2c: Peri<'static, I2C1>,
        scl: Peri<'static, PB8>,
        sda: Peri<'static, PB7>,
        // Nobody else has the streams that `transfer` uses.
        _streams: (Peri<'static, DMA1_CH5>, Peri<'static, DMA1_CH6>),
        limit: Limit,
        counters: &'static BusCounters,
    ) -> Self {
        let parts = Parts::new(i2c, scl, sda);
        Self { parts: Some(parts), started: None, has_run: false, limit, counters }
    }

    /// Sets the driver up, if the lines are free. The first time too: a board that was reset within
    /// a transaction finds a sensor that holds one.
    async fn prepare(&mut self) -> Result<(), Error> {
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
        if self.started.is_some() { Ok(()) } else { Err(Error::Bus) }
    }

    /// Takes the peripheral down where it cannot be trusted any more. The next transaction sets it
    /// up again.
    fn check<T>(&mut self, result: Result<T, Error>) -> Result<T, Error> {
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

impl ErrorType for SensorBus {
    type Error = Error;
}

impl embedded_hal_async::i2c::I2c for SensorBus {
    /// Writes, each followed by a read.
    async fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), Error> {
        self.prepare().await?;
        let result = self.limit.within(LIMIT_US, transfer::transfer(address, operations)).await;
        self.check(result.unwrap_or(Err(Error::Timeout)))
    }
}

impl Convert for SensorBus {
    /// A sensor that does not acknowledge costs its own answer, and so does what ends one
    /// transaction on the bus. Where the bus is held, nobody behind is asked: all of it is over
    /// within the limit of the first try.
    async fn convert_each(&mut self, conversions: &mut [Option<Conversion>]) {
        let mut rest = conversions;
        loop {
            let count = rest.iter().flatten().count() as u32;
            if count == 0 || self.prepare().await.is_err() {
                return;
            }
            let limit_us = LIMIT_US + MORE_US * (count - 1);
            let in_time = self.limit.within(limit_us, transfer::convert(rest)).await;
            let (failed, error) = match (transfer::collect(rest), in_time) {
                (Ok(()), _) => return,
                (Err((failed, _)), Some(Err(error))) => (failed, error),
                (Err(failure), Some(Ok(()))) => failure,
                (Err(_), None) => (rest.len(), Error::Timeout),
            };
            let _ = self.check::<()>(Err(error));
            let next = rest.iter().enumerate().filter(|(_, asked)| asked.is_some()).nth(failed);
            let next = next.map_or(rest.len(), |(index, _)| index + 1);
            rest = rest.get_mut(next..).unwrap_or_default();
        }
    }
}
