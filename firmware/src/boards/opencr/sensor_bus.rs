//! The power sensors' bus, I2C1, which comes back from what bus and driver can run into.
//!
//! The driver waits for a free bus inside a poll and starves every other task meanwhile, up to its time limit
//! (embassy-rs/embassy#7052): so it is only asked when the bus is free. And its peripheral does not come back by itself from a
//! timeout: so it is taken down, the bus is cleared by clocking the device that holds it (UM10204, 3.1.16), and the driver is set
//! up anew. While the bus is held there is no driver at all: a transaction then looks at the lines and fails.

use embassy_stm32::gpio::{Flex, Pull, Speed};
use embassy_stm32::i2c::{Config, Error, I2c, Master};
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{DMA1_CH0, DMA1_CH6, I2C1, PB7, PB8};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Peri, pac};
use embassy_time::{Duration, Timer};
use embedded_hal_async::i2c::{ErrorType, Operation};

use super::Irqs;
use crate::parameters::SENSOR_BUS_HZ;
use crate::tasks::BusCounters;

/// A transaction of five bytes takes 0.12 ms.
const TIMEOUT: Duration = Duration::from_millis(1);
/// The stop that ends a transaction takes some 2 µs.
const FREE_WITHIN: Duration = Duration::from_micros(20);
/// Half a period of the clock that clears the bus: 100 kHz.
const HALF_PERIOD: Duration = Duration::from_micros(5);
/// A device that holds the data line has at most eight bits and an acknowledgement left to send.
const CLEARING_CLOCKS: usize = 9;

type Driver = I2c<'static, Async, Master>;

/// The sensors' bus.
pub struct SensorBus {
    parts: Parts,
    state: State,
    counters: &'static BusCounters,
}

enum State {
    /// Not set up yet.
    New,
    Running(Driver),
    /// To be cleared and set up again, once no line is held low.
    Stuck,
}

struct Parts {
    i2c: Peri<'static, I2C1>,
    scl: Peri<'static, PB8>,
    sda: Peri<'static, PB7>,
    tx_dma: Peri<'static, DMA1_CH6>,
    rx_dma: Peri<'static, DMA1_CH0>,
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
        let parts = Parts { i2c, scl, sda, tx_dma, rx_dma };
        Self { parts, state: State::New, counters }
    }

    /// The driver, if the lines are free. The first time too: a board that was reset within a transaction finds a sensor
    /// that holds one.
    async fn driver(&mut self) -> Result<&mut Driver, Error> {
        if !matches!(self.state, State::Running(_)) && self.parts.clear_lines().await {
            if matches!(self.state, State::Stuck) {
                self.counters.count_recovery();
            }
            self.state = State::Running(self.parts.driver());
        }
        if matches!(self.state, State::Running(_)) && !is_free().await {
            self.state = State::Stuck;
        }
        match &mut self.state {
            State::Running(driver) => Ok(driver),
            State::New | State::Stuck => Err(Error::Bus),
        }
    }

    /// Takes the peripheral down where it cannot be trusted any more. The next transaction sets it up again.
    fn check<T>(&mut self, result: Result<T, Error>) -> Result<T, Error> {
        match result {
            // A sensor that does not answer is no fault of the bus.
            Ok(_) | Err(Error::Nack | Error::ZeroLengthTransfer) => {}
            Err(error) => {
                if matches!(self.state, State::Running(_)) {
                    defmt::warn!("sensor bus: {}", error);
                    self.state = State::Stuck;
                }
            }
        }
        result
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

impl Parts {
    #[expect(unsafe_code, reason = "the HAL has no way to give a driver's parts back")]
    fn driver(&mut self) -> Driver {
        let mut config = Config::default();
        config.frequency = Hertz(SENSOR_BUS_HZ);
        config.timeout = TIMEOUT;
        // SAFETY: whoever calls this has no driver any more, and the pins' borrows in `clear_lines` have ended.
        unsafe {
            I2c::new(
                self.i2c.clone_unchecked(),
                self.scl.clone_unchecked(),
                self.sda.clone_unchecked(),
                self.tx_dma.clone_unchecked(),
                self.rx_dma.clone_unchecked(),
                Irqs,
                config,
            )
        }
    }

    /// Whether both lines are high, after clocking out who holds the data line.
    async fn clear_lines(&mut self) -> bool {
        let mut scl = Flex::new(self.scl.reborrow());
        let mut sda = Flex::new(self.sda.reborrow());
        // First the level, then the mode: nothing is pulled low in between.
        for line in [&mut scl, &mut sda] {
            line.set_high();
            line.set_as_input_output_pull(Speed::Low, Pull::None);
        }
        Timer::after(HALF_PERIOD).await;
        for _ in 0..CLEARING_CLOCKS {
            if sda.is_high() || scl.is_low() {
                break;
            }
            scl.set_low();
            Timer::after(HALF_PERIOD).await;
            scl.set_high();
            Timer::after(HALF_PERIOD).await;
        }
        let is_free = sda.is_high() && scl.is_high();
        if is_free {
            // A stop: whoever was within a transaction knows that it is over.
            sda.set_low();
            Timer::after(HALF_PERIOD).await;
            sda.set_high();
            Timer::after(HALF_PERIOD).await;
        }
        is_free
    }
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
