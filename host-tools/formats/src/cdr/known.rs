//! Definitions of common messages, for what carries none: bags of rosbag2 in SQLite before ROS 2
//! Iron, and messages as they arrive.
//!
//! Fields as in ros2/common_interfaces and ros2/rcl_interfaces (Apache-2.0), and as the makers of
//! motor drivers have them (odriverobotics/ros_odrive, f1tenth/vesc,
//! clearpathrobotics/clearpath_msgs, husarion/husarion_ugv_ros), without their comments.

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
    let kinds = body.lines().filter_map(|line| line.split_whitespace().next());
    kinds.filter(|kind| kind.contains('/')).map(|kind| kind.trim_end_matches("[]")).collect()
}

/// Types that are known, with `msg`.
pub(crate) fn kinds() -> impl Iterator<Item = String> {
    DEFINITIONS.iter().map(|(name, _)| name.replace('/', "/msg/"))
}

const DEFINITIONS: [(&str, &str); 30] = [
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
    ("geometry_msgs/Transform", "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"),
    (
        "geometry_msgs/TransformStamped",
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
    ),
    ("tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"),
    (
        "odrive_can/ODriveStatus",
        "float32 bus_voltage\nfloat32 bus_current\nfloat32 fet_temperature\nfloat32 motor_temperature\n\
         uint32 active_errors\nuint32 disarm_reason\n",
    ),
    (
        "vesc_msgs/VescState",
        "float64 temp_fet\nfloat64 temp_motor\nfloat64 current_motor\nfloat64 current_input\nfloat64 avg_id\n\
         float64 avg_iq\nfloat64 duty_cycle\nfloat64 speed\nfloat64 voltage_input\nfloat64 charge_drawn\n\
         float64 charge_regen\nfloat64 energy_drawn\nfloat64 energy_regen\nint32 displacement\n\
         int32 distance_traveled\nint32 fault_code\nfloat64 pid_pos_now\nint32 controller_id\n\
         float64 ntc_temp_mos1\nfloat64 ntc_temp_mos2\nfloat64 ntc_temp_mos3\nfloat64 avg_vd\nfloat64 avg_vq\n",
    ),
    ("vesc_msgs/VescStateStamped", "std_msgs/Header header\nvesc_msgs/VescState state\n"),
    (
        "clearpath_platform_msgs/Power",
        "std_msgs/Header header\nint8 shore_power_connected\nint8 battery_connected\nint8 power_12v_user_nominal\n\
         int8 charger_connected\nint8 charging_complete\nfloat32[] measured_voltages\nfloat32[] measured_currents\n",
    ),
    (
        "clearpath_motor_msgs/LynxFeedback",
        "uint8 can_id\nstring joint_name\nfloat32 current\nfloat32 voltage\nfloat32 velocity\nfloat32 travel\n",
    ),
    (
        "clearpath_motor_msgs/LynxMultiFeedback",
        "std_msgs/Header header\nclearpath_motor_msgs/LynxFeedback[] drivers\n",
    ),
    (
        "husarion_ugv_msgs/RobotDriverState",
        "std_msgs/Header header\nhusarion_ugv_msgs/DriverStateNamed[] driver_states\nbool error\n\
         bool write_pdo_cmds_error\nbool read_pdo_motor_states_error\nbool read_pdo_driver_state_error\n",
    ),
    ("husarion_ugv_msgs/DriverStateNamed", "string name\nhusarion_ugv_msgs/DriverState state\n"),
    (
        "husarion_ugv_msgs/DriverState",
        "float32 voltage\nfloat32 current\nfloat32 temperature\nfloat32 heatsink_temperature\n\
         bool motor_states_data_timed_out\nbool driver_state_data_timed_out\nbool can_error\nbool heartbeat_timeout\n",
    ),
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
