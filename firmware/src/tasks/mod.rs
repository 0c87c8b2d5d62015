//! What the board does all the time, over the drivers of any board: [`measure`], [`serve`] the host, [`keep`]
//! what it uploads, and [`orient`] by the inertial sensor.
//!
//! One executor polls them all, and none interrupts another: what they share needs no critical section ([`Shared`]). What one
//! does between two awaits delays the others: at most some tenths of a millisecond, an answer on the link being the longest.

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
pub use shared::{FIFO_RECORDS, Shared};
pub use watch::watch;
