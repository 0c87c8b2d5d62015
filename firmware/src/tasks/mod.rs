//! What the board does all the time, over the drivers of any board: [`measure`], [`serve`] the
//! host, [`keep`] what it uploads, and [`orient`] by the inertial sensor.
//!
//! On a board [`measure`] and [`orient`] interrupt the others: whatever a host sends, samples are
//! on time. What they share is lent for a moment in which nothing interrupts ([`Shared`]), so it is
//! never for long: the longest is a read of all registers. On the virtual board, where a bus takes
//! no time, one executor polls them all.

mod deadline;
mod keep;
mod measure;
mod orient;
mod sensor_bus;
mod serve;
mod shared;
mod supply;
mod watch;

pub use keep::keep;
pub use measure::measure;
pub use orient::orient;
pub use sensor_bus::{BusCounters, CountedBus};
pub use serve::{Buffers, Connection, serve};
pub use shared::{Records, Reporter, Shared};
pub use watch::watch;
