//! What the driver is made of: it takes the parts, and gives them back when it stops. No second
//! driver can be made of them meanwhile.

use embassy_stm32::Peri;
use embassy_stm32::gpio::{Flex, Pull, Speed};
use embassy_stm32::i2c::{Config, I2c, Master};
use embassy_stm32::mode::Blocking;
use embassy_stm32::peripherals::{I2C1, PB7, PB8};
use embassy_stm32::time::Hertz;
use embassy_time::{Duration, Timer};

use super::transfer;
use crate::parameters::SENSOR_BUS_HZ;

/// Half a period of the clock that clears the bus: 100 kHz.
const HALF_PERIOD: Duration = Duration::from_micros(5);
/// A device that holds the data line has at most eight bits and an acknowledgement left to send.
const CLEARING_CLOCKS: usize = 9;

/// Keeps clock and pins; it moves no bytes ([`super::transfer`]).
type Driver = I2c<'static, Blocking, Master>;

/// Peripheral and pins, while no driver has them.
pub(super) struct Parts {
    i2c: Peri<'static, I2C1>,
    scl: Peri<'static, PB8>,
    sda: Peri<'static, PB7>,
}

/// The driver with its parts, which nobody else reaches as long as it lives.
pub(super) struct Started {
    driver: Driver,
    parts: Parts,
}

impl Started {
    /// Takes the peripheral down.
    pub(super) fn stop(self) -> Parts {
        let Self { driver, parts } = self;
        drop(driver);
        parts
    }
}

impl Parts {
    pub(super) fn new(i2c: Peri<'static, I2C1>, scl: Peri<'static, PB8>, sda: Peri<'static, PB7>) -> Self {
        Self { i2c, scl, sda }
    }

    /// Sets the peripheral up.
    #[expect(unsafe_code, reason = "the HAL has no way to give a driver's parts back")]
    pub(super) fn start(self) -> Started {
        let mut config = Config::default();
        config.frequency = Hertz(SENSOR_BUS_HZ);
        // SAFETY: these are the only ones, taken by value; they are not used again before the
        // driver that is made of their copies is dropped, and its type gives them to nobody else.
        // The pins' borrows in `clear_lines` have ended.
        let driver = unsafe {
            I2c::new_blocking(
                self.i2c.clone_unchecked(),
                self.scl.clone_unchecked(),
                self.sda.clone_unchecked(),
                config,
            )
        };
        transfer::enable();
        Started { driver, parts: self }
    }

    /// Whether both lines are high, after clocking out who holds the data line.
    pub(super) async fn clear_lines(&mut self) -> bool {
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
