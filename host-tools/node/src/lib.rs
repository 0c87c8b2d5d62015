//! One power sensor on the robot's own computer, wheel speeds from ROS 2, and what follows from
//! both: `gmr node`.
//!
//! Its face: [`node`]. Within it a [`Node`] takes readings of power and messages of wheels, and
//! gives a [`State`] at any time. Readings come from a sensor (`i2c`) or a log ([`power`],
//! [`replay`]); states go to a DDS domain (`ros`) or a terminal.
#![deny(clippy::print_stderr, clippy::print_stdout)]

mod battery;
mod clock;
pub mod command;
#[cfg(target_os = "linux")]
pub mod i2c;
mod live;
mod pipeline;
pub mod power;
pub mod replay;
#[cfg(feature = "ros")]
pub mod ros;
mod run;
mod state;
mod sum;
mod wheels;

pub use live::Node;
pub use pipeline::Pipeline;
pub use power::{PowerSource, Reading};
pub use run::{Request, WheelsFrom, node};
pub use state::{Health, State};
use support::error::Result;
pub use wheels::{Motion, WheelMessage};

/// Where states go.
pub trait Outlet {
    /// Takes one.
    ///
    /// # Errors
    /// It cannot, and never will again: whatever passes is not an error.
    fn publish(&mut self, state: &State) -> Result<()>;

    /// Takes what is wrong elsewhere, for people.
    fn say(&mut self, _: &str) {}

    /// What is wrong where states go, said once.
    fn trouble(&mut self) -> Option<String> {
        None
    }
}

/// Where messages about the wheels come from.
pub trait WheelSource {
    /// Those that came since the last call, in their order.
    fn take(&mut self) -> Vec<WheelMessage>;
}
