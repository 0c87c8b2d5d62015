//! Sets of runs from the plant: clean ones for the base, and field runs with hidden effects.

use logs::RawSample;
use logs::robot::Robot;
use logs::runs::{RawRun, Rows, Runs};
use model_core::model::Model;
use plant::effects::Effect;
use plant::effects::size::scale_to;
use plant::field::{Field, Noise};
use plant::{Scenario, simulate};
use support::error::{Error, Result};

use residuals::types::Base;

/// Length of a run, s.
pub const DURATION_S: f64 = 60.0;

/// Standard deviation of the power noise, W.
pub const NOISE_W: f64 = 0.05;

/// What `gmr fit` chooses for such runs, Hz.
pub const CUTOFF_HZ: f64 = 4.0;

/// A kind of noise and its name in tables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseKind {
    /// Its name.
    pub name: &'static str,
    /// The noise.
    pub noise: Noise,
}

/// The kinds that effect-free sets are made with.
pub fn noises() -> [NoiseKind; 4] {
    [
        NoiseKind { name: "white", noise: Noise::white(NOISE_W) },
        NoiseKind { name: "autocorrelated", noise: Noise::autocorrelated(NOISE_W, 0.6) },
        NoiseKind { name: "heavy-tailed", noise: Noise::heavy_tailed(NOISE_W) },
        NoiseKind { name: "heteroscedastic", noise: Noise::heteroscedastic(NOISE_W, 4.0) },
    ]
}

/// The sets: 6 clean runs, 12 in the field, 60 s at 20 Hz.
pub fn field(effects: &[Effect], noise: Noise) -> Field {
    Field { effects: effects.to_vec(), noise, ..Field::default() }
}

/// Runs the scenarios.
///
/// # Errors
/// What the plant refuses.
pub fn record(scenarios: &[Scenario], columns: &[&str]) -> Result<Vec<RawRun>> {
    let mut runs = Vec::new();
    for (place, scenario) in scenarios.iter().enumerate() {
        let record = simulate(&Scenario { step_s: STEP_S, ..scenario.clone() })?;
        let rows = (0..record.time_s.len()).map(|k| {
            let sample = RawSample {
                wheel_speed: [record.wheel_rad_s[0][k], record.wheel_rad_s[1][k]].into(),
                wheel_acceleration: None,
                power: record.power_w[k],
            };
            let value = |column: &&str| match *column {
                "pitch_rad" => record.pitch_rad[k],
                "cpu_percent" => record.cpu_percent[k],
                "motor1_temp_c" => record.motor_temp_c[0][k],
                "motor2_temp_c" => record.motor_temp_c[1][k],
                _ => f64::NAN,
            };
            (record.time_s[k], sample, record.mass_kg[k], columns.iter().map(value).collect())
        });
        runs.push(RawRun {
            name: format!("run {}", place + 1),
            rows: rows.collect(),
            columns: columns.iter().map(|&column| column.to_owned()).collect(),
            period_s: 1.0 / scenario.rate_hz,
        });
    }
    Ok(runs)
}

/// Integration step, s: half as fine as usual, twice as fast.
const STEP_S: f64 = 0.5e-3;

/// A base with the clean runs that it was fitted to.
#[derive(Debug, Clone)]
pub struct Clean {
    /// The fit.
    pub base: Base,
    /// Its runs.
    pub runs: Runs,
    /// Noise of mass estimates with the base.
    pub noise: model_core::payload::Noise<f64>,
}

/// Fits a base to clean runs as `gmr fit` does.
///
/// # Errors
/// What plant and fit refuse.
pub fn clean(robot: &Robot, seed: u64, noise: Noise, columns: &[&str]) -> Result<Clean> {
    let raw = record(&field(&[], noise).base(seed), columns)?;
    let fit = fit::of_runs(robot, &raw, CUTOFF_HZ)?;
    let Model::Signed { torque, drive } = fit.model else {
        return Err(Error::failed("the fit is not of the signed model"));
    };
    let base = Base {
        torque,
        covariance: Some(fit.shared_covariance()),
        drive,
        masses_kg: fit.masses,
        of_simulator: false,
    };
    Ok(Clean { base, runs: Runs::condition_to(&fit.robot, raw, Rows::Before)?, noise: fit.noise })
}

/// The effect scaled so that it adds `size` standard deviations of the noise to the power of the
/// field runs, or as near to that as its range allows.
///
/// # Errors
/// What the plant refuses.
pub fn scaled(effect: &Effect, size: f64, seed: u64) -> Result<Effect> {
    // Three runs suffice, and the others' payloads are not mislabelled.
    let mut runs: Vec<Scenario> = field(&[], Noise::white(NOISE_W)).field(seed);
    runs.truncate(3);
    for run in &mut runs {
        run.step_s = STEP_S;
    }
    match scale_to(effect, &runs, size * NOISE_W) {
        Ok(effect) => Ok(effect),
        Err(_) => {
            let (low, high) = effect.entry().range;
            let end = if effect.size() < 0.0 { low } else { high };
            // Loads on the edge lift a wheel.
            effect.clone().with_size(if effect.id() == "payload-offset" { 0.6 * end } else { end })
        }
    }
}
