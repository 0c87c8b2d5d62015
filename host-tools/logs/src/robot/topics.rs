//! `[topics]` of robot.toml: where bags have what a log needs, if not where most robots have it.

use serde::Deserialize;

use super::signal::{Quantity, Signal, Sum};

/// Messages further apart than this, s, say nothing of the time between them: a battery that
/// reports once a second still does.
const DEFAULT_GREATEST_GAP_S: f64 = 2.0;

/// Where in bags the columns of a log are. What is not given is looked for under the names that
/// TurtleBot3, Clearpath's and Husarion's robots and PX4 use.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Topics {
    /// Speed of each wheel, rad/s, in the order of the log's columns.
    pub wheel_speeds: Vec<Signal>,
    /// A topic of `nav_msgs/Odometry`, where no wheel speeds are: they follow from the kinematics.
    pub odometry: Option<String>,
    /// Power, W, from one source or as a sum; none if empty.
    pub power: Sum,
    /// Voltage, V; with the current it gives power.
    pub voltage: Option<Signal>,
    /// Current, A, positive while discharging. ROS's batteries count the other way: `scale = -1`.
    pub current: Option<Signal>,
    /// A topic of commanded motion, `geometry_msgs/Twist` or `TwistStamped`.
    pub commands: Option<String>,
    /// A topic of `sensor_msgs/Imu`.
    pub imu: Option<String>,
    /// Total mass, kg.
    pub mass: Option<Signal>,
    /// Torque at each wheel, N·m, in the order of the log's columns: efforts of joints, where they
    /// are torques.
    pub torques: Vec<Signal>,
    /// Messages further apart than this, s, say nothing of the time between them.
    pub greatest_gap_s: f64,
    /// Which time counts.
    pub clock: Clock,
}

impl Default for Topics {
    fn default() -> Self {
        Self {
            wheel_speeds: Vec::new(),
            odometry: None,
            power: Sum::default(),
            voltage: None,
            current: None,
            commands: None,
            imu: None,
            mass: None,
            torques: Vec::new(),
            greatest_gap_s: DEFAULT_GREATEST_GAP_S,
            clock: Clock::Stamp,
        }
    }
}

impl Topics {
    /// Units have to be those of what a signal stands for.
    pub(super) fn checked(mut self) -> Result<Self, String> {
        let speeds =
            self.wheel_speeds.into_iter().map(|signal| signal.must_be(Quantity::Speed, "wheel_speeds"));
        self.wheel_speeds = speeds.collect::<Result<_, _>>()?;
        self.voltage = self.voltage.map(|signal| signal.must_be(Quantity::Voltage, "voltage")).transpose()?;
        self.current = self.current.map(|signal| signal.must_be(Quantity::Current, "current")).transpose()?;
        Ok(self)
    }
}

/// Which time of a message counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Clock {
    /// Its header's stamp, where it has one, else its receipt.
    Stamp,
    /// When the recorder received it.
    Receipt,
}
