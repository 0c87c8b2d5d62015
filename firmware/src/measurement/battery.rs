//! How full the battery is, by the rail that carries everything it delivers.

use model_core::charge::{Gauge, Start};

use super::BatterySnapshot;
use crate::parameters::{RAILS, battery_pack};
use crate::power_sensors::RailReading;
use crate::time::seconds;

/// Below, there is no battery but a board on USB alone, V.
const NONE_V: f32 = 5.0;
/// A sensor that has said nothing for so long leaves the charge unknown, µs: the gauge calls it a
/// gap, in which nobody counted.
const SILENCE_US: u64 = 10_000_000;
/// How often what is known is worked out anew, µs: the gauge's own step.
const LOOK_US: u64 = 1_000_000;

/// The gauge behind the battery's sensor. It sees the pack with the sensor's shunt, as everything
/// else on the board does: what remains is what arrives there.
#[derive(Debug, Clone, PartialEq)]
pub struct BatteryMeter {
    gauge: Gauge<f32>,
    /// When the sensor spoke last, µs since start.
    heard_us: Option<u64>,
    looked_us: u64,
    known: BatterySnapshot,
}

impl Default for BatteryMeter {
    fn default() -> Self {
        Self::new()
    }
}

impl BatteryMeter {
    /// Nothing known of the charge: nobody has seen the battery since it was charged.
    #[must_use]
    pub fn new() -> Self {
        Self {
            gauge: Gauge::new(battery_pack(), Start::Unknown),
            heard_us: None,
            looked_us: 0,
            known: BatterySnapshot::UNKNOWN,
        }
    }

    /// A sample at `time_us` since start, with what the battery's sensor says anew.
    pub fn update(&mut self, reading: Option<RailReading>, time_us: u64) {
        let Some(reading) = reading else {
            if self.heard_us.is_some_and(|heard| time_us.saturating_sub(heard) > SILENCE_US) {
                self.known = BatterySnapshot::UNKNOWN;
            }
            return;
        };
        if reading.voltage < NONE_V {
            // The next one may be another.
            *self = Self::new();
            return;
        }
        if let Some(heard) = self.heard_us.replace(time_us) {
            // The calibrated current: the shunt's tolerance is in the power's factor.
            let current = reading.power / reading.voltage;
            self.gauge.update(current, reading.voltage, seconds(time_us.saturating_sub(heard)));
        }
        if time_us.saturating_sub(self.looked_us) >= LOOK_US {
            self.looked_us = time_us;
            self.known = self.look();
        }
    }

    fn look(&self) -> BatterySnapshot {
        let [battery, ..] = RAILS;
        let resistance = self.gauge.resistance().filter(|resistance| resistance.at_once > battery.shunt.ohm);
        BatterySnapshot {
            charge: self.gauge.charge(),
            resistance: resistance.map(|resistance| (resistance.at_once - battery.shunt.ohm, resistance.std)),
            remaining: self.gauge.remaining(),
        }
    }

    /// What is known, by the last second.
    #[must_use]
    pub const fn known(&self) -> BatterySnapshot {
        self.known
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_US: u64 = 5_000;

    fn reading(current: f32, voltage: f32) -> Option<RailReading> {
        Some(RailReading { voltage, current, power: current * voltage })
    }

    /// Samples for so many seconds; gives the time behind them.
    fn run(meter: &mut BatteryMeter, from_us: u64, for_s: u64, reading: Option<RailReading>) -> u64 {
        let end = from_us + for_s * 1_000_000;
        (from_us..end).step_by(PERIOD_US as usize).for_each(|time_us| meter.update(reading, time_us));
        end
    }

    /// At the curve's voltage for 60 %, at rest.
    fn resting() -> Option<RailReading> {
        reading(0.0, 3.0 * battery_pack().curve.voltage(0.6))
    }

    #[test]
    fn a_rested_battery_is_as_full_as_its_voltage_says() {
        let mut meter = BatteryMeter::new();
        assert_eq!(meter.known(), BatterySnapshot::UNKNOWN);
        run(&mut meter, 0, 300, resting());
        let charge = meter.known().charge.unwrap();
        assert!((charge.share - 0.6).abs() < 0.03 && charge.std < 0.05, "{charge:?}");
        // Nothing is drawn: no time, and no resistance.
        assert_eq!(meter.known().remaining.unwrap().time, None);
        assert_eq!(meter.known().resistance, None);
    }

    /// 1 A for ten minutes of 1.8 A·h are 9.3 points; what remains lasts as long as the load says.
    #[test]
    fn what_is_drawn_is_counted() {
        let mut meter = BatteryMeter::new();
        let time_us = run(&mut meter, 0, 300, resting());
        let before = meter.known().charge.unwrap().share;
        run(&mut meter, time_us, 600, reading(1.0, resting().unwrap().voltage - 0.25));
        let known = meter.known();
        let gone = before - known.charge.unwrap().share;
        assert!((gone - 600.0 / (1.8 * 3600.0)).abs() < 0.03, "{gone}");
        let remaining = known.remaining.unwrap();
        let load = resting().unwrap().voltage - 0.25;
        assert!((remaining.load - load).abs() < 0.05, "{remaining:?}");
        assert!((remaining.time.unwrap() * load / remaining.energy - 1.0).abs() < 0.01, "{remaining:?}");
    }

    /// A sensor's shunt is none of the pack's resistance: 0.3 Ω behind the sensor are 0.2 Ω of the
    /// pack.
    #[test]
    fn the_shunt_is_not_the_packs() {
        let mut meter = BatteryMeter::new();
        let rest = resting().unwrap().voltage;
        let mut time_us = run(&mut meter, 0, 60, resting());
        for _ in 0..20 {
            time_us = run(&mut meter, time_us, 10, reading(1.0, rest - 0.3));
            time_us = run(&mut meter, time_us, 10, reading(0.0, rest));
        }
        let (resistance, std) = meter.known().resistance.unwrap();
        assert!((resistance - 0.2).abs() < 3.0 * std && std < 0.1, "{resistance} {std}");
    }

    #[test]
    fn a_silent_sensor_and_a_missing_battery_leave_it_unknown() {
        let mut meter = BatteryMeter::new();
        let time_us = run(&mut meter, 0, 300, resting());
        let known = meter.known();
        let time_us = run(&mut meter, time_us, 10, None);
        assert_eq!(meter.known(), known);
        let time_us = run(&mut meter, time_us, 1, None);
        assert_eq!(meter.known(), BatterySnapshot::UNKNOWN);
        // Back: what was known still counts, less certain for the gap.
        let time_us = run(&mut meter, time_us, 2, resting());
        assert!((meter.known().charge.unwrap().share - 0.6).abs() < 0.03);
        let time_us = run(&mut meter, time_us, 1, reading(0.0, 0.2));
        assert_eq!(meter.known(), BatterySnapshot::UNKNOWN);
        // Another battery, emptier by a third.
        run(&mut meter, time_us, 300, reading(0.0, 3.0 * battery_pack().curve.voltage(0.2)));
        assert!((meter.known().charge.unwrap().share - 0.2).abs() < 0.03, "{:?}", meter.known());
    }
}
