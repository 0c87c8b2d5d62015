//! The knobs of the experiment's regime, as a reader is told them.

use super::study::Knob;
use crate::plant::Rounds;
use crate::plant::experiment::REGIME;

/// What is set where the paper is silent, and why.
pub(super) fn knobs() -> Vec<Knob> {
    let knob = |name, value, reason| Knob { name, value, reason };
    vec![
        knob(
            "drives",
            "servo plant: XL430 by its published figures, 12 V".to_owned(),
            "the robot of the experiment",
        ),
        knob(
            "sampling",
            format!("{} Hz, {} s a drive", REGIME.rate_hz, REGIME.duration_s),
            "Section 7: about 20 Hz; the length is not stated",
        ),
        knob("payload", "training 1 kg, then 6 kg; test 3 kg, then 4 kg (total)".to_owned(), "Section 7.1"),
        knob(
            "speeds as read",
            format!("servo register of 0.229 rev/min, white noise of {} rad/s", REGIME.speed_noise_rad_s),
            "from odometry messages; their noise is not stated",
        ),
        knob(
            "power as read",
            format!("INA219, 16 averages, white noise of {} W", REGIME.power_noise_w),
            "Section 7: 0.2 % after calibration; the averages are not stated",
        ),
        knob(
            "rolling resistance",
            format!("{}", REGIME.rolling_resistance),
            "sets how much a kilogram shows at constant speed, and with it the mass errors",
        ),
        knob(
            "training drive",
            rounds(&REGIME.training),
            "legs in reverse and on the spot set the regression's error",
        ),
        knob(
            "test drive",
            rounds(&REGIME.test),
            "brisk changes of speed set the error of Eq. 18, curves beyond the training's that of the perceptron",
        ),
    ]
}

fn rounds(rounds: &Rounds) -> String {
    let Rounds { speed, curve, hold_s, acceleration_m_s2, shares } = rounds;
    // To a tenth of a percent, without what rounding leaves behind.
    let percent = |share: f64| format!("{}", (1000.0 * share).round() / 10.0);
    let [spin, stop, reverse] = shares.map(percent);
    format!(
        "legs at {} to {} % of the top speed for {} to {} s, curves up to {} track widths⁻¹, changes at {} to {} m/s², on the \
         spot {spin} %, stops {stop} %, reverse {reverse} %",
        percent(speed.0),
        percent(speed.1),
        hold_s.0,
        hold_s.1,
        curve,
        acceleration_m_s2.0,
        acceleration_m_s2.1,
    )
}
