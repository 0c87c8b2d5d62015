//! Faults of the virtual robot at their times, from a file.
//!
//! ```toml
//! [[fault]]
//! at_s = 10.0            # board time
//! for_s = 2.0            # lasting ones only
//! what = "servo-dead"
//! which = "left"         # of a servo: left, right; of a sensor: battery, motors, computer, lidar
//! ```

use std::path::Path;
use std::time::Duration;

use plant::rails::RAILS;
use serde::Deserialize;
use support::error::{Error, Result};

use super::robot::VirtualRobot;
use super::servo::{OVERLOAD, VirtualServo};

/// Longest time in a script, s: a year.
const LONGEST_S: f64 = 3.2e7;

/// What can happen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum What {
    /// A line of the sensors' bus is held low: lasts.
    BusStuck,
    /// A sensor does not answer: lasts.
    SensorAbsent,
    /// A sensor's supply breaks down for a moment.
    SensorBrownOut,
    /// A sensor does not acknowledge, this number of times.
    SensorSilent,
    /// A servo is off the bus: lasts.
    ServoDead,
    /// So many answers of a servo get lost.
    ServoDrop,
    /// A bit flips in this number of answers of a servo.
    ServoCorrupt,
    /// A servo shuts down for overload.
    ServoOverload,
    /// A servo restarts.
    ServoRestart,
}

impl What {
    const fn lasts(self) -> bool {
        matches!(self, Self::BusStuck | Self::SensorAbsent | Self::ServoDead)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Which {
    Left,
    Right,
    Battery,
    Motors,
    Computer,
    Lidar,
}

/// As the file has it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    at_s: f64,
    for_s: Option<f64>,
    what: What,
    which: Option<Which>,
    count: Option<u32>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    #[serde(default)]
    fault: Vec<Written>,
}

/// A change of the robot at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Change {
    at: Duration,
    what: What,
    place: usize,
    /// For how many answers.
    count: u32,
    /// A lasting fault begins, or ends.
    begins: bool,
}

/// What is to happen, in its order.
#[derive(Debug, Default, Clone, PartialEq)]
pub struct FaultScript {
    changes: Vec<Change>,
    done: usize,
}

impl FaultScript {
    /// Reads a script.
    ///
    /// # Errors
    /// The file cannot be read, or a fault is none.
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(|error| Error::io(path, &error))?;
        Self::parse(&text).map_err(|error| error.in_file(path))
    }

    fn parse(text: &str) -> Result<Self> {
        let document: Document = toml::from_str(text).map_err(|error| Error::failed(error.to_string()))?;
        let mut changes = Vec::new();
        for (index, written) in document.fault.iter().enumerate() {
            let refuse = |why: &str| Error::failed(format!("fault {}: {why}", index + 1));
            let time = |seconds: f64| {
                let is_time = (0.0..=LONGEST_S).contains(&seconds);
                is_time
                    .then(|| Duration::from_secs_f64(seconds))
                    .ok_or_else(|| refuse("a time that is none; expected s, from 0 on"))
            };
            let place = place(written.what, written.which).map_err(refuse)?;
            if written.what.lasts() != written.for_s.is_some() {
                return Err(refuse("`for_s` belongs to what lasts: bus-stuck, sensor-absent, servo-dead"));
            }
            let at = time(written.at_s)?;
            let change = |at, begins| Change {
                at,
                what: written.what,
                place,
                count: written.count.unwrap_or(1),
                begins,
            };
            changes.push(change(at, true));
            if let Some(length) = written.for_s {
                changes.push(change(at + time(length)?, false));
            }
        }
        changes.sort_by_key(|change| change.at);
        Ok(Self { changes, done: 0 })
    }

    /// Does to the robot what is due at a board time.
    pub fn apply(&mut self, now: Duration, robot: &mut VirtualRobot) {
        while let Some(change) = self.changes.get(self.done).filter(|change| change.at <= now) {
            change.apply(robot);
            self.done += 1;
        }
    }
}

/// Which servo or sensor, by its number.
fn place(what: What, which: Option<Which>) -> std::result::Result<usize, &'static str> {
    let is_servo = matches!(
        what,
        What::ServoDead | What::ServoDrop | What::ServoCorrupt | What::ServoOverload | What::ServoRestart
    );
    match (what, which) {
        (What::BusStuck, None) => Ok(0),
        (What::BusStuck, Some(_)) => Err("the bus has no `which`"),
        (_, Some(Which::Left)) if is_servo => Ok(0),
        (_, Some(Which::Right)) if is_servo => Ok(1),
        (_, _) if is_servo => Err("expected `which`: left or right"),
        (_, Some(Which::Battery)) => Ok(0),
        (_, Some(Which::Motors)) => Ok(1),
        (_, Some(Which::Computer)) => Ok(2),
        (_, Some(Which::Lidar)) => Ok(RAILS - 1),
        (_, _) => Err("expected `which`: battery, motors, computer or lidar"),
    }
}

impl Change {
    fn apply(&self, robot: &mut VirtualRobot) {
        match self.what {
            What::BusStuck => robot.is_bus_stuck = self.begins,
            What::SensorAbsent | What::SensorBrownOut | What::SensorSilent => {
                let Some(sensor) = robot.sensors.get_mut(self.place) else { return };
                match self.what {
                    What::SensorAbsent => sensor.absent = self.begins,
                    What::SensorBrownOut => sensor.brown_out(),
                    _ => sensor.nack_next = self.count,
                }
            }
            _ => {
                let Some(servo) = robot.servo_bus.servos.get_mut(self.place) else { return };
                self.apply_to(servo);
            }
        }
    }

    fn apply_to(&self, servo: &mut VirtualServo) {
        match self.what {
            What::ServoDead => servo.dead = self.begins,
            What::ServoDrop => servo.drop_next = self.count,
            What::ServoCorrupt => servo.corrupt_next = self.count,
            What::ServoOverload => servo.fail(OVERLOAD),
            _ => servo.reboot(),
        }
    }
}

#[cfg(test)]
mod tests {
    use plant::{Kinematics, PlantSet, ProfileKind, Scenario};

    use super::*;
    use crate::robot::RobotOptions;

    fn robot() -> VirtualRobot {
        let scenario =
            Scenario::new(PlantSet::Servo, Kinematics::Differential, ProfileKind::Standstill, 10.0, 1);
        VirtualRobot::new(scenario, RobotOptions::default()).unwrap()
    }

    #[test]
    fn faults_come_and_go_at_their_times() {
        let text = "[[fault]]\nat_s = 2\nfor_s = 1.5\nwhat = \"servo-dead\"\nwhich = \"right\"\n\
                    [[fault]]\nat_s = 1\nwhat = \"sensor-silent\"\nwhich = \"lidar\"\ncount = 7\n";
        let mut script = FaultScript::parse(text).unwrap();
        let mut robot = robot();
        let mut at = |seconds: f64| {
            script.apply(Duration::from_secs_f64(seconds), &mut robot);
            (robot.sensors[3].nack_next, robot.servo_bus.servos[1].dead, robot.servo_bus.servos[0].dead)
        };
        assert_eq!(at(0.5), (0, false, false));
        assert_eq!(at(1.0), (7, false, false));
        assert_eq!(at(3.4), (7, true, false));
        assert_eq!(at(3.5), (7, false, false));
    }

    #[test]
    fn what_is_no_fault_is_refused_in_words() {
        for (text, said) in [
            ("at_s = 1\nwhat = \"servo-dead\"\nwhich = \"left\"", "for_s"),
            ("at_s = 1\nfor_s = 1\nwhat = \"servo-restart\"\nwhich = \"left\"", "for_s"),
            ("at_s = 1\nwhat = \"servo-drop\"", "left or right"),
            ("at_s = 1\nwhat = \"sensor-brown-out\"\nwhich = \"left\"", "battery"),
            ("at_s = nan\nwhat = \"sensor-brown-out\"\nwhich = \"motors\"", "a time"),
            ("at_s = 1\nwhat = \"explosion\"", "explosion"),
        ] {
            let error = FaultScript::parse(&format!("[[fault]]\n{text}\n")).unwrap_err().to_string();
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
