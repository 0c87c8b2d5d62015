//! robot.toml: what is known of a robot beforehand.

mod battery;
pub mod chassis;
mod core;
mod geometry;
mod load;
mod motor;
mod node;
mod parse;
mod signal;
mod topics;
mod units;

pub use geometry::Geometry;
pub use load::{FOUND, nearest};
pub use motor::Motor;
pub use node::{NodeSettings, PowerChip};
pub use parse::position;
pub use signal::{Signal, Sum, Term};
use support::error::Result;
pub use topics::{Clock, Topics};
pub use units::{LogUnits, MassUnit, PowerSource, PowerUnit, SpeedUnit};

use model_core::charge::Pack;

/// Mean absolute percentage errors leave out samples below this power unless the robot's file says
/// otherwise, W.
pub const DEFAULT_MAPE_FLOOR_W: f64 = 0.1;
/// Wheel speeds below this count as standing unless the robot's file says otherwise, rad/s.
pub const DEFAULT_SPEED_DEAD_BAND_RAD_S: f64 = 0.02;
/// Radius of gyration as a share of the width across the wheels where the robot's file does not
/// give it: that of a square plate as wide as the robot, side/√6.
pub const DEFAULT_GYRATION_SHARE: f64 = 0.4;

/// How far a robot may be driven, as far as its file says.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Limits {
    /// Forward speed, m/s.
    pub speed_m_s: Option<f64>,
    /// Turn rate, rad/s.
    pub turn_rad_s: Option<f64>,
    /// Acceleration of the wheels' rims, m/s².
    pub acceleration_m_s2: Option<f64>,
}

/// A robot as its file describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    pub(crate) name: String,
    pub(crate) geometry: Geometry,
    pub(crate) gyration_radius_m: f64,
    pub(crate) gyration_is_estimated: bool,
    pub(crate) mass_no_load_kg: f64,
    pub(crate) mass_full_load_kg: f64,
    pub(crate) static_power_w: Option<f64>,
    pub(crate) mape_floor_w: f64,
    pub(crate) regeneration: bool,
    pub(crate) filter_cutoff_hz: Option<f64>,
    pub(crate) speed_dead_band_rad_s: f64,
    pub(crate) limits: Limits,
    pub(crate) motor: Option<Motor>,
    pub(crate) battery: Option<Pack<f64>>,
    pub(crate) sensors: Option<toml::Value>,
    pub(crate) topics: Topics,
    pub(crate) node: NodeSettings,
    pub(crate) unknown_keys: Vec<String>,
    pub(crate) log_units: LogUnits,
    pub(crate) power_source: PowerSource,
}

impl Robot {
    /// Name for people.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How the wheels move the robot.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Number of driven wheels N, as the logs have them.
    pub fn wheels(&self) -> usize {
        self.geometry.wheels()
    }

    /// Wheel radius, m, where the geometry has one.
    pub fn wheel_radius_m(&self) -> Option<f64> {
        self.geometry.wheel_radius_m()
    }

    /// Radius of gyration about the vertical axis, m.
    pub fn gyration_radius_m(&self) -> f64 {
        self.gyration_radius_m
    }

    /// Whether the radius of gyration was not given, but estimated from the width.
    pub fn gyration_is_estimated(&self) -> bool {
        self.gyration_is_estimated
    }

    /// Mass without payload, kg (Eq. 25).
    pub fn mass_no_load_kg(&self) -> f64 {
        self.mass_no_load_kg
    }

    /// Mass with the greatest payload, kg (Eq. 25).
    pub fn mass_full_load_kg(&self) -> f64 {
        self.mass_full_load_kg
    }

    /// Static power, W, if the file gives it.
    pub fn static_power_w(&self) -> Option<f64> {
        self.static_power_w
    }

    /// Whether `power_w` of the logs is total power, the static power included.
    pub fn power_is_total(&self) -> bool {
        self.static_power_w.is_some()
    }

    /// Power below which a sample is left out of mean absolute percentage errors, W.
    pub fn mape_floor_w(&self) -> f64 {
        self.mape_floor_w
    }

    /// Whether the drive feeds braking power back, so that negative power is real.
    pub fn regeneration(&self) -> bool {
        self.regeneration
    }

    /// Cut-off of the low-pass filter on speed and power, Hz, if the file gives it.
    pub fn filter_cutoff_hz(&self) -> Option<f64> {
        self.filter_cutoff_hz
    }

    /// Wheel speed below which a wheel stands, rad/s.
    pub fn speed_dead_band_rad_s(&self) -> f64 {
        self.speed_dead_band_rad_s
    }

    /// How far profiles may go.
    pub fn limits(&self) -> Limits {
        self.limits
    }

    /// Its motors, as far as the file tells of them.
    pub fn motor(&self) -> Option<&Motor> {
        self.motor.as_ref()
    }

    /// Its battery, as far as the file tells of it.
    pub fn battery(&self) -> Option<&Pack<f64>> {
        self.battery.as_ref()
    }

    /// The same with logs in these units.
    ///
    /// # Errors
    /// Units that its logs cannot have: m/s without a wheel radius, a wheel that it has not.
    pub fn with_log_units(self, log_units: LogUnits) -> Result<Self> {
        log_units.check(self.wheels(), self.wheel_radius_m())?;
        Ok(Self { log_units, ..self })
    }

    /// The units that its logs are in.
    pub fn log_units(&self) -> &LogUnits {
        &self.log_units
    }

    /// The same with the power of its logs in other columns.
    #[must_use]
    pub fn with_power_from(self, power_source: PowerSource) -> Self {
        Self { power_source, ..self }
    }

    /// Where the power of its logs is read from.
    pub fn power_source(&self) -> PowerSource {
        self.power_source
    }

    /// rad/s in one unit of a wheel's speed in its logs, with the sign of that wheel, counted from
    /// 0.
    pub fn log_speed_scale(&self, wheel: usize) -> f64 {
        // That there is a radius where it is needed was checked when the units were set.
        let size = self.log_units.speed.in_rad_s(self.wheel_radius_m()).unwrap_or(1.0);
        if self.log_units.flipped.contains(&(wheel + 1)) { -size } else { size }
    }

    /// What the file says about sensors, as it says it.
    pub fn sensors(&self) -> Option<&toml::Value> {
        self.sensors.as_ref()
    }

    /// Where bags have what its logs need.
    pub fn topics(&self) -> &Topics {
        &self.topics
    }

    /// What `gmr node` reads and says.
    pub fn node(&self) -> &NodeSettings {
        &self.node
    }

    /// Another sensor than the file's, or on another bus.
    pub fn set_node(&mut self, sensor: Option<PowerChip>, bus: Option<&str>) {
        self.node.sensor = sensor.unwrap_or(self.node.sensor);
        if let Some(bus) = bus {
            bus.clone_into(&mut self.node.bus);
        }
    }

    /// Keys of the file that mean nothing here: `line:column: …`.
    pub fn unknown_keys(&self) -> &[String] {
        &self.unknown_keys
    }
}

/// A name without case, `-`, `_` and spaces.
pub fn lenient(name: &str) -> String {
    name.chars().filter(|c| !matches!(c, '-' | '_' | ' ')).flat_map(char::to_lowercase).collect()
}
