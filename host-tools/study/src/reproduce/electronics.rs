//! Consumption of the board's parts, by their data sheets, and of the estimators, by the bench's
//! count of instructions.
//!
//! I²C traffic is left out: a sample reads two registers of a sensor, 90 bits or 0.23 ms at 400
//! kHz, during half of which a line is low and its pull-up of 4.7 kΩ draws 2.3 mW. At 200 Hz and
//! for two lines that is 0.1 mW, a thirtieth of what the sensor draws, and at 20 Hz a tenth of
//! that.

use plant::experiment;
use serde::Serialize;
use support::error::{Error, Result};

/// Supply of sensors and core, V.
const SUPPLY_V: f64 = 3.3;

/// Supply current of an INA219 that converts continuously, A (TI SBOS448G, Section 7.5: typically
/// 0.7 mA, at most 1 mA).
const SENSOR_SUPPLY_A: f64 = 0.7e-3;

/// Rail that the sensor's inputs hang on, V: the motors'.
const RAIL_V: f64 = experiment::SUPPLY_V;

/// Current into the inputs of an INA219 that converts, A (SBOS448G, Section 7.5): 20 µA into IN+,
/// and 20 µA beside 320 kΩ into IN−.
const SENSOR_INPUT_A: f64 = 20e-6 + 20e-6 + RAIL_V / 320e3;

/// Sensors needed to estimate the mass: one, in the motors' rail. The paper's robot has four (Fig.
/// 8); battery, computer and lidar show nothing of the payload.
const SENSORS: f64 = 1.0;

/// Shunt of the usual INA219 module, Ω.
pub(super) const SHUNT_OHM: f64 = 0.1;

/// Supply current of the core, A: STM32F746 (ST DS10916), run mode from ITCM RAM, regulator on, 216
/// MHz, peripherals off, typical at 25 °C.
const CORE_A: f64 = 0.102;

/// The core's clock, Hz.
const CORE_HZ: f64 = 216e6;

/// Instructions a cycle: an assumption. The Cortex-M7 issues up to two; waiting for memory and for
/// the divider takes some of that back.
const INSTRUCTIONS_PER_CYCLE: f64 = 1.0;

/// Energy of an instruction, J: its share of all that the running core draws.
pub(super) const INSTRUCTION_J: f64 = SUPPLY_V * CORE_A / CORE_HZ / INSTRUCTIONS_PER_CYCLE;

/// Power of the running sensors, W.
pub(super) fn sensors_w() -> f64 {
    SENSORS * (SUPPLY_V * SENSOR_SUPPLY_A + RAIL_V * SENSOR_INPUT_A)
}

/// The bench's counts, committed: the bench reports a difference.
const COUNTED: &str = include_str!("../../../../docs/results/instructions.txt");

/// Instructions of one estimator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(super) struct Counts {
    /// Of a sample, the median.
    pub(super) sample: u32,
    /// Of a sample that closes a bucket of one second, the median.
    pub(super) closing: u32,
}

impl Counts {
    /// Of the estimator that the bench calls `name`, such as `signed window, 32 buckets`.
    ///
    /// # Errors
    /// The bench's file does not name it, or not in full.
    pub(super) fn of(name: &str) -> Result<Self> {
        Self::read(COUNTED, name)
    }

    fn read(text: &str, name: &str) -> Result<Self> {
        let line = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(": "));
        let words: Vec<&str> = line.unwrap_or_default().split_whitespace().collect();
        let figure = |what: &str| {
            let at = words.iter().position(|word| *word == what)?;
            words.get(at + 1)?.parse().ok()
        };
        match (figure("median"), figure("closing")) {
            (Some(sample), Some(closing)) => Ok(Self { sample, closing }),
            _ => Err(Error::failed(format!(
                "docs/results/instructions.txt: no counts of `{name}`; expected a line `{name}: median … closing …`"
            ))),
        }
    }

    /// Instructions a sample on average, at `rate_hz` samples a second of which one closes a
    /// bucket.
    pub(super) fn per_sample(&self, rate_hz: f64) -> f64 {
        let sample = f64::from(self.sample);
        sample + (f64::from(self.closing) - sample) / rate_hz
    }
}

#[cfg(test)]
mod tests {
    use super::Counts;

    const TEXT: &str = "# what\nsigned window, 32 buckets: median 100 p95 2 closing 300 closing-worst 4 worst 5\nother: median 7\n";

    #[test]
    fn reads_the_benchs_lines() {
        let counts = Counts::read(TEXT, "signed window, 32 buckets").unwrap();
        assert_eq!(counts, Counts { sample: 100, closing: 300 });
        // 100 + 200 ∕ 200 samples.
        assert_eq!(counts.per_sample(200.0), 101.0);
    }

    #[test]
    fn what_is_not_there_is_named() {
        for name in ["other", "signed window"] {
            let error = Counts::read(TEXT, name).unwrap_err().to_string();
            assert!(error.contains(&format!("`{name}`")), "{error}");
        }
    }
}
