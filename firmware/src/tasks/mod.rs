//! What the board does all the time, over the drivers of any board: [`measure`], [`serve`] the host, [`keep`] what it uploads.
//!
//! One executor polls them all, on one core, and none is interrupted by another: what they share needs no critical section
//! ([`Shared`]). What no interrupt may delay beyond its time is short: a sample's arithmetic, an answer on the link.

mod deadline;
mod keep;
mod measure;
mod sensor_bus;
mod serve;
mod shared;
mod show;

pub use keep::keep;
pub use measure::measure;
pub use sensor_bus::{BusCounters, CountedBus};
pub use serve::{Buffers, Connection, serve};
pub use shared::{FIFO_RECORDS, Shared};
