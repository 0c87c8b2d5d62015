//! How the wheel speed is read: exactly, from encoder ticks, or from the servo's velocity register.

use std::f64::consts::TAU;

use serde::Serialize;

/// Encoder ticks per wheel revolution (XL430 e-manual, Present Position 132: 0 … 4095 per
/// revolution).
pub const TICKS_PER_REVOLUTION: f64 = 4096.0;

/// One count of the servo's velocity register, rad/s (XL430 e-manual, Present Velocity 128: 0.229
/// rev/min).
pub const VELOCITY_COUNT: f64 = 0.229 * TAU / 60.0;

/// Where wheel speeds come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum SpeedSource {
    /// The true speed at the time of the sample.
    Exact,
    /// Encoder ticks since the last sample, over the time between them.
    Encoder,
    /// The servo's velocity register, in steps of 0.229 rev/min.
    Register,
}

/// Position in whole encoder ticks.
pub fn ticks(angle_rad: f64) -> i64 {
    (angle_rad / TAU * TICKS_PER_REVOLUTION).floor() as i64
}

/// Mean speed, rad/s, of a number of ticks within a time, s.
pub fn speed_from_ticks(ticks: i64, time_s: f64) -> f64 {
    ticks as f64 * TAU / TICKS_PER_REVOLUTION / time_s
}

/// Speed, rad/s, as the servo's register gives it: the nearest count.
pub fn register_speed(speed: f64) -> f64 {
    (speed / VELOCITY_COUNT).round() * VELOCITY_COUNT
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_tick_in_five_milliseconds_is_0_307_rad_per_s() {
        // 2π / 4096 / 0.005 s = 0.30680 rad/s
        assert!((speed_from_ticks(1, 0.005) - 0.306_796).abs() < 1e-6);
        assert_eq!(ticks(-1e-9), -1);
        assert_eq!(ticks(TAU * 1.5), 6144);
    }

    #[test]
    fn the_register_steps_by_0_229_rev_per_min() {
        // 0.229 rev/min = 0.0239808 rad/s; half a step above zero still reads 0.
        assert_eq!(register_speed(0.0119), 0.0);
        assert!((register_speed(0.0121) - 0.023_980_8).abs() < 1e-7);
        assert!((register_speed(-6.0) + 250.0 * 0.023_980_824).abs() < 1e-6);
    }
}
