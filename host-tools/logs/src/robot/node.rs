//! `[node]` of robot.toml: the sensor on the robot's own computer, and what `gmr node` calls its
//! topics.

use serde::Deserialize;

/// Which chip measures power.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lower")]
pub enum PowerChip {
    /// 26 V, ±320 mV across a shunt
    Ina219,
    /// 36 V, ±81.92 mV across a shunt
    Ina226,
    /// 36 V, ±15 A through its own shunt
    Ina260,
    /// No chip: the power that `[topics]` of robot.toml names, from the motor drivers' own messages
    Topics,
}

/// What `gmr node` reads and says, and where. What is not given is as here.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NodeSettings {
    /// The chip in the wire.
    pub sensor: PowerChip,
    /// The computer's I²C bus.
    pub bus: String,
    /// The chip's address, as its pads say.
    pub address: u8,
    /// Its resistor, Ω; an INA260 has its own.
    pub shunt_ohm: f64,
    /// Topic of `sensor_msgs/JointState`.
    pub joint_states: String,
    /// Names of the wheels' joints, as the columns of a log; those that TurtleBot3, Clearpath's and
    /// Husarion's robots use unless given.
    pub joints: Vec<String>,
    /// A topic of `nav_msgs/Odometry`, read instead of joints.
    pub odometry: Option<String>,
    /// Speeds and power older than this, s, are not used.
    pub greatest_gap_s: f64,
    /// `sensor_msgs/BatteryState`.
    pub battery_state: String,
    /// `std_msgs/Float64`, kg: total mass less the mass without payload; the next two are the ends
    /// of its 95 % interval.
    pub payload: String,
    /// kg.
    pub payload_low: String,
    /// kg.
    pub payload_high: String,
    /// `std_msgs/Float64`, W: what the drives draw, after the filter.
    pub measured_power: String,
    /// W: the same by the model.
    pub predicted_power: String,
    /// `std_msgs/Float64`, J: what the battery still gives at the present load.
    pub remaining_energy: String,
    /// s: how long that lasts.
    pub remaining_time: String,
    /// `diagnostic_msgs/DiagnosticArray`: all that in one message, and what is wrong.
    pub diagnostics: String,
}

impl Default for NodeSettings {
    fn default() -> Self {
        let topic = str::to_owned;
        Self {
            sensor: PowerChip::Ina219,
            bus: "/dev/i2c-1".to_owned(),
            address: 0x40,
            shunt_ohm: 0.1,
            joint_states: topic("/joint_states"),
            joints: Vec::new(),
            odometry: None,
            greatest_gap_s: 1.0,
            battery_state: topic("/battery_state"),
            payload: topic("/payload"),
            payload_low: topic("/payload/low"),
            payload_high: topic("/payload/high"),
            measured_power: topic("/power/measured"),
            predicted_power: topic("/power/predicted"),
            remaining_energy: topic("/remaining/energy"),
            remaining_time: topic("/remaining/time"),
            diagnostics: topic("/diagnostics"),
        }
    }
}

impl NodeSettings {
    /// Every topic, by its key.
    pub fn topics(&self) -> [(&'static str, &str); 11] {
        [
            ("joint_states", &self.joint_states),
            ("odometry", self.odometry.as_deref().unwrap_or("/odom")),
            ("battery_state", &self.battery_state),
            ("payload", &self.payload),
            ("payload_low", &self.payload_low),
            ("payload_high", &self.payload_high),
            ("measured_power", &self.measured_power),
            ("predicted_power", &self.predicted_power),
            ("remaining_energy", &self.remaining_energy),
            ("remaining_time", &self.remaining_time),
            ("diagnostics", &self.diagnostics),
        ]
    }

    /// What is wrong with it, for a robot of so many wheels, in words with what is allowed.
    pub(super) fn wrong(&self, wheels: usize) -> Option<String> {
        let is_name = |segment: &str| {
            segment.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_')
                && segment.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        };
        let is_topic = |name: &str| name.strip_prefix('/').is_some_and(|name| name.split('/').all(is_name));
        if let Some((key, name)) = self.topics().into_iter().find(|(_, name)| !is_topic(name)) {
            return Some(format!("{key} = \"{name}\"; expected an absolute topic, as /{key}"));
        }
        let topics = self.topics();
        for (place, (key, name)) in topics.iter().enumerate() {
            if let Some((other, _)) = topics[..place].iter().find(|(_, other)| other == name) {
                return Some(format!("{key} and {other} are both {name}; expected two topics"));
            }
        }
        if !(self.shunt_ohm > 0.0 && self.shunt_ohm <= 1.0) {
            return Some(format!("shunt_ohm = {}; expected above 0 and at most 1", self.shunt_ohm));
        }
        if !(0x40..=0x4F).contains(&self.address) {
            return Some(format!("address = {:#04x}; expected 0x40 to 0x4f", self.address));
        }
        if !(0.1..=3600.0).contains(&self.greatest_gap_s) {
            return Some(format!("greatest_gap_s = {}; expected 0.1 to 3600", self.greatest_gap_s));
        }
        let joints = self.joints.len();
        (joints != 0 && joints != wheels)
            .then(|| format!("{joints} joints; expected {wheels}, one a wheel of the log"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wrong(change: impl FnOnce(&mut NodeSettings)) -> Option<String> {
        let mut settings = NodeSettings::default();
        change(&mut settings);
        settings.wrong(2)
    }

    #[test]
    fn only_what_can_be_is_taken() {
        assert_eq!(wrong(|_| {}), None);
        assert_eq!(wrong(|node| node.payload = "/r1/load_kg".into()), None);
        let names_it = |change: fn(&mut NodeSettings), what: &str| {
            let said = wrong(change).unwrap_or_default();
            assert!(said.contains(what) && said.contains("expected"), "{what}: {said}");
        };
        names_it(|node| node.payload = "payload".into(), "absolute topic");
        names_it(|node| node.payload = "/pay load".into(), "absolute topic");
        names_it(|node| node.payload = "/battery_state".into(), "payload and battery_state");
        names_it(|node| node.shunt_ohm = 0.0, "shunt_ohm");
        names_it(|node| node.address = 0x20, "0x20");
        names_it(|node| node.greatest_gap_s = f64::NAN, "greatest_gap_s");
        names_it(|node| node.joints = vec!["left".into()], "1 joints");
    }
}
