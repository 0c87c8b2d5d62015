//! The messages, field by field as their definitions have them (common_interfaces): CDR has no
//! names, only an order.

use rustdds::GUID;
use serde::{Deserialize, Serialize};

use crate::{Health, State};

/// `builtin_interfaces/Time`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Time {
    /// s.
    pub(super) sec: i32,
    /// ns.
    pub(super) nanosec: u32,
}

impl Time {
    /// s; none of a sender without a clock.
    pub(super) fn seconds(self) -> Option<f64> {
        (self.sec != 0 || self.nanosec != 0).then(|| f64::from(self.sec) + 1e-9 * f64::from(self.nanosec))
    }
}

/// `std_msgs/Header`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Header {
    pub(super) stamp: Time,
    frame_id: String,
}

impl Header {
    fn of(stamp: Time) -> Self {
        Self { stamp, frame_id: String::new() }
    }
}

/// `std_msgs/Float64`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Float64 {
    pub(super) data: f64,
}

/// `sensor_msgs/JointState`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct JointState {
    pub(super) header: Header,
    pub(super) name: Vec<String>,
    position: Vec<f64>,
    pub(super) velocity: Vec<f64>,
    effort: Vec<f64>,
}

/// Numbers in a row have no length of their own: 36 are six times six.
type Covariance = [[f64; 6]; 6];

/// `nav_msgs/Odometry`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Odometry {
    pub(super) header: Header,
    child_frame_id: String,
    position: [f64; 3],
    orientation: [f64; 4],
    pose_covariance: Covariance,
    linear: [f64; 3],
    angular: [f64; 3],
    twist_covariance: Covariance,
}

impl Odometry {
    /// Forward and to the left, m/s; turn rate, rad/s.
    pub(super) fn planar(&self) -> [f64; 3] {
        [self.linear[0], self.linear[1], self.angular[2]]
    }
}

/// `sensor_msgs/BatteryState`: NaN is what is not known, and a current below 0 discharges.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct BatteryState {
    header: Header,
    voltage: f32,
    temperature: f32,
    current: f32,
    charge: f32,
    capacity: f32,
    design_capacity: f32,
    percentage: f32,
    power_supply_status: u8,
    power_supply_health: u8,
    power_supply_technology: u8,
    present: bool,
    cell_voltage: Vec<f32>,
    cell_temperature: Vec<f32>,
    location: String,
    serial_number: String,
}

/// `POWER_SUPPLY_STATUS_…` of the definition.
const STATUS_UNKNOWN: u8 = 0;
const STATUS_CHARGING: u8 = 1;
const STATUS_DISCHARGING: u8 = 2;

impl BatteryState {
    pub(super) fn of(state: &State, stamp: Time, capacity_ah: Option<f64>, cells: usize) -> Self {
        let number = |value: Option<f64>| value.map_or(f32::NAN, |value| value as f32);
        let status = match state.current_a {
            None => STATUS_UNKNOWN,
            Some(current) if current < 0.0 => STATUS_CHARGING,
            Some(_) => STATUS_DISCHARGING,
        };
        Self {
            header: Header::of(stamp),
            voltage: number(state.voltage_v),
            temperature: f32::NAN,
            current: number(state.current_a.map(|current| -current)),
            charge: number(state.charge.zip(capacity_ah).map(|(share, capacity)| share * capacity)),
            capacity: f32::NAN,
            design_capacity: number(capacity_ah),
            percentage: number(state.charge),
            power_supply_status: status,
            power_supply_health: 0,
            power_supply_technology: 0,
            present: state.voltage_v.is_some(),
            // Measured together only; the definition wants one NaN a cell then.
            cell_voltage: vec![f32::NAN; cells],
            cell_temperature: Vec::new(),
            location: String::new(),
            serial_number: String::new(),
        }
    }
}

/// `rmw_dds_common/Gid`: 16 bytes since ROS 2 Iron, 24 before.
pub(super) type Gid<const LENGTH: usize> = [u8; LENGTH];

/// `rmw_dds_common/NodeEntitiesInfo`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct NodeEntitiesInfo<G> {
    node_namespace: String,
    node_name: String,
    reader_gid_seq: Vec<G>,
    writer_gid_seq: Vec<G>,
}

/// `rmw_dds_common/ParticipantEntitiesInfo`: which nodes a process has, and what is theirs. `ros2
/// node list` shows what it says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct ParticipantEntitiesInfo<G> {
    gid: G,
    node_entities_info_seq: Vec<NodeEntitiesInfo<G>>,
}

impl<const LENGTH: usize> ParticipantEntitiesInfo<Gid<LENGTH>>
where
    Gid<LENGTH>: Serialize,
{
    /// One node with all of it.
    pub(super) fn of(participant: GUID, node: &str, readers: &[GUID], writers: &[GUID]) -> Self {
        let gid = |guid: &GUID| {
            let bytes = guid.to_bytes();
            std::array::from_fn(|place| bytes.get(place).copied().unwrap_or(0))
        };
        let node = NodeEntitiesInfo {
            node_namespace: "/".to_owned(),
            node_name: node.to_owned(),
            reader_gid_seq: readers.iter().map(gid).collect(),
            writer_gid_seq: writers.iter().map(gid).collect(),
        };
        Self { gid: gid(&participant), node_entities_info_seq: vec![node] }
    }
}

/// `diagnostic_msgs/KeyValue`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct KeyValue {
    key: String,
    value: String,
}

/// `diagnostic_msgs/DiagnosticStatus`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct DiagnosticStatus {
    level: u8,
    name: String,
    message: String,
    hardware_id: String,
    values: Vec<KeyValue>,
}

/// `diagnostic_msgs/DiagnosticArray`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct DiagnosticArray {
    header: Header,
    status: Vec<DiagnosticStatus>,
}

impl DiagnosticArray {
    pub(super) fn of(state: &State, stamp: Time, robot: &str) -> Self {
        // OK, WARN, ERROR, STALE of the definition.
        let level = match state.state {
            Health::Ok => 0,
            Health::Unknown => 1,
            Health::NoPower => 2,
            Health::NoSpeeds => 3,
        };
        // The line of --json, a value a key.
        let fields = match serde_json::to_value(state) {
            Ok(serde_json::Value::Object(fields)) => fields,
            _ => serde_json::Map::new(),
        };
        let values = fields.into_iter().map(|(key, value)| KeyValue {
            key,
            value: match value {
                serde_json::Value::Null => "unknown".to_owned(),
                serde_json::Value::String(text) => text,
                other => other.to_string(),
            },
        });
        let status = DiagnosticStatus {
            level,
            name: "gmr: payload".to_owned(),
            message: state.why.clone().unwrap_or_default(),
            hardware_id: robot.to_owned(),
            values: values.collect(),
        };
        Self { header: Header::of(stamp), status: vec![status] }
    }
}
