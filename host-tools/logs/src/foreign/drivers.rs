//! Power and wheel speeds out of what motor drivers and bases say of themselves, found by the types
//! of their messages.
//!
//! Fields and units by the makers' definitions: ODrive (odriverobotics/ros_odrive, `bus_current`
//! positive while it draws: ODrive's API reference, `ibus`), VESC (f1tenth/vesc, vesc_msgs),
//! Clearpath (clearpathrobotics/clearpath_msgs), Husarion (husarion/husarion_ugv_ros), iRobot
//! (iRobotEducation/irobot_create_msgs), ArduPilot (AP_BattMonitor's and AP_ESC_Telem's
//! LogStructure.h; current positive while it is drawn).

use log_formats::{Bag, Extractor, Field, Topic};
use support::error::Result;

use super::choose::field;
use super::known::is_of;
use super::wrong::wrong;

/// Numbers that are multiplied with each other and a factor.
pub(super) struct Part {
    pub(super) fields: Vec<Field>,
    pub(super) scale: f64,
}

const ODRIVE: &str = "odrive_can/msg/ODriveStatus";
const ODRIVE_CONTROLLER: &str = "odrive_can/msg/ControllerStatus";
const VESC: &str = "vesc_msgs/msg/VescStateStamped";
const CLEARPATH_POWER: &str = "clearpath_platform_msgs/msg/Power";
const CLEARPATH_MOTORS: &str = "clearpath_motor_msgs/msg/LynxMultiFeedback";
const HUSARION: &str = "husarion_ugv_msgs/msg/RobotDriverState";
const ARDUPILOT_BATTERY: &str = "ardupilot/BAT";
const ARDUPILOT_ESC: &str = "ardupilot/ESC";
const VESC_TOOL: &str = "vesc_tool/log";
const CREATE: &str = "irobot_create_msgs/msg/WheelVels";

/// Drivers of a robot at most, as wheels of the model.
const MOST_DRIVERS: usize = model_core::coefficients::MOST_WHEELS;

/// Places of this type's topics.
fn of(bag: &Bag, kind: &str) -> Vec<usize> {
    (0..bag.topics().len()).filter(|&place| is_of(&bag.topics()[place], &[kind])).collect()
}

/// These numbers of the first message of a topic; NaN where it has none.
pub(super) fn first(bag: &Bag, place: usize, paths: &[String]) -> Result<Vec<f64>> {
    let topic = &bag.topics()[place];
    let fields = paths.iter().map(|path| field(topic, path)).collect::<Result<Vec<_>>>()?;
    let mut extractor = Extractor::new(topic, &fields.iter().collect::<Vec<_>>()).map_err(wrong)?;
    let mut numbers = vec![f64::NAN; paths.len()];
    let read = bag.read(&[place], &mut |_, _, message| {
        numbers.copy_from_slice(extractor.numbers(message)?);
        Ok(false)
    });
    read.map_err(wrong)?;
    Ok(numbers)
}

/// Elements of an array in the first message of a topic, up to some.
fn elements(bag: &Bag, place: usize, most: usize, path: impl Fn(usize) -> String) -> Result<usize> {
    let numbers = first(bag, place, &(0..most).map(path).collect::<Vec<_>>())?;
    Ok(numbers.iter().take_while(|number| !number.is_nan()).count())
}

fn product(topic: &Topic, voltage: &str, current: &str) -> Result<Part> {
    Ok(Part { fields: vec![field(topic, voltage)?, field(topic, current)?], scale: 1.0 })
}

/// The products of the elements of an array of drivers.
fn each(bag: &Bag, place: usize, array: &str, voltage: &str, current: &str) -> Result<Vec<Part>> {
    let drivers = elements(bag, place, MOST_DRIVERS, |driver| format!("{array}[{driver}].{current}"))?;
    let of_driver = |driver: usize| {
        let path = |member: &str| format!("{array}[{driver}].{member}");
        product(&bag.topics()[place], &path(voltage), &path(current))
    };
    (0..drivers).map(of_driver).collect()
}

/// A Clearpath base's own readings. Its arrays differ by robot, as their constants say: battery
/// voltage and total current come first, but for a Husky A200, the only one with three currents,
/// which has one a driver and one of all else, each with its voltage.
fn clearpath(bag: &Bag, place: usize) -> Result<Vec<Part>> {
    const HUSKY_CURRENTS: usize = 3;
    let currents = elements(bag, place, HUSKY_CURRENTS + 1, |at| format!("measured_currents[{at}]"))?;
    let drivers = if currents == HUSKY_CURRENTS { HUSKY_CURRENTS } else { currents.min(1) };
    let of_driver = |at: usize| {
        let (voltage, current) = (format!("measured_voltages[{at}]"), format!("measured_currents[{at}]"));
        product(&bag.topics()[place], &voltage, &current)
    };
    (0..drivers).map(of_driver).collect()
}

/// Power as the sum over all drivers, by the first of these types that the bag has; empty if it has
/// none.
///
/// # Errors
/// Damage; a message whose definition lacks what its type has.
pub(super) fn power(bag: &Bag) -> Result<Vec<Part>> {
    let topics = bag.topics();
    for (kind, voltage, current) in
        [(ODRIVE, "bus_voltage", "bus_current"), (VESC, "state.voltage_input", "state.current_input")]
    {
        let parts = of(bag, kind).into_iter().map(|place| product(&topics[place], voltage, current));
        let parts = parts.collect::<Result<Vec<_>>>()?;
        if !parts.is_empty() {
            return Ok(parts);
        }
    }
    // The first battery only: others of the same robot may be in series, parallel or spare.
    if let Some(battery) = topics.iter().find(|topic| topic.kind == ARDUPILOT_BATTERY) {
        return Ok(vec![product(battery, "Volt", "Curr")?]);
    }
    if let [only] = of(bag, VESC_TOOL)[..] {
        // The sum of all VESCs on the bus, where VESC Tool has asked them: else their time is -1.
        let has_setup =
            log_formats::paths(&topics[only]).map_err(wrong)?.iter().any(|path| path == "ms_today_setup");
        let asked = has_setup && first(bag, only, &["ms_today_setup".to_owned()])?[0] >= 0.0;
        let current = if asked { "current_in_setup" } else { "current_in" };
        return Ok(vec![product(&topics[only], "input_voltage", current)?]);
    }
    if let [only] = of(bag, CLEARPATH_POWER)[..] {
        return clearpath(bag, only);
    }
    for (kind, array, voltage, current) in [
        (CLEARPATH_MOTORS, "drivers", "voltage", "current"),
        (HUSARION, "driver_states", "state.voltage", "state.current"),
    ] {
        if let [only] = of(bag, kind)[..] {
            return each(bag, only, array, voltage, current);
        }
    }
    Ok(Vec::new())
}

/// Speeds of the left and the right wheel and what they are multiplied by to be rad/s; `None` where
/// nothing says them.
///
/// # Errors
/// A message whose definition lacks what its type has.
pub(super) fn wheels(bag: &Bag, gear_ratio: Option<f64>) -> Result<Option<[(Field, f64); 2]>> {
    let topics = bag.topics();
    if let [only] = of(bag, CREATE)[..] {
        let side = |path| Ok((field(&topics[only], path)?, 1.0));
        return Ok(Some([side("velocity_left")?, side("velocity_right")?]));
    }
    let controllers = of(bag, ODRIVE_CONTROLLER);
    let called = |side: &str| controllers.iter().copied().find(|&place| topics[place].name.contains(side));
    let ([_, _], Some(left), Some(right)) = (&controllers[..], called("left"), called("right")) else {
        return Ok(None);
    };
    // Revolutions of the motor a second.
    let scale = std::f64::consts::TAU / gear_ratio.unwrap_or(1.0);
    Ok(Some([
        (field(&topics[left], "vel_estimate")?, scale),
        (field(&topics[right], "vel_estimate")?, scale),
    ]))
}

/// How to name wheel speeds that these drivers tell, but not of which wheel, or in which unit.
pub(super) fn hint(bag: &Bag) -> Option<String> {
    let written = [
        (ODRIVE_CONTROLLER, "vel_estimate", "rev/s", "1 / gear ratio"),
        (VESC, "state.speed", "rpm", "1 / (pole pairs × gear ratio)"),
        (VESC_TOOL, "erpm", "rpm", "1 / (pole pairs × gear ratio)"),
        (ARDUPILOT_ESC, "RPM", "rpm", "1 / gear ratio"),
    ];
    let topic = |kind| of(bag, kind).first().map(|&place| &bag.topics()[place].name);
    written.iter().find_map(|(kind, path, unit, scale)| {
        let topic = topic(kind)?;
        Some(format!(
            "wheel_speeds = [{{ field = \"{topic}:{path}\", unit = \"{unit}\", scale = {scale}, negative for a mirrored motor }}, …]"
        ))
    })
}
