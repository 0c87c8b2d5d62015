//! A user's simulator instead of a clean fit: what does it lack that the robot has?
//!
//! The signed model is fitted to the simulator, so that effects have torques to act on. Its error
//! on the simulator's own runs, like that on a robot's clean runs, is no gap. Where simulator and
//! robot went along the same drive, row by row, the difference of measured and simulated power
//! needs no model, and is reported, too.

pub mod export;

use std::path::PathBuf;

use fit::dataset::Reading;
use fit::pgd;
use logs::robot::chassis::Chassis;
use logs::robot::{PowerSource, Robot};
use logs::runs::{RawRun, Runs};
use logs::simulated;
use model::coefficients::{Method, ModelKind};
use model_core::eq18::Gate;
use model_core::model::Model;
use serde::Serialize;
use support::context::Context;
use support::error::{Error, Result};
use support::metrics::Quality;

use crate::report::Report;
use residuals::noise::whiten::Signal;
use residuals::types::Base;

/// Where a simulator's power is.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// Its logs; the measured ones where it is beside their power.
    pub files: Vec<PathBuf>,
    /// In which columns.
    pub columns: PowerSource,
    /// Whether its rows are those of the measured logs.
    pub paired: bool,
}

impl Source {
    /// Of separate logs.
    ///
    /// # Errors
    /// A log that cannot be read or has no power.
    pub fn of_logs(context: &Context, files: &[PathBuf], robot: &Robot) -> Result<Self> {
        let columns = simulated::of_simulator(context, files, robot.wheels())?;
        Ok(Self { files: files.to_owned(), columns, paired: false })
    }

    /// Beside the measured power of these logs; `None` where they know of no simulator.
    ///
    /// # Errors
    /// A log that cannot be read; logs that differ in what they have.
    pub fn beside(context: &Context, files: &[PathBuf], robot: &Robot) -> Result<Option<Self>> {
        let columns = simulated::beside(context, files, robot.wheels())?;
        Ok(columns.map(|columns| Self { files: files.to_owned(), columns, paired: true }))
    }
}

/// A simulator as the workflow takes it.
#[derive(Debug, Clone)]
pub struct Simulator {
    /// Where it comes from.
    pub source: Source,
    /// The robot with the filter that the measured logs need.
    pub chassis: Chassis,
    /// The model fitted to it.
    pub base: Base,
    /// How well that model explains its power.
    pub quality: Quality,
    /// Its runs as recorded.
    pub raw: Vec<RawRun>,
}

impl Simulator {
    /// Reads it, and fits the model to it. Logs without a mass are at `mass_kg`; `powers` as for
    /// [`Runs::raw`].
    ///
    /// # Errors
    /// A log that cannot be read or is not one of this robot; a simulator whose robot never moves.
    pub fn read(
        context: &Context,
        robot: &Robot,
        source: Source,
        field: &[PathBuf],
        mass_kg: f64,
        powers: &[String],
    ) -> Result<Self> {
        let simulated = robot.clone().with_power_from(source.columns);
        // Only measured power has noise: it decides the filter.
        let cutoff_hz = fit::choose_cutoff(context, robot, field, mass_kg)?;
        let reading = Reading { gate: Gate::Signed, cutoff_hz: Some(cutoff_hz), mass_kg };
        let dataset = fit::read(context, &simulated, &source.files, &reading)?;
        let fitted =
            fit::fit(&simulated, &dataset, ModelKind::Signed, Method::Physical, &pgd::Settings::default())?;
        let Model::Signed { torque, drive } = fitted.model else {
            return Err(Error::failed("the model fitted to the simulator has no torques"));
        };
        let base = Base {
            torque,
            covariance: Some(fitted.shared_covariance()),
            drive,
            masses_kg: fitted.masses.clone(),
            of_simulator: true,
        };
        let raw = Runs::raw(context, &simulated, &source.files, mass_kg, powers)?;
        Ok(Self { chassis: dataset.robot, base, quality: fitted.quality, raw, source })
    }

    /// Refuses another sample rate than the measured logs': the noise's autoregression counts rows.
    ///
    /// # Errors
    /// They are.
    pub fn check_rate(&self, runs: &Runs, clean: &Runs) -> Result<()> {
        if clean.is_as_fast_as(runs) {
            return Ok(());
        }
        let (simulated, measured) = (1.0 / clean.period_s, 1.0 / runs.period_s);
        let message = format!(
            "{simulated:.2} rows a second behind the filter, the measured logs have {measured:.2}; expected one sample rate: resample the simulator's log"
        );
        let mut error = Error::failed(message);
        if let Some(run) = self.raw.first() {
            error = error.in_file(&run.name);
        }
        Err(error)
    }

    /// What is reported of it for measured `runs`; `clean` are its own.
    pub fn told(&self, runs: &Runs, clean: &Runs, report: &Report) -> Told {
        Told {
            files: self.source.files.clone(),
            power_from: match self.source.columns {
                PowerSource::Measured => logs::POWER,
                PowerSource::Simulated => logs::SIM_POWER,
                PowerSource::SimulatedTorques => "sim_torqueN_nm",
            },
            model_r2: self.quality.r2,
            model_rmse_w: self.quality.rmse_w,
            difference: if self.source.paired { Difference::of(runs, clean, report) } else { None },
        }
    }
}

/// What is reported of a simulator.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Told {
    /// Its logs.
    pub files: Vec<PathBuf>,
    /// Column of its power.
    pub power_from: &'static str,
    /// R² of the model fitted to it, on it.
    pub model_r2: Option<f64>,
    /// Its residual there, W.
    pub model_rmse_w: f64,
    /// Without any model; `None` where the simulator has drives of its own.
    pub difference: Option<Difference>,
}

/// RMS of measured less simulated power over the locked runs, after the filter, W.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Difference {
    /// As the simulator is.
    pub before_w: f64,
    /// With the power of the named effects added; the same number where none stands.
    pub after_w: f64,
}

impl Difference {
    fn of(runs: &Runs, clean: &Runs, report: &Report) -> Option<Self> {
        let [before, after] = &report.confirmed.residuals;
        let (mut squares, mut count) = ([0.0; 2], 0.0);
        for (locked, &place) in report.split.locked.iter().enumerate() {
            let (measured, simulated) = (&runs.runs[place].rows, &clean.runs.get(place)?.rows);
            // If only one of them lacks rows, they are no pair.
            if measured.len() != simulated.len() {
                return None;
            }
            let residual = |signals: &Signal, row: usize| signals.get(locked)?.get(row).copied();
            for (row, (measured, simulated)) in measured.iter().zip(simulated.iter()).enumerate() {
                let difference = measured.power - simulated.power;
                let drawn = residual(before, row)? - residual(after, row)?;
                squares[0] += difference * difference;
                squares[1] += (difference - drawn).powi(2);
                count += 1.0;
            }
        }
        let [before_w, after_w] = squares.map(|sum: f64| (sum / count).sqrt());
        Some(Self { before_w, after_w: if report.verdict.stands() { after_w } else { before_w } })
    }
}

impl Told {
    /// A line for the terminal.
    pub fn line(&self) -> String {
        let r2 = self.model_r2.map_or_else(String::new, |r2| format!(", R² {r2:.4}"));
        let model = format!("the model of the simulator is off by {:.3} W of it{r2}", self.model_rmse_w);
        match self.difference {
            Some(Difference { before_w, after_w }) if before_w == after_w => {
                format!(
                    "Simulator: measured less simulated power {before_w:.3} W on the locked runs; {model}."
                )
            }
            Some(Difference { before_w, after_w }) => format!(
                "Simulator: measured less simulated power {before_w:.3} → {after_w:.3} W on the locked runs with what is named added; {model}."
            ),
            None => format!("Simulator: {model}."),
        }
    }
}
