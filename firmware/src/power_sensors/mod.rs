//! The power of each supply rail, measured by an INA219 in it.
//!
//! Source of every register fact: TI SBOS448G (INA219), by section.

mod conversion;
mod health;
mod rails;
mod sensor;

pub use conversion::{Reading, Shunt};
pub use health::{Counters, Event, Health, Status};
pub use rails::{RAIL_COUNT, RAILS, Rail, RailName};
pub use sensor::{CONFIGURATION, PowerSensor};
