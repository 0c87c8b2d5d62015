//! What was true during a run of the virtual board, as a log.

use std::fmt::Write as _;

use super::lockstep::Truth;

/// Time between rows, µs: that of the board's samples.
pub const PERIOD_US: u64 = 5000;

/// The log's columns: those of a run log, `power_w` the drives' alone, and the rails.
pub const HEADER: &str = support::overwrite::TRUTH;

/// Rows of the log: speeds as they are, powers as means since the row before.
#[derive(Debug, Clone, Default)]
pub struct TruthRows {
    last: Option<Truth>,
}

impl TruthRows {
    /// Appends a row. Time to a microsecond, speeds to 1e-7 rad/s, power to a microwatt.
    pub fn push(&mut self, text: &mut String, truth: &Truth) {
        let Truth { time_us, wheel_rad_s: [left, right], mass_kg, actuation_w, rails, .. } = *truth;
        let (mut actuation, mut powers) = (actuation_w, rails.map(|rail| rail.power_w));
        if let Some(last) = self.last.filter(|last| last.time_us < time_us) {
            let seconds = (time_us - last.time_us) as f64 * 1e-6;
            actuation = (truth.actuation_j - last.actuation_j) / seconds;
            for (power, (now, before)) in powers.iter_mut().zip(truth.rails_j.iter().zip(last.rails_j)) {
                *power = (now - before) / seconds;
            }
        }
        self.last = Some(*truth);
        // Writing to a String cannot fail. Adding 0 makes a negative zero positive.
        let _ = write!(text, "{}.{:06}", time_us / 1_000_000, time_us % 1_000_000);
        let _ = write!(text, ",{:.7},{:.7},{:.6},{mass_kg}", left + 0.0, right + 0.0, actuation + 0.0);
        for power in powers {
            let _ = write!(text, ",{power:.6}");
        }
        let _ = writeln!(text, ",{:.6}", rails[0].voltage_v);
    }
}

#[cfg(test)]
mod tests {
    use plant::rails::Supply;

    use super::*;

    /// By hand: 2 J more after 0.5 s are 4 W.
    #[test]
    fn powers_are_means_since_the_row_before() {
        let supply = Supply { power_w: 1.5, voltage_v: 12.0 };
        let first = Truth { actuation_w: 1.0, mass_kg: 2.5, rails: [supply; 4], ..Truth::default() };
        let second = Truth { time_us: 500_000, actuation_j: 2.0, rails_j: [3.0; 4], ..first };
        let (mut rows, mut text) = (TruthRows::default(), String::new());
        rows.push(&mut text, &first);
        rows.push(&mut text, &second);
        let expected = "0.000000,0.0000000,0.0000000,1.000000,2.5,1.500000,1.500000,1.500000,1.500000,12.000000\n\
                        0.500000,0.0000000,0.0000000,4.000000,2.5,6.000000,6.000000,6.000000,6.000000,12.000000\n";
        assert_eq!(text, expected);
        assert_eq!(HEADER.split(',').count(), expected.lines().next().unwrap().split(',').count());
    }
}
