//! Which fields of a bag become which columns.

use log_formats::merge::{Clock, Request, find_topic};
use log_formats::{Bag, Extractor, Field, Topic};
use support::error::{Error, Result};

use super::columns::{Column, Expression, nose_up};
use super::drivers::{self, Part};
use super::known::{
    BATTERIES, BATTERY_STATE, COMMANDS, FLOATS, IMU, JOINT_STATE, MASSES, ODOMETRY, ODOMETRY_KIND, POWERS,
    TRANSFORMS, TWISTS, find, is_called, is_of, is_tilt, wheel_joints,
};
use super::wrong::wrong;
use crate::robot::{self, Robot, Signal, Term, Topics};
use crate::{MASS, PITCH, POWER, YAW_RATE, sim_torque_column, speed_column};

/// What is read of a bag, and which columns are made of it.
#[derive(Debug, Clone)]
pub struct Chosen {
    /// What is merged.
    pub request: Request,
    /// Columns behind that of time.
    pub columns: Vec<Column>,
    /// The topic whose current is to be negative while discharging, as ROS has it, if power comes
    /// from one.
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
/// A topic or field of robot.toml that the bag does not have; several topics of one name; neither
/// wheel speeds nor power.
pub fn choose(bag: &Bag, robot: &Robot) -> Result<Chosen> {
    let topics = robot.topics();
    let mut fields = Fields::default();
    let mut columns = Vec::new();
    let mut lacking = Vec::new();
    match wheels(bag, robot, &mut fields)? {
        Some(wheels) => columns.extend(wheels),
        None => {
            let named = drivers::hint(bag).map_or(String::new(), |hint| format!("; say {hint}"));
            lacking.push(format!(
                "wheel speeds (JointState with known joints, Odometry, wheel_encoders{named})"
            ));
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
        Some(Power::Sum(parts)) => columns.push(sum(parts, &mut fields)),
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
    columns.extend(torques(robot, &mut fields)?);
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
    if let Some(columns) = named_wheels(robot, fields)? {
        return Ok(Some(columns));
    }
    if topics.odometry.is_none() {
        if let Some(columns) =
            drivers_wheels(bag, robot.motor().map(|motor| motor.gear_ratio), count, fields)?
        {
            return Ok(Some(columns));
        }
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

/// Wheel speeds as a base or motor drivers tell them.
pub(super) fn drivers_wheels(
    bag: &Bag,
    gear_ratio: Option<f64>,
    count: usize,
    fields: &mut Fields,
) -> Result<Option<Vec<Column>>> {
    let Some(speeds) = drivers::wheels(bag, gear_ratio)?.filter(|_| count == 2) else { return Ok(None) };
    let columns = speeds.into_iter().enumerate().map(|(wheel, (field, scale))| {
        let source = if scale == 1.0 { field.to_string() } else { format!("{field} × {scale:.4}") };
        column(speed_column(wheel), Expression::Number(fields.place(field), scale), source)
    });
    Ok(Some(columns.collect()))
}

/// Torques as robot.toml names them, under the names that a simulator's have.
fn torques(robot: &Robot, fields: &mut Fields) -> Result<Vec<Column>> {
    let (given, count) = (&robot.topics().torques, robot.wheels());
    if !given.is_empty() && given.len() != count {
        return Err(Error::failed(format!(
            "[topics] names {} torques; expected {count}, one a wheel",
            given.len()
        )));
    }
    let columns = given.iter().enumerate().map(|(wheel, signal)| {
        let place = fields.place(parsed(signal)?);
        Ok(column(sim_torque_column(wheel), Expression::Number(place, signal.scale), signal.to_string()))
    });
    columns.collect()
}

/// The column of power that is a sum of products.
pub(super) fn sum(parts: Vec<Part>, fields: &mut Fields) -> Column {
    let mut words = Vec::new();
    let mut terms = Vec::new();
    for part in parts {
        let named: Vec<String> = part.fields.iter().map(ToString::to_string).collect();
        let scale = if part.scale == 1.0 { String::new() } else { format!("{} times ", part.scale) };
        words.push(format!("{scale}{}", named.join(" times ")));
        terms.push((part.fields.into_iter().map(|field| fields.place(field)).collect(), part.scale));
    }
    column(POWER, Expression::Products(terms), words.join(" plus "))
}

/// Wheel speeds as robot.toml names them.
pub(super) fn named_wheels(robot: &Robot, fields: &mut Fields) -> Result<Option<Vec<Column>>> {
    let (given, count) = (&robot.topics().wheel_speeds, robot.wheels());
    if given.is_empty() {
        return Ok(None);
    }
    if given.len() != count {
        let message = format!("[topics] names {} wheel_speeds; expected {count}, one a wheel", given.len());
        return Err(Error::failed(message));
    }
    let columns = given.iter().enumerate().map(|(wheel, signal)| {
        let place = fields.place(parsed(signal)?);
        Ok(column(speed_column(wheel), Expression::Number(place, signal.scale), signal.to_string()))
    });
    columns.collect::<Result<Vec<_>>>().map(Some)
}

/// Wheel speeds from the topic of joints that has all of a known set; four wheels of a robot with a
/// column a side are averaged.
pub(super) fn joints(bag: &Bag, count: usize, fields: &mut Fields) -> Result<Option<Vec<Column>>> {
    let is_joints = |place: &usize| is_of(&bag.topics()[*place], JOINT_STATE);
    let mut places: Vec<usize> = (0..bag.topics().len()).filter(is_joints).collect();
    // A platform's own before one that joins it with an arm's.
    let is_platform = |place: usize| is_called(&bag.topics()[place], "platform/joint_states");
    places.sort_by_key(|&place| !is_platform(place));
    let mut sets = Vec::new();
    for place in places {
        let names = bag.names(place).map_err(wrong)?;
        let is_there = |joint: &&str| names.iter().any(|name| name == joint);
        let has_all = |set: &Vec<Vec<&str>>| set.iter().flatten().all(is_there);
        if let Some(wheels) = wheel_joints(count).into_iter().find(has_all) {
            sets.push((place, wheels));
        }
    }
    if let [(first, wheels), (second, _), ..] = &sets[..]
        && (!is_platform(*first) || is_platform(*second))
    {
        let names: Vec<&str> = sets.iter().map(|(place, _)| bag.topics()[*place].name.as_str()).collect();
        return Err(Error::failed(format!(
            "has several topics with the wheels' joints: {}; expected one named in [topics] of robot.toml, as in wheel_speeds = [\
             \"{}:velocity[{}]\", …]",
            names.join(", "),
            names[0],
            wheels[0][0]
        )));
    }
    if let Some((place, wheels)) = sets.into_iter().next() {
        let topic = &bag.topics()[place];
        let columns = wheels.iter().enumerate().map(|(wheel, joints)| {
            let mut places = Vec::new();
            for joint in joints {
                places.push(fields.place(field(topic, &format!("velocity[{joint}]"))?));
            }
            let expression =
                if places.len() == 1 { Expression::Number(places[0], 1.0) } else { Expression::Mean(places) };
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
    Sum(Vec<Part>),
}

/// Power as `[topics]` of robot.toml names it, whatever carries the messages.
#[derive(Debug, Clone)]
pub struct NamedPower {
    /// The numbers that it is made of.
    pub fields: Vec<Field>,
    /// W, of these numbers.
    pub expression: Expression,
    /// Which of them is a voltage, and what it is multiplied by to be in V.
    pub voltage: Option<(usize, f64)>,
}

/// The power that robot.toml names; none where it names none.
///
/// # Errors
/// A field that is none; voltage without current.
pub fn named_power(robot: &Robot) -> Result<Option<NamedPower>> {
    let topics = robot.topics();
    let parts = match named(topics)? {
        None => return Ok(None),
        Some(Power::Direct(field, scale)) => vec![Part { fields: vec![field], scale }],
        Some(Power::Product { voltage, current, scale, .. }) => {
            vec![Part { fields: vec![voltage, current], scale }]
        }
        Some(Power::Sum(parts)) => parts,
    };
    let factors = topics.power.0.iter().flat_map(|term| &term.factors);
    let alone = topics.voltage.iter().filter(|_| topics.power.0.is_empty());
    let voltage = factors.chain(alone).enumerate().find(|(_, factor)| factor.is_voltage());
    let voltage = voltage.map(|(place, factor)| (place, factor.scale));
    let mut fields = Fields::default();
    let expression = sum(parts, &mut fields).expression;
    let Fields { mut base, others } = fields;
    base.extend(others);
    Ok(Some(NamedPower { fields: base, expression, voltage }))
}

fn named(topics: &Topics) -> Result<Option<Power>> {
    match &topics.power.0[..] {
        [] => {}
        [Term { scale, factors }] if factors.len() == 1 => {
            return Ok(Some(Power::Direct(parsed(&factors[0])?, *scale)));
        }
        terms => {
            let product = |Term { scale, factors }: &Term| {
                Ok(Part { fields: factors.iter().map(parsed).collect::<Result<_>>()?, scale: *scale })
            };
            return Ok(Some(Power::Sum(terms.iter().map(product).collect::<Result<_>>()?)));
        }
    }
    match (&topics.voltage, &topics.current) {
        (Some(voltage), Some(current)) => {
            let scale = voltage.scale * current.scale;
            let (voltage, current) = (parsed(voltage)?, parsed(current)?);
            Ok(Some(Power::Product { voltage, current, scale, is_battery_state: false }))
        }
        (None, None) => Ok(None),
        _ => {
            let message = "[topics] of robot.toml names one of voltage and current; expected both, or power";
            Err(Error::failed(message))
        }
    }
}

pub(super) fn power(bag: &Bag, topics: &Topics) -> Result<Option<Power>> {
    if let Some(named) = named(topics)? {
        return Ok(Some(named));
    }
    if let Some(topic) = topic(bag, None, FLOATS, &POWERS, "power")? {
        return Ok(Some(Power::Direct(field(topic, "data")?, 1.0)));
    }
    // PX4 counts a discharging current positive.
    let of_px4: Vec<&Topic> = bag.topics().iter().filter(|topic| topic.kind == "battery_status").collect();
    if let [first, second, ..] = of_px4[..] {
        return Err(Error::failed(format!(
            "has several topics for voltage and current: {}, {}; expected voltage and current of one in [topics] of robot.toml",
            first.name, second.name
        )));
    }
    if let Some(topic) = of_px4.first() {
        let (voltage, current) = (field(topic, "voltage_v")?, field(topic, "current_a")?);
        return Ok(Some(Power::Product { voltage, current, scale: 1.0, is_battery_state: false }));
    }
    let Some(topic) = battery(bag)? else {
        let parts = drivers::power(bag)?;
        return Ok((!parts.is_empty()).then_some(Power::Sum(parts)));
    };
    let (voltage, current) = (field(topic, "voltage")?, field(topic, "current")?);
    Ok(Some(Power::Product { voltage, current, scale: -1.0, is_battery_state: true }))
}

/// The battery: by the names that robots give it, or the only topic of its type, under whatever
/// name.
///
/// # Errors
/// Several of them.
pub(super) fn battery(bag: &Bag) -> Result<Option<&Topic>> {
    let key = "voltage and current";
    if let Some(battery) = topic(bag, None, BATTERY_STATE, &BATTERIES, key)? {
        return Ok(Some(battery));
    }
    let all: Vec<&Topic> = bag.topics().iter().filter(|topic| is_of(topic, BATTERY_STATE)).collect();
    match all[..] {
        [] => Ok(None),
        [only] => Ok(Some(only)),
        _ => {
            let names: Vec<&str> = all.iter().map(|topic| topic.name.as_str()).collect();
            Err(Error::failed(format!(
                "has several topics for {key}: {}; expected one named as voltage and current in [topics] of robot.toml",
                names.join(", ")
            )))
        }
    }
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

/// Acceleration, turn rate and pitch of the only inertial sensor, or of the one that robot.toml
/// names.
fn imu(bag: &Bag, topics: &Topics, fields: &mut Fields) -> Result<Vec<Column>> {
    let mut sensors = bag.topics().iter().filter(|topic| is_of(topic, IMU));
    let only = match (&topics.imu, sensors.next(), sensors.next()) {
        (Some(_), _, _) => topic(bag, topics.imu.as_ref(), IMU, &[], "imu")?,
        (None, first, None) => first,
        _ => None,
    };
    let Some(topic) = only else { return Ok(tilt(bag, fields)?.into_iter().collect()) };
    let accelerations =
        ["x", "y", "z"].map(|axis| (format!("accel_{axis}_m_s2"), format!("linear_acceleration.{axis}")));
    let turn = (YAW_RATE.to_owned(), "angular_velocity.z".to_owned());
    let columns = accelerations.into_iter().chain([turn]).map(|(name, path)| {
        let place = fields.place(field(topic, &path)?);
        Ok(column(name, Expression::Number(place, 1.0), topic.name.clone()))
    });
    let mut columns = columns.collect::<Result<Vec<_>>>()?;
    let orientation =
        ["orientation.x", "orientation.y", "orientation.z", "orientation.w", "orientation_covariance[0]"];
    let place = bag.topics().iter().position(|known| known.name == topic.name).unwrap_or(0);
    let first = drivers::first(bag, place, &orientation.map(str::to_owned))?;
    if nose_up([first[0], first[1], first[2], first[3]], Some(first[4])).is_nan()
        && let Some(tilt) = tilt(bag, fields)?
    {
        columns.push(tilt);
        return Ok(columns);
    }
    let [x, y, z, w, covariance] = orientation.map(|path| Ok(fields.place(field(topic, path)?)));
    let turned = Expression::NoseUp([x?, y?, z?, w?], Some(covariance?));
    columns.push(column(PITCH, turned, format!("{}:orientation", topic.name)));
    Ok(columns)
}

/// Pitch of the robot's body as /tf has it, where no Imu tells it. Odometry that knows the plane
/// only turns about nothing but z.
fn tilt(bag: &Bag, fields: &mut Fields) -> Result<Option<Column>> {
    const LOOKED_AT: usize = 100;
    for (place, topic) in bag.topics().iter().enumerate() {
        if !is_of(topic, TRANSFORMS) || !is_called(topic, "tf") {
            continue;
        }
        for transform in bag.names(place).map_err(wrong)?.iter().filter(|name| is_tilt(name)) {
            let [x, y, z, w] = ["x", "y", "z", "w"]
                .map(|axis| field(topic, &format!("transforms[{transform}].transform.rotation.{axis}")));
            let all = [x?, y?, z?, w?];
            let mut extractor = Extractor::new(topic, &[&all[0], &all[1]]).map_err(wrong)?;
            let (mut remaining, mut is_tilted) = (LOOKED_AT, false);
            let read = bag.read(&[place], &mut |_, _, message| {
                let numbers = extractor.numbers(message)?;
                remaining -= usize::from(!numbers[0].is_nan());
                is_tilted |= numbers.iter().any(|number| number.abs() > 0.0);
                Ok(remaining > 0 && !is_tilted)
            });
            read.map_err(wrong)?;
            if is_tilted {
                let places = all.map(|field| fields.place(field));
                let source = format!("{} of {transform}", topic.name);
                return Ok(Some(column(PITCH, Expression::NoseUp(places, None), source)));
            }
        }
    }
    Ok(None)
}
