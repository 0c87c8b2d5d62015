//! OpenCR 1.0: STM32F746ZG, sensors on I2C1, servos on USART3, the link on USB. Pins and traps: docs/board.md.

mod clock;
mod failure;
mod sensor_bus;
mod servo_port;
mod start;
mod store_flash;
mod usb_link;

use embassy_stm32::Peri;
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::peripherals::PG9;
use embassy_stm32::{bind_interrupts, dma, i2c, peripherals, usart, usb};
use embassy_time::{Duration, Timer};

use defmt_rtt as _;

use crate::tasks::BusCounters;

pub use sensor_bus::SensorBus;
pub use servo_port::ServoPort;
pub use store_flash::StoreFlash;
pub use usb_link::{UsbDevice, UsbLink};

bind_interrupts!(struct Irqs {
    I2C1_EV => i2c::EventInterruptHandler<peripherals::I2C1>;
    I2C1_ER => i2c::ErrorInterruptHandler<peripherals::I2C1>;
    DMA1_STREAM6 => dma::InterruptHandler<peripherals::DMA1_CH6>;
    DMA1_STREAM0 => dma::InterruptHandler<peripherals::DMA1_CH0>;
    USART3 => usart::InterruptHandler<peripherals::USART3>, servo_port::TurnAround;
    DMA1_STREAM3 => dma::InterruptHandler<peripherals::DMA1_CH3>;
    DMA1_STREAM1 => dma::InterruptHandler<peripherals::DMA1_CH1>;
    OTG_FS => usb::InterruptHandler<peripherals::USB_OTG_FS>;
});

/// What the tasks use of the board.
pub struct Board {
    /// The four power sensors.
    pub sensors: SensorBus,
    /// The wheel servos. Their supply is on.
    pub servos: ServoPort,
    /// The host.
    pub link: UsbLink,
    /// Serves the bus that the link is on; has to be run.
    pub usb: UsbDevice,
    /// Coefficients, calibration and robot.
    pub store: StoreFlash,
    /// The one on the board's edge.
    pub status_led: StatusLed,
}

/// The status LED: lit while its pin is low.
pub struct StatusLed(Output<'static>);

impl StatusLed {
    fn new(pin: Peri<'static, PG9>) -> Self {
        Self(Output::new(pin, Level::High, Speed::Low))
    }

    /// Blinks once a second for as long as the tasks run.
    pub async fn blink(&mut self) -> ! {
        loop {
            self.0.toggle();
            Timer::after(Duration::from_millis(500)).await;
        }
    }
}

/// Sets up clocks, pins and drivers. To be called once. What happens on the sensors' bus is counted in `counters`.
pub fn init(counters: &'static BusCounters) -> Board {
    let p = embassy_stm32::init(clock::config());
    clock::enable_instruction_cache();
    defmt::info!("OpenCR: up");
    let (link, usb) = usb_link::new(p.USB_OTG_FS, p.PA12, p.PA11);
    Board {
        sensors: SensorBus::new(p.I2C1, p.PB8, p.PB7, p.DMA1_CH6, p.DMA1_CH0, counters),
        servos: ServoPort::new(servo_port::Parts {
            usart: p.USART3,
            rx: p.PC11,
            tx: p.PC10,
            tx_dma: p.DMA1_CH3,
            rx_dma: p.DMA1_CH1,
            direction: p.PC9,
            power: p.PF15,
        }),
        link,
        usb,
        store: StoreFlash::new(p.FLASH),
        status_led: StatusLed::new(p.PG9),
    }
}
