//! Driving as the TurtleBot3's stock firmware does: what the ROS node asks for becomes goals of the
//! wheels' servos.
//!
//! ```text
//! link ── pilot: heartbeat, command ── goals: m/s → servo units ── Orders → wheels/motors
//!      └─ battery: percentage, cut-off        heading: quaternion from the wheels
//! ```

mod battery;
mod goals;
mod heading;
mod pilot;

pub use battery::{BatteryGuard, battery_percent};
pub use goals::{Command, GOAL_LIMIT, goals};
pub use heading::Heading;
pub use pilot::{HEARTBEAT_US, Pilot};

use crate::wheels::WHEELS;

/// What the wheels are to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Orders {
    /// Goal velocities, left and right, in the servo's unit of 0.229 rev/min, positive forward.
    pub goals: [i32; WHEELS],
    /// The servos are to hold their torque; without, nothing is asked of them and nothing written
    /// to them.
    pub torque: bool,
    /// Profile accelerations, left and right, in the servo's unit of 214.577 rev/min²; 0: as fast
    /// as they can.
    pub profile: [i32; WHEELS],
}

impl Orders {
    /// None: the wheels are only watched.
    pub const NONE: Self = Self { goals: [0; WHEELS], torque: false, profile: [0; WHEELS] };
}
