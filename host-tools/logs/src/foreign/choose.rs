//! Which fields of a bag become which columns.

use log_formats::merge::{Clock, Request, find_topic};
use log_formats::{Bag, Field, Topic};
use support::error::{Error, Result};

use super::columns::{Column, Expression};
use super::known::{
    BATTERIES, BATTERY_STATE, COMMANDS, FLOATS, IMU, JOINT_STATE, MASSES, ODOMETRY, ODOMETRY_KIND, POWERS,
    TWISTS, find, is_called, is_of, wheel_joints,
};
use super::wrong::wrong;
use crate::robot::{self, Robot, Signal, Topics};
use crate::{MASS, POWER, YAW_RATE, speed_column};

/// What is read of a bag, and which columns are made of it.
#[derive(Debug, Clone)]
pub struct Chosen {
    /// What is merged.
    pub request: Request,
    /// Columns behind that of time.
    pub columns: Vec<Column>,
    /// The topic whose current is to be negative while discharging, as ROS has it, if power comes from one.
    pub battery: Option<String>,
    /// What a log should have and this bag does not, in words.
    pub lacking: Vec<String>,
}

/// Fields of a bag: those of its base topic first.
#[derive(Default)]
pub(super) struct Fields {
    pub(super) base: Vec<Field>,
    pub(super) others: Vec<Field>,
}

impl Fields {
    /// The place of a field in a row; fields of a bag without wheels are on the clock of the first.
    pub(super) fn place(&mut self, field: Field) -> usize {
        if self.base.is_empty() || (self.others.is_empty() && self.base[0].topic == field.topic) {
            self.base.push(field);
            return self.base.len() - 1;
        }
        self.others.push(field);
        self.base.len() + self.others.len() - 1
    }
}

/// Chooses as robot.toml says, and where it does not, by what robots call their topics.
///
/// # Errors
/// A topic or field of robot.toml that the bag does not have; several topics of one name; neither wheel speeds nor power.
pub fn choose(bag: &Bag, robot: &Robot) -> Result<Chosen> {
    let topics = robot.topics();
    let mut fields = Fields::default();
    let mut columns = Vec::new();
    let mut lacking = Vec::new();
    match wheels(bag, robot, &mut fields)? {
        Some(found) => columns.extend(found),
        None => {
            lacking.push("wheel speeds (JointState with known joints, Odometry, wheel_encoders)".to_owned())
        }
    }
    let mut battery = None;
    match power(bag, topics)? {
        Some(Power::Direct(field, scale)) => {
            let source = field.to_string();
            let place = fields.place(field);
            columns.push(column(POWER, Expression::Number(place, scale), source));
        }
        Some(Power::Product { voltage, current, scale, is_battery_state }) => {
            let source = format!("{voltage} times {}{current}", if scale < 0.0 { "−" } else { "" });
            battery = is_battery_state.then(|| current.topic.clone());
            let (voltage, current) = (fields.place(voltage), fields.place(current));
            columns.push(column(POWER, Expression::Product(voltage, current, scale), source));
        }
        None => {
            lacking.push("power (a Float topic called power, a BatteryState with its current)".to_owned())
        }
    }
    if fields.base.is_empty() {
        let has = bag.topics().iter().map(|topic| format!("{} ({})", topic.name, topic.kind)).take(20);
        return Err(Error::failed(format!(
            "has neither {}; name them in [topics] of robot.toml. It has: {}",
            lacking.join(" nor "),
            has.collect::<Vec<_>>().join(", ")
        )));
    }
    columns.extend(mass(bag, topics, &mut fields)?);
    columns.extend(commands(bag, robot, &mut fields)?);
    columns.extend(imu(bag, topics, &mut fields)?);
    let clock = match topics.clock {
        robot::Clock::Stamp => Clock::Stamp,
        robot::Clock::Receipt => Clock::Receipt,
    };
    let Fields { base, others } = fields;
    let request = Request { base, others, greatest_gap_s: topics.greatest_gap_s, clock };
    Ok(Chosen { request, columns, battery, lacking })
}

pub(super) fn column(name: impl Into<String>, expression: Expression, source: impl Into<String>) -> Column {
    Column { name: name.into(), expression, source: source.into() }
}

pub(super) fn field(topic: &Topic, path: &str) -> Result<Field> {
    Field::new(&topic.name, path).map_err(wrong)
}

fn parsed(signal: &Signal) -> Result<Field> {
    let field = Field::parse(&signal.field).map_err(wrong);
    field.map_err(|error| Error::failed(format!("[topics] of robot.toml: {}", error.message())))
}

/// The topic that robot.toml names, or one of these types with the first of these names.
pub(super) fn topic<'a>(
    bag: &'a Bag,
    named: Option<&String>,
    kinds: &[&str],
    names: &[&str],
    key: &str,
) -> Result<Option<&'a Topic>> {
    if let Some(name) = named {
        return find_topic(bag, name)
            .map(|place| Some(&bag.topics()[place]))
            .map_err(|error| Error::failed(format!("{error} ({key} in [topics] of robot.toml)")));
    }
    find(bag.topics(), kinds, names).map_err(|several| {
        let several = several.join(", ");
        Error::failed(format!(
            "has several topics for {key}: {several}; expected one named as {key} in [topics] of robot.toml"
        ))
    })
}

/// Wheel speeds: as robot.toml says, of known joints, of PX4's encoders, or of odometry.
fn wheels(bag: &Bag, robot: &Robot, fields: &mut Fields) -> Result<Option<Vec<Column>>> {
    let (topics, count) = (robot.topics(), robot.wheels());
    let given = &topics.wheel_speeds;
    if !given.is_empty() {
        if given.len() != count {
            let message =
                format!("[topics] names {} wheel_speeds; expected {count}, one a wheel", given.len());
            return Err(Error::failed(message));
        }
        let columns = given.iter().enumerate().map(|(wheel, signal)| {
            let place = fields.place(parsed(signal)?);
            Ok(column(speed_column(wheel), Expression::Number(place, signal.scale), signal.to_string()))
        });
        return columns.collect::<Result<Vec<_>>>().map(Some);
    }
    if topics.odometry.is_none() {
        if let Some(columns) = joints(bag, count, fields)? {
            return Ok(Some(columns));
        }
        let encoders =
            bag.topics().iter().find(|topic| topic.kind == "wheel_encoders").filter(|_| count == 2);
        if let Some(topic) = encoders {
            // PX4's drivers publish the right wheel first.
            let columns = [1, 0].into_iter().enumerate().map(|(wheel, index)| {
                let field = field(topic, &format!("wheel_speed[{index}]"))?;
                let source = field.to_string();
                Ok(column(speed_column(wheel), Expression::Number(fields.place(field), 1.0), source))
            });
            return columns.collect::<Result<Vec<_>>>().map(Some);
        }
    }
    let Some(topic) = topic(bag, topics.odometry.as_ref(), ODOMETRY_KIND, &ODOMETRY, "odometry")? else {
        return Ok(None);
    };
    let mut places = Vec::new();
    for member in ["linear.x", "linear.y", "angular.z"] {
        places.push(fields.place(field(topic, &format!("twist.twist.{member}"))?));
    }
    let source = format!("{} by the kinematics", topic.name);
    let inverse = robot.wheel_speeds_of_motion();
    let columns = inverse.row_iter().enumerate().map(|(wheel, factors)| {
        let terms = places.iter().copied().zip(factors.iter().copied()).collect();
        column(speed_column(wheel), Expression::Sum(terms), source.clone())
    });
    Ok(Some(columns.collect()))
}

/// Wheel speeds from the first topic of joints that has all of a known set; four wheels of a robot with a column a side are averaged.
pub(super) fn joints(bag: &Bag, count: usize, fields: &mut Fields) -> Result<Option<Vec<Column>>> {
    let is_joints = |place: &usize| is_of(&bag.topics()[*place], JOINT_STATE);
    let mut places: Vec<usize> = (0..bag.topics().len()).filter(is_joints).collect();
    // A platform's own before one that joins it with an arm's.
    places.sort_by_key(|&place| !is_called(&bag.topics()[place], "platform/joint_states"));
    for place in places {
        let topic = &bag.topics()[place];
        let names = bag.names(place).map_err(wrong)?;
        let is_there = |joint: &&str| names.iter().any(|name| name == joint);
        let has_all = |set: &Vec<Vec<&str>>| set.iter().flatten().all(is_there);
        let Some(wheels) = wheel_joints(count).into_iter().find(has_all) else { continue };
        let columns = wheels.iter().enumerate().map(|(wheel, joints)| {
            let mut own = Vec::new();
            for joint in joints {
                own.push(fields.place(field(topic, &format!("velocity[{joint}]"))?));
            }
            let expression =
                if own.len() == 1 { Expression::Number(own[0], 1.0) } else { Expression::Mean(own) };
            Ok(column(
                speed_column(wheel),
                expression,
                format!("{}:velocity of {}", topic.name, joints.join(" and ")),
            ))
        });
        return columns.collect::<Result<Vec<_>>>().map(Some);
    }
    Ok(None)
}

pub(super) enum Power {
    Direct(Field, f64),
    Product { voltage: Field, current: Field, scale: f64, is_battery_state: bool },
}

pub(super) fn power(bag: &Bag, topics: &Topics) -> Result<Option<Power>> {
    if let Some(signal) = &topics.power {
        return Ok(Some(Power::Direct(parsed(signal)?, signal.scale)));
    }
    match (&topics.voltage, &topics.current) {
        (Some(voltage), Some(current)) => {
            let scale = voltage.scale * current.scale;
            let (voltage, current) = (parsed(voltage)?, parsed(current)?);
            return Ok(Some(Power::Product { voltage, current, scale, is_battery_state: false }));
        }
        (None, None) => {}
        _ => {
            let message = "[topics] of robot.toml names one of voltage and current; expected both, or power";
            return Err(Error::failed(message));
        }
    }
    if let Some(topic) = topic(bag, None, FLOATS, &POWERS, "power")? {
        return Ok(Some(Power::Direct(field(topic, "data")?, 1.0)));
    }
    // PX4 counts a discharging current positive.
    if let Some(topic) = bag.topics().iter().find(|topic| topic.kind == "battery_status") {
        let (voltage, current) = (field(topic, "voltage_v")?, field(topic, "current_a")?);
        return Ok(Some(Power::Product { voltage, current, scale: 1.0, is_battery_state: false }));
    }
    let Some(topic) = topic(bag, None, BATTERY_STATE, &BATTERIES, "voltage and current")? else {
        return Ok(None);
    };
    let (voltage, current) = (field(topic, "voltage")?, field(topic, "current")?);
    Ok(Some(Power::Product { voltage, current, scale: -1.0, is_battery_state: true }))
}

pub(super) fn mass(bag: &Bag, topics: &Topics, fields: &mut Fields) -> Result<Option<Column>> {
    let (field, scale) = match &topics.mass {
        Some(signal) => (parsed(signal)?, signal.scale),
        None => match topic(bag, None, FLOATS, &MASSES, "mass")? {
            Some(topic) => (field(topic, "data")?, 1.0),
            None => return Ok(None),
        },
    };
    let source = field.to_string();
    Ok(Some(column(MASS, Expression::Number(fields.place(field), scale), source)))
}

fn commands(bag: &Bag, robot: &Robot, fields: &mut Fields) -> Result<Vec<Column>> {
    let named = robot.topics().commands.as_ref();
    let Some(topic) = topic(bag, named, TWISTS, &COMMANDS, "commands")? else { return Ok(Vec::new()) };
    let within = if topic.kind.ends_with("TwistStamped") { "twist." } else { "" };
    let wanted: &[(&str, &str)] = if robot.geometry().twist_components() == 3 {
        &[("cmd_vx_m_s", "linear.x"), ("cmd_vy_m_s", "linear.y"), ("cmd_omega_rad_s", "angular.z")]
    } else {
        &[("cmd_v_m_s", "linear.x"), ("cmd_omega_rad_s", "angular.z")]
    };
    let columns = wanted.iter().map(|(name, member)| {
        let field = field(topic, &format!("{within}{member}"))?;
        Ok(column(*name, Expression::Number(fields.place(field), 1.0), topic.name.clone()))
    });
    columns.collect()
}

/// Acceleration and turn rate of the only inertial sensor, or of the one that robot.toml names.
fn imu(bag: &Bag, topics: &Topics, fields: &mut Fields) -> Result<Vec<Column>> {
    let mut sensors = bag.topics().iter().filter(|topic| is_of(topic, IMU));
    let only = match (&topics.imu, sensors.next(), sensors.next()) {
        (Some(_), _, _) => topic(bag, topics.imu.as_ref(), IMU, &[], "imu")?,
        (None, first, None) => first,
        _ => None,
    };
    let Some(topic) = only else { return Ok(Vec::new()) };
    let accelerations =
        ["x", "y", "z"].map(|axis| (format!("accel_{axis}_m_s2"), format!("linear_acceleration.{axis}")));
    let turn = (YAW_RATE.to_owned(), "angular_velocity.z".to_owned());
    let columns = accelerations.into_iter().chain([turn]).map(|(name, path)| {
        let place = fields.place(field(topic, &path)?);
        Ok(column(name, Expression::Number(place, 1.0), topic.name.clone()))
    });
    columns.collect()
}
