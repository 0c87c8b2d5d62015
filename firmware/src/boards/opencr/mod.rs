//! OpenCR 1.0: STM32F746ZG, sensors on I2C1, servos on USART3, the link on USB. Pins and traps:
//! docs/board.md.

mod clock;
mod copy;
mod erase;
mod failure;
mod inertial_port;
mod last_words;
mod loader;
mod panel;
mod sampling;
mod sensor_bus;
mod servo_port;
mod start;
mod store_flash;
mod streams;
mod time;
mod usb;
pub mod watchdog;

use embassy_stm32::Peri;
use embassy_stm32::bind_interrupts;
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::peripherals::PG9;
use embassy_time::{Duration, Timer};

use defmt_rtt as _;

use crate::reset::ResetReport;
use crate::tasks::BusCounters;

pub use inertial_port::InertialPort;
pub use panel::Panel;
pub use sampling::sampling;
pub use sensor_bus::SensorBus;
pub use servo_port::ServoPort;
pub use store_flash::StoreFlash;
pub use time::Limit;
pub use usb::{UsbDevice, UsbLink as Link};

bind_interrupts!(struct Irqs {
    I2C1_EV => sensor_bus::Events;
    I2C1_ER => sensor_bus::Errors;
    DMA2_STREAM0 => inertial_port::Received;
    USART3 => servo_port::Events;
    OTG_FS => usb::Interrupt;
    TIM5 => time::Tick;
});

/// What the tasks use of the board.
pub struct Board {
    /// The four power sensors.
    pub sensors: SensorBus,
    /// The wheel servos. Their supply is on.
    pub servos: ServoPort,
    /// Bounds what is waited for on their bus.
    pub servo_limit: Limit,
    /// The inertial sensor.
    pub inertial: InertialPort,
    /// The host: the port that the ROS node opens, and ours.
    pub links: [Link; 2],
    /// Serves the bus that the link is on; has to be run.
    pub usb: UsbDevice,
    /// Coefficients, calibration and robot.
    pub store: StoreFlash,
    /// The one on the board's edge.
    pub status_led: StatusLed,
    /// LEDs, buttons and the supply's voltage.
    pub panel: Panel,
    /// Why the board has started.
    pub reset: ResetReport,
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

/// Sets up clocks, pins and drivers. To be called once. What happens on the sensors' bus is counted
/// in `counters`.
pub fn init(counters: &'static BusCounters) -> Board {
    // First: a crystal that does not start is waited for without end.
    let reset = last_words::report();
    watchdog::start();
    let p = embassy_stm32::init(clock::config());
    watchdog::feed();
    time::start();
    clock::enable_instruction_cache();
    erase::watch_supply();
    defmt::info!("OpenCR: up after {=str}", reset.cause.text());
    let (links, usb) = usb::new(p.USB_OTG_FS, p.PA12, p.PA11);
    let servos = servo_port::Parts { usart: p.USART3, rx: p.PC11, tx: p.PC10 };
    let inertial = inertial_port::Parts { spi: p.SPI1, clock: p.PA5, out: p.PB5, into: p.PA6, select: p.PA4 };
    let [sensor_limit, servo_limit, inertial_limit] = Limit::all();
    let sensor_streams = (p.DMA1_CH5, p.DMA1_CH6);
    let inertial_streams = (p.DMA2_CH0, p.DMA2_CH3);
    Board {
        sensors: SensorBus::new(p.I2C1, p.PB8, p.PB7, sensor_streams, sensor_limit, counters),
        servos: ServoPort::new(servos, (p.DMA1_CH1, p.DMA1_CH3), p.PC9, p.PF15),
        servo_limit,
        inertial: InertialPort::new(inertial, inertial_streams, inertial_limit),
        links,
        usb,
        store: StoreFlash::new(p.FLASH),
        status_led: StatusLed::new(p.PG9),
        panel: Panel::new(panel::Parts {
            leds: [p.PG12.into(), p.PE5.into(), p.PE4.into(), p.PG10.into()],
            buttons: [p.PG3.into(), p.PC12.into()],
            converter: p.ADC3,
            supply: p.PC0,
        }),
        reset,
    }
}
