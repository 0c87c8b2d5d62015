//! The experiment's regime for a reader: its settings, its distance from the published figures, and
//! its rails.

use plant::Rounds;
use plant::experiment::{self, REGIME, RailReading};
use support::error::Result;

use super::section7::{ModelRow, PUBLISHED};
use super::spread::Spread;
use super::table::{Cell, Column, Format, Mark, Row, Table, column, number, with_unit};
use super::windows::{PUBLISHED_WORST, WindowRow};

const KNOBS: [Column; 3] = [
    column("name", "knob", Format::Words),
    column("value", "value", Format::Words),
    column("reason", "why", Format::Words),
];

/// Settings where the paper is silent, and why.
pub(super) fn knobs() -> Table {
    let rows = [
        ["drives", "servo plant: XL430 by its published figures, 12 V", "the robot of the experiment"],
        [
            "sampling",
            &format!("{} Hz, {} s a drive", REGIME.rate_hz, REGIME.duration_s),
            "Section 7: about 20 Hz; the length is not stated",
        ],
        ["payload", "training 1 kg, then 6 kg; test 3 kg, then 4 kg (total)", "Section 7.1"],
        [
            "speeds as read",
            &format!("servo register of 0.229 rev/min, white noise of {} rad/s", REGIME.speed_noise_rad_s),
            "from odometry messages; their noise is not stated",
        ],
        [
            "power as read",
            &format!("INA219, 16 averages, white noise of {} W", REGIME.power_noise_w),
            "Section 7: 0.2 % after calibration; the averages are not stated",
        ],
        [
            "rolling resistance",
            &REGIME.rolling_resistance.to_string(),
            "sets how much a kilogram shows at constant speed, and with it the mass errors",
        ],
        [
            "training drive",
            &rounds(&REGIME.training),
            "legs in reverse and on the spot set the regression's error",
        ],
        [
            "test drive",
            &rounds(&REGIME.test),
            "brisk changes of speed set the error of Eq. 18, curves beyond the training's that of the perceptron",
        ],
    ];
    Table {
        name: "knobs",
        title: "Section 7: how the experiment's regime was set",
        columns: &KNOBS,
        rows: rows.map(|cells| Row::new(Mark::None, cells.map(Cell::from))).to_vec(),
        note: "set so that the paper's method and its two comparisons land near their published figures (docs/paper.md says how)".to_owned(),
    }
}

fn rounds(rounds: &Rounds) -> String {
    let Rounds { speed, curve, hold_s, acceleration_m_s2, shares } = rounds;
    // To a tenth of a percent, without rounding errors.
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

const NEARNESS: [Column; 5] = [
    column("what", "figure", Format::Words),
    column("published", "published", Format::AsShown),
    column("here", "the same method here", Format::AsShown),
    column("ours", "ours on the same logs", Format::AsShown),
    column("unit", "", Format::Words),
];

/// Published figures, what the same method has here, and ours on the same logs.
pub(super) fn nearness(windows: &[WindowRow], models: &[ModelRow], share_known: &Spread) -> Table {
    let row = |what: String, published: f64, here: Spread, ours: Spread, unit: &str| {
        let digits = if unit.is_empty() { 3 } else { 2 };
        let figure = |spread: Spread| Cell::shown(serde_json::json!(spread), spread.figure(unit, digits));
        let published = Cell::shown(published, with_unit(number(published, digits), unit));
        Row::new(Mark::None, [what.into(), published, figure(here), figure(ours), unit.into()])
    };
    let mut rows = Vec::new();
    for (name, (mape, r2)) in PUBLISHED {
        let here = models.iter().find(|row| row.name == name);
        if let (Some(here), Some(ours)) = (here, models.first()) {
            let ([mape_here, r2_here, ..], [our_mape, our_r2, ..]) = (here.quality, ours.quality);
            rows.push(row(format!("{name}, 25 s: MAPE"), mape, mape_here, our_mape, "%"));
            rows.push(row(format!("{name}, 25 s: R²"), r2, r2_here, our_r2, ""));
        }
    }
    for [window_s, mass, mape, r2] in PUBLISHED_WORST {
        let figures = |method: &str| {
            windows.iter().find(|row| row.window_s == window_s && row.method == method).map(|row| row.figures)
        };
        let (Some(here), Some(ours)) = (figures("eq18-published"), figures("signed")) else { continue };
        let figures = [("mass error", mass, 0, "%"), ("MAPE", mape, 2, "%"), ("R²", r2, 3, "")];
        for (of, published, place, unit) in figures {
            let what = format!("worst window of {window_s} s: {of}");
            rows.push(row(what, published, here[place], ours[place], unit));
        }
    }
    Table {
        name: "nearness",
        title: "Section 7: how near the regime comes to what was published",
        columns: &NEARNESS,
        rows,
        note: format!(
            "models are judged over {} % of the samples behind the first window: those at which all that have to find the mass know it",
            share_known.text(Format::Share(1))
        ),
    }
}

/// Powers of the rails over time (moving averages of 20 samples, as the paper's), and the static
/// power (Eq. 29).
#[derive(Debug, Clone, Default)]
pub(super) struct Rails {
    /// s
    pub(super) time_s: Vec<f64>,
    /// At the battery, of the motors, of all else, W.
    pub(super) powers_w: [Vec<f64>; 3],
    /// Fig. 9b: samples of the static power, not averaged, W.
    pub(super) static_samples_w: Vec<f64>,
    /// Their mean and standard deviation, W (Eq. 29).
    pub(super) gaussian_w: (f64, f64),
}

/// Samples in a moving average, as in Fig. 9.
const AVERAGED: usize = 20;

impl Rails {
    /// The training drive's, as INA219s in each of them would read it.
    pub(super) fn measure(seed: u64) -> Result<Self> {
        let readings = experiment::rails(seed)?;
        let all = |value: fn(&RailReading) -> f64| -> Vec<f64> { readings.iter().map(value).collect() };
        let idle = all(|reading| reading.static_w);
        let count = idle.len() as f64;
        let mean = idle.iter().sum::<f64>() / count;
        let variance = idle.iter().map(|power| (power - mean).powi(2)).sum::<f64>() / count;
        let powers = [all(|reading| reading.battery_w), all(|reading| reading.actuation_w), idle.clone()];
        Ok(Self {
            time_s: all(|reading| reading.time_s),
            powers_w: powers.map(|values| moving_average(&values)),
            static_samples_w: idle,
            gaussian_w: (mean, variance.sqrt()),
        })
    }
}

/// Of the last so many values; of fewer at the start.
fn moving_average(values: &[f64]) -> Vec<f64> {
    let average = |end: usize| {
        let window = &values[(end + 1).saturating_sub(AVERAGED)..=end];
        window.iter().sum::<f64>() / window.len() as f64
    };
    (0..values.len()).map(average).collect()
}
