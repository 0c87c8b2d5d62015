//! The battery as the sensor sees it: voltage always, current and charge where it sits in the
//! battery's own wire.

use logs::robot::Robot;
use model_core::charge::{Charge, Gauge, Remaining, Resistance, Start};

use super::power::Reading;

/// Counts charge from readings.
#[derive(Debug, Clone)]
pub(super) struct Battery {
    gauge: Option<Gauge<f64>>,
    /// All that the battery gives flows through the sensor.
    sees_all: bool,
    /// Where nothing can be said of the charge: why.
    why_not: Option<&'static str>,
    last_s: Option<f64>,
}

impl Battery {
    /// Of a robot; its charge now, 0 to 1, if it is known.
    pub(super) fn new(robot: &Robot, charge: Option<Charge<f64>>) -> Self {
        let sees_all = robot.power_is_total();
        let start = charge.map_or(Start::Unknown, Start::Known);
        let why_not = match (sees_all, robot.battery()) {
            (false, _) => Some(
                "robot.toml has no static_power_w, so the sensor counts as in the motors' wire: the battery's current is unknown",
            ),
            (true, None) => Some("robot.toml has no [battery]"),
            (true, Some(_)) => None,
        };
        let gauge = robot.battery().filter(|_| sees_all).map(|pack| Gauge::new(*pack, start));
        Self { gauge, sees_all, why_not, last_s: None }
    }

    pub(super) fn add(&mut self, at_s: f64, reading: &Reading) {
        let elapsed = self.last_s.replace(at_s).map_or(0.0, |last| at_s - last);
        if let (Some(gauge), Some(current)) = (&mut self.gauge, reading.current_a()) {
            gauge.update(current, reading.voltage_v, elapsed);
        }
    }

    /// The battery's current, A, where this reading tells it.
    pub(super) fn current_a(&self, reading: &Reading) -> Option<f64> {
        reading.current_a().filter(|_| self.sees_all)
    }

    pub(super) fn charge(&self) -> Option<Charge<f64>> {
        self.gauge.as_ref()?.charge()
    }

    pub(super) fn remaining(&self) -> Option<Remaining<f64>> {
        self.gauge.as_ref()?.remaining()
    }

    pub(super) fn resistance(&self) -> Option<Resistance<f64>> {
        self.gauge.as_ref()?.resistance()
    }

    pub(super) fn why_not(&self) -> Option<&'static str> {
        self.why_not
    }
}
