//! From a board's drivers to a sampler and running tasks.

use embassy_embedded_hal::shared_bus::asynch::i2c::I2cDevice;
use embassy_executor::{SendSpawner, SpawnError, SpawnToken, Spawner};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_time::Delay;
use embedded_hal_async::i2c::I2c;
use embedded_io_async::{Read, Write};

use crate::measurement::Sampler;
use crate::power_sensors::{PowerSensors, RAILS};
use crate::tasks::CountedBus;
use crate::wheels::Wheels;

/// The sensors' bus.
pub type SharedSensorBus<B> = Mutex<CriticalSectionRawMutex, CountedBus<B>>;

/// One sensor's handle of it.
pub type SensorHandle<B> = I2cDevice<'static, CriticalSectionRawMutex, CountedBus<B>>;

/// Samples on these buses.
pub fn sampler<B: I2c + 'static, P: Read + Write>(
    sensors: &'static SharedSensorBus<B>,
    servos: P,
) -> Sampler<SensorHandle<B>, P, Delay> {
    let handles = RAILS.map(|_| I2cDevice::new(sensors));
    Sampler::new(PowerSensors::new(handles), Wheels::new(servos, Delay))
}

/// Starts a task.
pub fn start<S>(spawner: Spawner, task: Result<SpawnToken<S>, SpawnError>) {
    match task {
        Ok(task) => spawner.spawn(task),
        Err(_) => complain(),
    }
}

/// Starts a task that another one may interrupt, or that interrupts others.
pub fn send<S: Send>(spawner: SendSpawner, task: Result<SpawnToken<S>, SpawnError>) {
    match task {
        Ok(task) => spawner.spawn(task),
        Err(_) => complain(),
    }
}

/// There is room for one of each: an image that starts one twice is wrong.
fn complain() {
    defmt::error!("a task was started twice");
}
