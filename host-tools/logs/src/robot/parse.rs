//! robot.toml → [`Robot`], with line and column of whatever is wrong.

use std::ops::Range;

use model_core::charge::Pack;
use model_core::plausibility::LEAST_CUTOFF;
use serde::Deserialize;
use support::error::{Error, Result};
use support::printable;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::{
    DEFAULT_GYRATION_SHARE, DEFAULT_MAPE_FLOOR_W, DEFAULT_SPEED_DEAD_BAND_RAD_S, Geometry, Limits, LogUnits,
    Motor, NodeSettings, PowerSource, Robot, Topics, lenient,
};

/// Most wheels that the tools are compiled for.
const MOST_WHEELS: usize = model_core::coefficients::MOST_WHEELS;

const KINEMATICS: &str = "differential, skid-steer, omni3, mecanum or matrix";

/// Unknown keys that are named one by one: more are another file, not misspellings.
const MOST_UNKNOWN: usize = 10;

/// Every key that means something.
const KEYS: [&str; 29] = [
    "name",
    "kinematics",
    "wheels",
    "wheel_radius_m",
    "track_m",
    "arm_m",
    "half_length_m",
    "half_width_m",
    "matrix",
    "gyration_radius_m",
    "mass_no_load_kg",
    "mass_full_load_kg",
    "static_power_w",
    "mape_floor_w",
    "regeneration",
    "filter_cutoff_hz",
    "speed_dead_band_rad_s",
    "max_speed_m_s",
    "max_turn_rad_s",
    "max_acceleration_m_s2",
    "motor_resistance_ohm",
    "motor_torque_constant_nm_a",
    "motor_gear_ratio",
    "motor_gear_efficiency",
    "battery",
    "sensors",
    "topics",
    "node",
    "description",
];

pub(super) fn robot(text: &str) -> Result<Robot> {
    let table = DeTable::parse(text).map_err(|error| {
        let message =
            format!("{}; expected TOML, one key = value a line", error.message().replace('\n', " "));
        match error.span() {
            Some(span) => at(text, &span, message),
            None => Error::failed(message),
        }
    })?;
    let file = File { text, table: table.get_ref() };

    let (geometry, needed) = geometry(&file)?;
    let required = |key| file.number(key)?.ok_or_else(|| file.missing(key, needed));
    let mass_no_load_kg = positive(required("mass_no_load_kg")?)?;
    let full = required("mass_full_load_kg")?;
    let mass_full_load_kg = full.check(
        |mass| mass > mass_no_load_kg,
        || format!("a number above mass_no_load_kg = {mass_no_load_kg}"),
    )?;
    let given_gyration = file.number("gyration_radius_m")?.map(positive).transpose()?;
    let gyration_radius_m = given_gyration
        .or_else(|| geometry.width_m().map(|width| DEFAULT_GYRATION_SHARE * width))
        .ok_or_else(|| file.missing("gyration_radius_m", needed))?;
    let static_power_w = file.number("static_power_w")?.map(not_negative).transpose()?;
    let node = node(&file, geometry.wheels())?;

    Ok(Robot {
        name: file.string("name")?.map_or_else(|| "unnamed".to_owned(), |name| printable::name(&name.value)),
        geometry,
        gyration_radius_m,
        gyration_is_estimated: given_gyration.is_none(),
        mass_no_load_kg,
        mass_full_load_kg,
        static_power_w,
        mape_floor_w: file.number("mape_floor_w")?.map_or(Ok(DEFAULT_MAPE_FLOOR_W), not_negative)?,
        regeneration: file.boolean("regeneration")?.unwrap_or(false),
        filter_cutoff_hz: file.number("filter_cutoff_hz")?.map(cutoff).transpose()?,
        speed_dead_band_rad_s: file
            .number("speed_dead_band_rad_s")?
            .map_or(Ok(DEFAULT_SPEED_DEAD_BAND_RAD_S), not_negative)?,
        limits: Limits {
            speed_m_s: file.number("max_speed_m_s")?.map(positive).transpose()?,
            turn_rad_s: file.number("max_turn_rad_s")?.map(positive).transpose()?,
            acceleration_m_s2: file.number("max_acceleration_m_s2")?.map(positive).transpose()?,
        },
        motor: motor(&file)?,
        battery: battery(&file)?,
        sensors: file.any("sensors"),
        topics: topics(&file)?,
        node,
        unknown_keys: file.unknown_keys(),
        log_units: LogUnits::default(),
        power_source: PowerSource::default(),
    })
}

/// The motor, where the file tells resistance, torque constant and gear ratio: one without the
/// others says nothing.
fn motor(file: &File<'_>) -> Result<Option<Motor>> {
    const KEYS: [&str; 3] = ["motor_resistance_ohm", "motor_torque_constant_nm_a", "motor_gear_ratio"];
    let efficiency = file.number("motor_gear_efficiency")?;
    let expected = || "a number above 0, 1 at most".to_owned();
    let gear_efficiency =
        efficiency.map(|value| value.check(|x| x > 0.0 && x <= 1.0, expected)).transpose()?;
    let mut values = [0.0; KEYS.len()];
    let mut given = 0;
    for (value, key) in values.iter_mut().zip(KEYS) {
        if let Some(number) = file.number(key)? {
            *value = positive(number)?;
            given += 1;
        }
    }
    let [resistance_ohm, torque_constant_nm_a, gear_ratio] = values;
    match given {
        0 if gear_efficiency.is_none() => Ok(None),
        3 => Ok(Some(Motor { resistance_ohm, torque_constant_nm_a, gear_ratio, gear_efficiency })),
        _ => Err(Error::failed(format!("a motor is told by {} together", KEYS.join(", ")))),
    }
}

/// Where bags have what the logs need.
fn topics(file: &File<'_>) -> Result<Topics> {
    const EXPECTED: &str = "wheel_speeds, odometry, power, voltage, current, commands, imu, mass, torques, greatest_gap_s, clock (stamp or receipt)";
    let Some(written) = file.get("topics") else { return Ok(Topics::default()) };
    let read = Topics::deserialize(toml::de::ValueDeserializer::from(written.clone()));
    let is_gap = |topics: &Topics| topics.greatest_gap_s > 0.0 && topics.greatest_gap_s <= 3600.0;
    let why = match read {
        Ok(topics) if is_gap(&topics) => match topics.checked() {
            Ok(topics) => return Ok(topics),
            Err(why) => why,
        },
        Ok(topics) => {
            format!("greatest_gap_s = {}; expected above 0 and at most 3600", topics.greatest_gap_s)
        }
        Err(error) => format!("{}; expected of {EXPECTED}", error.message().replace('\n', " ")),
    };
    Err(at(file.text, &written.span(), format!("[topics]: {why}")))
}

/// The sensor on the robot's computer, and topics.
fn node(file: &File<'_>, wheels: usize) -> Result<NodeSettings> {
    let Some(written) = file.get("node") else { return Ok(NodeSettings::default()) };
    let read = NodeSettings::deserialize(toml::de::ValueDeserializer::from(written.clone()));
    let why = match read {
        Ok(node) => match node.wrong(wheels) {
            None => return Ok(node),
            Some(why) => why,
        },
        Err(error) => error.message().replace('\n', " "),
    };
    Err(at(file.text, &written.span(), format!("[node]: {why}")))
}

/// The battery, where the file tells of one.
fn battery(file: &File<'_>) -> Result<Option<Pack<f64>>> {
    let Some(written) = file.get("battery") else { return Ok(None) };
    let pack = super::battery::pack(toml::de::ValueDeserializer::from(written.clone()));
    pack.map(Some).map_err(|why| at(file.text, &written.span(), format!("[battery]: {why}")))
}

/// The geometry, and the keys that its kinematics needs, for messages.
fn geometry(file: &File<'_>) -> Result<(Geometry, &'static str)> {
    let Some(kinematics) = file.string("kinematics")? else {
        let message = format!("key kinematics is missing; expected {KINEMATICS}");
        return Err(Error::failed(message));
    };
    const MASSES: &str = "wheel_radius_m, track_m, mass_no_load_kg, mass_full_load_kg";
    let length = |key, needed| -> Result<f64> {
        positive(file.number(key)?.ok_or_else(|| file.missing(key, needed))?)
    };
    Ok(match lenient(&kinematics.value).as_str() {
        "differential" | "differentialdrive" | "diffdrive" => (
            Geometry::DifferentialDrive {
                wheel_radius_m: length("wheel_radius_m", MASSES)?,
                track_m: length("track_m", MASSES)?,
            },
            MASSES,
        ),
        "skidsteer" | "skidsteering" | "skid" => {
            let wheels = match file.number("wheels")? {
                None => 2,
                Some(wheels) => wheels.check(
                    |n| n == 2.0 || n == 4.0,
                    || "2 (one log column a side) or 4 (one a wheel)".to_owned(),
                )? as usize,
            };
            let wheel_radius_m = length("wheel_radius_m", MASSES)?;
            (Geometry::SkidSteer { wheel_radius_m, track_m: length("track_m", MASSES)?, wheels }, MASSES)
        }
        "omni3" | "threewheelomni" | "omni" => {
            let needed = "wheel_radius_m, arm_m, mass_no_load_kg, mass_full_load_kg";
            let wheel_radius_m = length("wheel_radius_m", needed)?;
            (Geometry::ThreeWheelOmni { wheel_radius_m, arm_m: length("arm_m", needed)? }, needed)
        }
        "mecanum" | "mecanum4" | "fourmecanum" => {
            let needed = "wheel_radius_m, half_length_m, half_width_m, mass_no_load_kg, mass_full_load_kg";
            (
                Geometry::FourMecanum {
                    wheel_radius_m: length("wheel_radius_m", needed)?,
                    half_length_m: length("half_length_m", needed)?,
                    half_width_m: length("half_width_m", needed)?,
                },
                needed,
            )
        }
        "matrix" | "given" => {
            let needed = "matrix, gyration_radius_m, mass_no_load_kg, mass_full_load_kg";
            let wheel_radius_m = file.number("wheel_radius_m")?.map(positive).transpose()?;
            (Geometry::Matrix { rows: file.matrix(needed)?, wheel_radius_m }, needed)
        }
        _ => return Err(kinematics.wrong(&format!("{:?}", kinematics.value), KINEMATICS)),
    })
}

fn positive(number: Value<'_, f64>) -> Result<f64> {
    number.check(|value| value > 0.0, || "a number above 0".to_owned())
}

/// A filter that settles within a window.
fn cutoff(number: Value<'_, f64>) -> Result<f64> {
    let expected = || format!("{LEAST_CUTOFF} or more: a slower filter settles too late for any mass");
    number.check(|value| value >= LEAST_CUTOFF, expected)
}

fn not_negative(number: Value<'_, f64>) -> Result<f64> {
    number.check(|value| value >= 0.0, || "a number not below 0".to_owned())
}

struct File<'a> {
    text: &'a str,
    table: &'a DeTable<'a>,
}

/// A value and where it stands.
struct Value<'a, T> {
    value: T,
    key: &'a str,
    text: &'a str,
    span: Range<usize>,
}

impl<T> Value<'_, T> {
    fn wrong(&self, value: &str, expected: &str) -> Error {
        at(self.text, &self.span, format!("{} = {value}; expected {expected}", self.key))
    }
}

impl Value<'_, f64> {
    fn check(self, allowed: impl Fn(f64) -> bool, expected: impl Fn() -> String) -> Result<f64> {
        if self.value.is_finite() && allowed(self.value) {
            Ok(self.value)
        } else {
            Err(self.wrong(&self.value.to_string(), &expected()))
        }
    }
}

impl<'a> File<'a> {
    fn get(&self, key: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.table.iter().find(|(name, _)| name.get_ref() == key).map(|(_, value)| value)
    }

    fn typed<T>(
        &self,
        key: &'a str,
        expected: &str,
        read: impl Fn(&DeValue<'a>) -> Option<T>,
    ) -> Result<Option<Value<'a, T>>> {
        let Some(spanned) = self.get(key) else { return Ok(None) };
        let span = spanned.span();
        match read(spanned.get_ref()) {
            Some(value) => Ok(Some(Value { value, key, text: self.text, span })),
            None => {
                let value = &self.text[span.clone()];
                Err(Value { value: (), key, text: self.text, span }
                    .wrong(value.lines().next().unwrap_or(""), expected))
            }
        }
    }

    fn number(&self, key: &'a str) -> Result<Option<Value<'a, f64>>> {
        self.typed(key, "a number", number)
    }

    fn boolean(&self, key: &'a str) -> Result<Option<bool>> {
        Ok(self.typed(key, "true or false", DeValue::as_bool)?.map(|value| value.value))
    }

    fn string(&self, key: &'a str) -> Result<Option<Value<'a, String>>> {
        self.typed(key, "text in quotes", |value| value.as_str().map(str::to_owned))
    }

    fn any(&self, key: &str) -> Option<toml::Value> {
        let value = self.get(key)?.clone();
        toml::Value::deserialize(toml::de::ValueDeserializer::from(value)).ok()
    }

    fn matrix(&self, needed: &str) -> Result<Vec<Vec<f64>>> {
        let expected = format!(
            "2 rows (vx, omega) or 3 rows (vx, vy, omega) of 1 to {MOST_WHEELS} finite numbers each, one a wheel"
        );
        let rows = self
            .typed("matrix", &expected, |value| {
                let rows = value.as_array()?.iter().map(|row| {
                    row.get_ref()
                        .as_array()?
                        .iter()
                        .map(|entry| number(entry.get_ref()))
                        .collect::<Option<Vec<f64>>>()
                });
                let rows = rows.collect::<Option<Vec<_>>>()?;
                let wheels = rows.first()?.len();
                let fits = (2..=3).contains(&rows.len())
                    && (1..=MOST_WHEELS).contains(&wheels)
                    && rows
                        .iter()
                        .all(|row| row.len() == wheels && row.iter().all(|entry| entry.is_finite()));
                fits.then_some(rows)
            })?
            .ok_or_else(|| self.missing("matrix", needed))?;
        Ok(rows.value)
    }

    fn missing(&self, key: &str, needed: &str) -> Error {
        Error::failed(format!("key {key} is missing; these kinematics need {needed}"))
    }

    fn unknown_keys(&self) -> Vec<String> {
        let unknown = || self.table.keys().filter(|key| !KEYS.contains(&key.get_ref().as_ref()));
        let more = unknown().count().saturating_sub(MOST_UNKNOWN);
        let further = (more > 0).then(|| format!("and {more} more unknown keys"));
        unknown()
            .take(MOST_UNKNOWN)
            .map(|key| {
                let (line, column) = position(self.text, key.span().start);
                format!(
                    "{line}:{column}: unknown key {} is not used; known are {}",
                    key.get_ref(),
                    KEYS.join(", ")
                )
            })
            .chain(further)
            .collect()
    }
}

fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
        _ => None,
    }
}

fn at(text: &str, span: &Range<usize>, message: String) -> Error {
    let (line, column) = position(text, span.start);
    Error::failed(message).at_line(line).in_column(column.to_string())
}

/// Line and column, counted from 1, of a byte.
pub fn position(text: &str, byte: usize) -> (u64, u64) {
    let before = &text.as_bytes()[..byte.min(text.len())];
    let line_start = before.iter().rposition(|&b| b == b'\n').map_or(0, |newline| newline + 1);
    let line = before.iter().filter(|&&b| b == b'\n').count() + 1;
    let column = String::from_utf8_lossy(&before[line_start..]).chars().count() + 1;
    (line as u64, column as u64)
}
