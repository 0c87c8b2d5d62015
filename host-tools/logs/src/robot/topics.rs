//! `[topics]` of robot.toml: where bags have what a log needs, if not where most robots have it.

use std::fmt;

use serde::Deserialize;

/// Messages further apart than this, s, say nothing of the time between them: a battery that reports once a second still does.
const DEFAULT_GREATEST_GAP_S: f64 = 2.0;

/// Where in bags the columns of a log are. What is not given is looked for under the names that TurtleBot3, Clearpath's and Husarion's
/// robots and PX4 use.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Topics {
    /// Speed of each wheel, rad/s, in the order of the log's columns.
    pub wheel_speeds: Vec<Signal>,
    /// A topic of `nav_msgs/Odometry`, where no wheel speeds are: they follow from the kinematics.
    pub odometry: Option<String>,
    /// Power, W.
    pub power: Option<Signal>,
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
            power: None,
            voltage: None,
            current: None,
            commands: None,
            imu: None,
            mass: None,
            greatest_gap_s: DEFAULT_GREATEST_GAP_S,
            clock: Clock::Stamp,
        }
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

/// A number in the messages of a topic: `"/power:data"`, or with a factor `{ field = "/power:data", scale = 1e-3 }`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(from = "Written")]
pub struct Signal {
    /// `topic:field`.
    pub field: String,
    /// What the number is multiplied by.
    pub scale: f64,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Written {
    Field(String),
    Scaled { field: String, scale: f64 },
}

impl From<Written> for Signal {
    fn from(written: Written) -> Self {
        match written {
            Written::Field(field) => Self { field, scale: 1.0 },
            Written::Scaled { field, scale } => Self { field, scale },
        }
    }
}

impl fmt::Display for Signal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.scale == 1.0 {
            f.write_str(&self.field)
        } else {
            write!(f, "{} × {}", self.field, self.scale)
        }
    }
}
