//! Counts what goes wrong on the power sensors' bus.

use core::sync::atomic::{AtomicU32, Ordering};

use embedded_hal_async::i2c::{ErrorType, I2c, Operation};

use crate::power_sensors::{Conversion, Convert};

/// What happened on the bus since start. Stops at its maximum.
#[derive(Debug, Default)]
pub struct BusCounters {
    errors: AtomicU32,
    recoveries: AtomicU32,
}

impl BusCounters {
    /// Nothing yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { errors: AtomicU32::new(0), recoveries: AtomicU32::new(0) }
    }

    /// Transactions that failed, for whatever reason.
    #[must_use]
    pub fn errors(&self) -> u32 {
        self.errors.load(Ordering::Relaxed)
    }

    /// Times that the bus was set up again.
    #[must_use]
    pub fn recoveries(&self) -> u32 {
        self.recoveries.load(Ordering::Relaxed)
    }

    /// The bus was set up again.
    pub fn count_recovery(&self) {
        add_one(&self.recoveries);
    }

    fn count<T, E>(&self, result: Result<T, E>) -> Result<T, E> {
        if result.is_err() {
            add_one(&self.errors);
        }
        result
    }
}

/// Only the task that has the bus counts: nobody comes in between.
fn add_one(counter: &AtomicU32) {
    counter.store(counter.load(Ordering::Relaxed).saturating_add(1), Ordering::Relaxed);
}

/// A bus whose failed transactions are counted.
pub struct CountedBus<I> {
    bus: I,
    counters: &'static BusCounters,
}

impl<I> CountedBus<I> {
    /// Counts in `counters` what fails on `bus`.
    pub fn new(bus: I, counters: &'static BusCounters) -> Self {
        Self { bus, counters }
    }
}

impl<I: ErrorType> ErrorType for CountedBus<I> {
    type Error = I::Error;
}

impl<I: I2c> I2c for CountedBus<I> {
    async fn read(&mut self, address: u8, bytes: &mut [u8]) -> Result<(), I::Error> {
        self.counters.count(self.bus.read(address, bytes).await)
    }

    async fn write(&mut self, address: u8, bytes: &[u8]) -> Result<(), I::Error> {
        self.counters.count(self.bus.write(address, bytes).await)
    }

    async fn write_read(&mut self, address: u8, sent: &[u8], received: &mut [u8]) -> Result<(), I::Error> {
        self.counters.count(self.bus.write_read(address, sent, received).await)
    }

    async fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), I::Error> {
        self.counters.count(self.bus.transaction(address, operations).await)
    }
}

impl<I: Convert> Convert for CountedBus<I> {
    async fn convert_each(&mut self, conversions: &mut [Option<Conversion>]) {
        self.bus.convert_each(conversions).await;
        for conversion in conversions.iter().flatten() {
            // Failed, for whatever reason.
            let _ = self.counters.count(conversion.answer.ok_or(()));
        }
    }
}
