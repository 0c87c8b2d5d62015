//! The battery as the stock firmware sees it: by its voltage alone.

/// Below, the motors' supply is cut, V.
const CUT_V: f32 = 11.0;
/// With the motors off the voltage rises: they come back above, V.
const BACK_V: f32 = 11.3;
/// Below, there is no battery but a board on USB alone, V.
const NONE_V: f32 = 5.0;
/// How long it has to last, µs.
const LASTING_US: u64 = 6_000_000;
/// Of the mean over the voltage, per look: about ten looks.
const SHARE: f32 = 0.1;

/// Percentage of the stock firmware: 10.5 V are 0, 12.3 V are 100, in between straight; not beyond.
#[must_use]
pub fn battery_percent(voltage: f32) -> f32 {
    ((voltage - 10.5) / 1.8 * 100.0).clamp(0.0, 100.0)
}

/// Cuts the motors off before the battery is harmed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BatteryGuard {
    mean: Option<f32>,
    /// Since when it has been too low, µs since start.
    low_us: Option<u64>,
    is_cut: bool,
}

impl BatteryGuard {
    /// Nothing measured.
    pub const NEW: Self = Self { mean: None, low_us: None, is_cut: false };

    /// Whether the motors' supply has to be off, by this voltage measured `now_us` since start.
    /// What is not known changes nothing.
    pub fn look(&mut self, voltage: Option<f32>, now_us: u64) -> bool {
        let Some(voltage) = voltage else { return self.is_cut };
        let mean = self.mean.map_or(voltage, |mean| mean + SHARE * (voltage - mean));
        self.mean = Some(mean);
        if !(NONE_V..CUT_V).contains(&mean) {
            self.low_us = None;
            self.is_cut &= mean <= BACK_V;
        } else {
            let since = *self.low_us.get_or_insert(now_us);
            self.is_cut |= now_us.saturating_sub(since) >= LASTING_US;
        }
        self.is_cut
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentage_is_the_stock_firmwares_but_ends_at_its_ends() {
        for (voltage, percent) in [(10.5, 0.0), (11.4, 50.0), (12.3, 100.0), (12.6, 100.0), (9.0, 0.0)] {
            assert!((battery_percent(voltage) - percent).abs() < 1e-3, "{voltage}");
        }
    }

    /// What the gauge calls empty is what this cuts off at.
    #[test]
    fn the_cut_is_the_packs_end() {
        assert_eq!(crate::parameters::battery_pack().cutoff, CUT_V);
    }

    /// Looked at every 20 ms: at 10.9 V from 1 s on, when the mean has followed for 0.5 s.
    #[test]
    fn a_low_battery_cuts_the_motors_after_six_seconds() {
        let mut guard = BatteryGuard::NEW;
        // When it first cut, of a stretch at one voltage.
        let mut at = |from_ms: u64, to_ms: u64, voltage: f32| {
            let looks = (from_ms..to_ms).step_by(20);
            let cuts: Vec<u64> = looks.filter(|ms| guard.look(Some(voltage), 1000 * ms)).collect();
            (cuts.first().copied(), cuts.last().copied())
        };
        assert_eq!(at(0, 1000, 12.0), (None, None));
        let (cut, _) = at(1000, 20_000, 10.9);
        assert!((7000..7800).contains(&cut.unwrap()), "{cut:?}");
        // Without load it rises, but not enough; a charged one does.
        assert_eq!(at(20_000, 21_000, 11.2), (Some(20_000), Some(20_980)));
        assert!(at(21_000, 22_000, 12.0).1.unwrap() < 21_200);
        // A dip of three seconds does nothing.
        assert_eq!(at(40_000, 43_000, 10.5), (None, None));
        assert_eq!(at(43_000, 50_000, 12.0), (None, None));
        // No battery at all: nothing to protect.
        assert_eq!(at(60_000, 80_000, 0.3), (None, None));
    }
}
