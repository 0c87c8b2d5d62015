//! From a board's drivers to a sampler and running tasks.

use embassy_executor::{SendSpawner, SpawnError, SpawnToken, Spawner};
use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{Read, Write};

use crate::measurement::Sampler;
use crate::power_sensors::{Convert, PowerSensors};
use crate::tasks::{BusCounters, CountedBus};
use crate::wheels::Wheels;

/// Samples on these buses; `limit` bounds what is waited for on the servos'. What happens on the
/// sensors' is counted.
pub fn sampler<B: Convert, P: Read + Write, D: DelayNs>(
    sensors: B,
    servos: P,
    limit: D,
    counters: &'static BusCounters,
) -> Sampler<CountedBus<B>, P, D> {
    let sensors = PowerSensors::new(CountedBus::new(sensors, counters));
    Sampler::new(sensors, Wheels::new(servos, limit))
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
