//! The controller board as the host sees it. Any board: the virtual one is a crate of its own,
//! `virtual-board`.
//!
//! Its face: [`recorder`], [`flasher`] and [`client`] below both; [`live_view`], [`probe`],
//! [`dfu`]; [`signing`].
#![deny(clippy::print_stderr, clippy::print_stdout)]

pub mod client;
pub mod dfu;
pub mod flasher;
pub mod image_file;
mod lines;
pub mod live_view;
pub mod mcap_lines;
pub mod probe;
pub mod recorder;
pub mod serial;
pub mod signing;
pub mod status;
pub mod store_image;
pub mod store_task;
pub mod transport;

use firmware::power_sensors::{Health, RAIL_COUNT, RAILS, RailName};

/// Names of the rails, in the board's order: as columns and options have them.
pub fn rail_names() -> [&'static str; RAIL_COUNT] {
    RAILS.map(|rail| match rail.name {
        RailName::Battery => "battery",
        RailName::Motors => "motors",
        RailName::Computer => "computer",
        RailName::Lidar => "lidar",
    })
}

/// Position of the motors among the rails.
pub fn motors_rail() -> Option<usize> {
    RAILS.iter().position(|rail| rail.name == RailName::Motors)
}

/// A sensor's health in words.
pub fn health_text(health: Health) -> &'static str {
    match health {
        Health::Ok => "ok",
        Health::Stale => "stale",
        Health::Overflow => "overflow",
        Health::Absent => "absent",
        Health::LostCalibration => "lost calibration",
        Health::Implausible => "implausible",
    }
}
