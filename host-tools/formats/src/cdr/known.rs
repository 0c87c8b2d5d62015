//! Definitions of common messages, for bags that carry none: those of rosbag2 in SQLite before ROS
//! 2 Iron.
//!
//! Fields as in ros2/common_interfaces and ros2/rcl_interfaces (Apache-2.0), without their
//! comments.

/// The definition of this type, with those that it needs behind it, as a bag would carry it.
pub(crate) fn definition(kind: &str) -> Option<String> {
    let (name, body) = lookup(kind)?;
    let mut text = body.to_owned();
    let mut written = vec![name];
    let mut at = 0;
    let mut waiting = needs(body);
    while at < waiting.len() {
        let needed = waiting[at];
        at += 1;
        let Some((name, body)) = lookup(needed).filter(|(name, _)| !written.contains(name)) else { continue };
        written.push(name);
        text += &format!("================\nMSG: {name}\n{body}");
        waiting.extend(needs(body));
    }
    Some(text)
}

fn lookup(kind: &str) -> Option<(&'static str, &'static str)> {
    let kind = kind.replace("/msg/", "/");
    DEFINITIONS.iter().find(|(name, _)| *name == kind).copied()
}

/// Types of other messages.
fn needs(body: &str) -> Vec<&str> {
    body.lines().filter_map(|line| line.split_whitespace().next()).filter(|kind| kind.contains('/')).collect()
}

const DEFINITIONS: [(&str, &str); 18] = [
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"),
    ("std_msgs/Float32", "float32 data\n"),
    ("std_msgs/Float64", "float64 data\n"),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"),
    ("geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"),
    ("geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n"),
    ("geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"),
    ("geometry_msgs/TwistStamped", "std_msgs/Header header\ngeometry_msgs/Twist twist\n"),
    ("geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist\nfloat64[36] covariance\n"),
    (
        "nav_msgs/Odometry",
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n\
         geometry_msgs/TwistWithCovariance twist\n",
    ),
    (
        "sensor_msgs/JointState",
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n",
    ),
    (
        "sensor_msgs/BatteryState",
        "std_msgs/Header header\nfloat32 voltage\nfloat32 temperature\nfloat32 current\nfloat32 charge\n\
         float32 capacity\nfloat32 design_capacity\nfloat32 percentage\nuint8 power_supply_status\n\
         uint8 power_supply_health\nuint8 power_supply_technology\nbool present\nfloat32[] cell_voltage\n\
         float32[] cell_temperature\nstring location\nstring serial_number\n",
    ),
    (
        "sensor_msgs/Imu",
        "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n\
         geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n\
         geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n",
    ),
    (
        "sensor_msgs/MagneticField",
        "std_msgs/Header header\ngeometry_msgs/Vector3 magnetic_field\nfloat64[9] magnetic_field_covariance\n",
    ),
    ("sensor_msgs/Temperature", "std_msgs/Header header\nfloat64 temperature\nfloat64 variance\n"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cdr::{Layout, Serialization};

    #[test]
    fn each_stands_for_itself() {
        for (name, _) in DEFINITIONS {
            let kind = name.replace('/', "/msg/");
            let layout = Layout::of(&kind, &definition(&kind).unwrap(), Serialization::Cdr).unwrap();
            assert!(!layout.paths().is_empty(), "{name}");
        }
        assert!(definition("p/msg/Other").is_none());
    }
}
