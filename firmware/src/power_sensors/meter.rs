//! What a rail has delivered.

use model_core::energy::Energy;

use super::{Reading, Shunt};
use crate::parameters::LONGEST_STEP_US;
use crate::time::seconds;

/// A reading in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RailReading {
    /// At the consumer's side of the shunt, V.
    pub voltage: f32,
    /// A; positive when the rail feeds its consumer.
    pub current: f32,
    /// W, calibrated; negative when the consumer feeds back.
    pub power: f32,
}

impl RailReading {
    /// Through this shunt.
    #[must_use]
    pub fn new(reading: Reading, shunt: Shunt) -> Self {
        Self { voltage: reading.bus_v(), current: reading.current_a(shunt), power: reading.power_w(shunt) }
    }
}

/// Counts a rail's energy: of whatever passes the shunt, either way.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Meter {
    energy: Energy<f32>,
    last_us: Option<u64>,
}

impl Meter {
    /// A reading taken at `time_us` since start. Its power counts since the one before, for a
    /// longest step at most: what a rail drew while nobody looked is not known.
    pub fn add(&mut self, power: f32, time_us: u64) {
        if let Some(last) = self.last_us {
            self.energy.add(power, seconds(time_us.saturating_sub(last).min(LONGEST_STEP_US)));
        }
        self.last_us = Some(time_us);
    }

    /// Delivered since start, J, less what its consumer fed back: what the battery gave and took.
    #[must_use]
    pub fn joules(&self) -> f32 {
        self.energy.joules()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2 W over 10 steps of 5 ms, 2 W more at the end of a gap of 1 s that counts for 25 ms, and 1
    /// W back for 5 ms: 0.145 J.
    #[test]
    fn counts_what_was_delivered_while_measured() {
        let mut meter = Meter::default();
        (0..=10).for_each(|i| meter.add(2.0, 5_000 * i));
        assert!((meter.joules() - 0.1).abs() < 1e-6);
        meter.add(2.0, 1_050_000);
        meter.add(-1.0, 1_055_000);
        assert!((meter.joules() - 0.145).abs() < 1e-6, "{}", meter.joules());
    }
}
