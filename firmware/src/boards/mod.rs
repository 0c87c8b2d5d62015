//! The two boards that the same tasks run on: what differs between them ends here.

#[cfg(any(feature = "opencr", feature = "virtual"))]
mod image;
#[cfg(any(feature = "opencr", feature = "virtual"))]
mod key;
#[cfg(feature = "opencr")]
pub mod opencr;
#[cfg(any(feature = "opencr", feature = "virtual"))]
mod stack;
#[cfg(feature = "virtual")]
pub mod virtual_board;
#[cfg(any(feature = "opencr", feature = "virtual"))]
mod wiring;

#[cfg(any(feature = "opencr", feature = "virtual"))]
pub use {
    key::VERIFY,
    stack::watch_stack,
    wiring::{sampler, send, start},
};

// What stands before every line of the log.
#[cfg(any(feature = "opencr", feature = "virtual"))]
defmt::timestamp!("{=u64:us}", embassy_time::Instant::now().as_micros());
