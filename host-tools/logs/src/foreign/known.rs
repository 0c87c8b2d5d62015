//! What robots call their topics and joints, where robot.toml does not say it.
//!
//! From the documentation of the robots: TurtleBot3 (turtlebot3_node), Clearpath
//! (docs.clearpathrobotics.com, platform API), Husarion (husarion.com/manuals, ROS 2 API), and
//! PX4's message definitions. A name counts under any namespace.

use log_formats::Topic;

/// Joints of the wheels, left before right and front before rear, as the columns of a log.
const PAIRS: [[&str; 2]; 3] = [
    ["wheel_left_joint", "wheel_right_joint"],
    ["left_wheel_joint", "right_wheel_joint"],
    ["drivewhl_l_joint", "drivewhl_r_joint"],
];
/// The same of four wheels.
const FOURS: [[&str; 4]; 3] = [
    ["front_left_wheel_joint", "front_right_wheel_joint", "rear_left_wheel_joint", "rear_right_wheel_joint"],
    ["fl_wheel_joint", "fr_wheel_joint", "rl_wheel_joint", "rr_wheel_joint"],
    ["front_left_wheel", "front_right_wheel", "rear_left_wheel", "rear_right_wheel"],
];

/// Sets of joints that may be the wheels of a robot with so many columns: for each column the
/// joints whose mean it is. Four wheels of a robot with a column a side are averaged.
pub fn wheel_joints(columns: usize) -> Vec<Vec<Vec<&'static str>>> {
    let pairs = PAIRS.iter().map(|set| set.iter().map(|joint| vec![*joint]).collect());
    let sides = FOURS.iter().map(|[fl, fr, rl, rr]| vec![vec![*fl, *rl], vec![*fr, *rr]]);
    match columns {
        2 => pairs.chain(sides).collect(),
        4 => FOURS.iter().map(|set| set.iter().map(|joint| vec![*joint]).collect()).collect(),
        _ => Vec::new(),
    }
}

/// Odometry of wheels; filtered ones, with other sensors in them, come last.
pub(super) const ODOMETRY: [&str; 4] = ["platform/odom", "odom", "odometry/wheels", "odometry"];
pub(super) const COMMANDS: [&str; 3] = ["platform/cmd_vel", "platform/cmd_vel_unstamped", "cmd_vel"];
pub(super) const BATTERIES: [&str; 5] =
    ["platform/bms/state", "battery/battery_status", "battery_state", "battery_status", "battery"];
pub(super) const POWERS: [&str; 3] = ["motor_power", "power_w", "power"];
pub(super) const MASSES: [&str; 2] = ["total_mass", "mass_kg"];

pub(super) const JOINT_STATE: &[&str] = &["sensor_msgs/msg/JointState"];
pub(super) const ODOMETRY_KIND: &[&str] = &["nav_msgs/msg/Odometry"];
pub(super) const BATTERY_STATE: &[&str] = &["sensor_msgs/msg/BatteryState"];
pub(super) const IMU: &[&str] = &["sensor_msgs/msg/Imu"];
pub(super) const TRANSFORMS: &[&str] = &["tf2_msgs/msg/TFMessage"];
pub(super) const TWISTS: &[&str] = &["geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"];
pub(super) const FLOATS: &[&str] = &["std_msgs/msg/Float64", "std_msgs/msg/Float32"];

/// Frames that stay level, and those of a robot's body (REP 105), under any prefix.
const LEVEL: [&str; 3] = ["odom", "map", "world"];
const BODIES: [&str; 2] = ["base_link", "base_footprint"];

/// Whether a transform, `odom>base_link`, tells how a robot's body is tilted.
pub(super) fn is_tilt(transform: &str) -> bool {
    let is_one = |frame: &str, of: &[&str]| of.contains(&frame.rsplit('/').next().unwrap_or(frame));
    transform.split_once('>').is_some_and(|(from, to)| is_one(from, &LEVEL) && is_one(to, &BODIES))
}

/// Whether a topic is of one of these types, however they are written.
pub(super) fn is_of(topic: &Topic, kinds: &[&str]) -> bool {
    kinds.iter().any(|kind| topic.kind == *kind || topic.kind == kind.replace("/msg/", "/"))
}

/// Whether a topic has this name, under whatever namespace.
pub(super) fn is_called(topic: &Topic, name: &str) -> bool {
    let whole = topic.name.as_str();
    whole == name || whole.strip_suffix(name).is_some_and(|before| before.ends_with('/'))
}

/// The topic of one of these types with the first of these names; several with that name are none,
/// and said.
///
/// # Errors
/// Gives the names of those among which nobody can choose.
pub(super) fn find<'a>(
    topics: &'a [Topic],
    kinds: &[&str],
    names: &[&str],
) -> Result<Option<&'a Topic>, Vec<&'a str>> {
    for name in names {
        let called: Vec<&Topic> =
            topics.iter().filter(|topic| is_of(topic, kinds) && is_called(topic, name)).collect();
        match called[..] {
            [] => {}
            [only] => return Ok(Some(only)),
            _ => return Err(called.iter().map(|topic| topic.name.as_str()).collect()),
        }
    }
    Ok(None)
}
