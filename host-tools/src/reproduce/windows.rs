//! What a payload window of a given length is worth: its worst start, as Fig. 12 of the paper has it, and all of them.

use super::contender::{Fitted, Log};
use crate::error::Result;
use crate::estimate::WindowMass;
use crate::metrics::{Metrics, Quality};

/// One method at one window on one log.
#[derive(Debug, Clone, Copy)]
pub(super) struct AtWindow {
    /// Mass error of the worst window of each payload, mean of the payloads, %.
    pub(super) worst_mass_percent: f64,
    /// Mass error of all windows, %.
    pub(super) mean_mass_percent: f64,
    /// Of the power predicted with the worst windows' masses, %.
    pub(super) mape_percent: f64,
    /// Of the power predicted with the worst windows' masses.
    pub(super) r2: f64,
    /// Share of windows whose mass is known.
    pub(super) known_share: f64,
}

/// Step two done once a payload, at the worst moment; step three with that mass until the payload changes.
pub(super) fn at_window(fitted: &Fitted<'_>, log: &Log, window_s: f64, floor_w: f64) -> Result<AtWindow> {
    // Every window is judged by itself: nothing restarts it.
    let (replayed, _) = fitted.follow(log, &super::contender::moving(window_s, false))?;
    let mut metrics = Metrics::new(floor_w);
    let (mut worst_sum, mut all, mut inside) = (0.0, Vec::new(), 0);
    let tasks = log.tasks();
    for task in &tasks {
        let within = |window: &&WindowMass| window.truth_kg == Some(task.mass_kg);
        let windows: Vec<&WindowMass> = replayed.windows.iter().filter(within).collect();
        inside += windows.len();
        let error = |mass: f64| 100.0 * (mass / task.mass_kg - 1.0).abs();
        let masses: Vec<f64> = windows.iter().filter_map(|window| window.mass_kg).collect();
        all.extend(masses.iter().map(|mass| error(*mass)));
        let worst = masses.into_iter().max_by(|a, b| error(*a).total_cmp(&error(*b))).unwrap_or(f64::NAN);
        worst_sum += error(worst);
        for row in &log.rows[task.from..task.to] {
            let predicted = fitted.power(row, worst);
            if predicted.is_finite() {
                metrics.add(row.power, predicted);
            }
        }
    }
    let Quality { r2, mape_percent, .. } = metrics.quality().unwrap_or(NO_QUALITY);
    Ok(AtWindow {
        worst_mass_percent: worst_sum / tasks.len() as f64,
        mean_mass_percent: all.iter().sum::<f64>() / all.len() as f64,
        mape_percent: mape_percent.unwrap_or(f64::NAN),
        r2: r2.unwrap_or(f64::NAN),
        known_share: all.len() as f64 / inside as f64,
    })
}

/// Of a method that never knew.
pub(super) const NO_QUALITY: Quality = Quality {
    r2: None,
    mape_percent: None,
    mape_floor_w: 0.0,
    mape_share: 0.0,
    rmse_w: f64::NAN,
    samples: 0,
};
