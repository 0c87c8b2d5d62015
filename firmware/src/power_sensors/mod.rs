//! The power of each supply rail, measured by an INA219 in it.
//!
//! Source of every register fact: TI SBOS448G (INA219), by section.

mod all;
mod conversion;
mod convert;
mod health;
mod meter;
mod rails;
mod sensor;
#[cfg(test)]
pub(crate) mod testing;

pub use crate::parameters::RAILS;
pub use all::PowerSensors;
pub use conversion::{Reading, Shunt};
pub use convert::{Conversion, Convert};
pub use health::{Counters, Event, Health, Status};
pub use meter::{Meter, RailReading};
pub use rails::{RAIL_COUNT, Rail, RailName};
pub use sensor::PowerSensor;
