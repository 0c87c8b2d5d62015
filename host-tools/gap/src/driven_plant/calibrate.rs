//! Calibrates a nominal plant to this robot: some physical parameters, fitted to runs without
//! effects.

use logs::robot::chassis::Chassis;
use logs::runs::RawRun;
use nalgebra::{DMatrix, DVector};
use plant::body::Wheel;
use serde_json::{Map, Value, json};
use support::error::Result;

use super::filter::PowerFilter;
use super::in_parallel;
use super::search::squares;
use super::track::{Followed, Follower};
use residuals::thresholds::driven_plant::{DELAY_STEP_ROWS, FIT_STEPS, LEAST_GAIN, NUDGE, TRUST};
use residuals::thresholds::problem::MOST_DELAY_ROWS;

/// A parameter that is fitted, the same for all wheels.
#[derive(Debug, Clone, Copy)]
struct Knob {
    /// Its name in the output, with its unit.
    name: &'static str,
    of: fn(&mut Wheel) -> &mut f64,
    /// The least and the greatest value.
    range: (f64, f64),
    /// Typical value, for sets with a value of zero.
    typical: f64,
}

/// Winding, friction, inertia and gear: makers' figures leave them open.
const KNOBS: [Knob; 6] = [
    Knob {
        name: "resistance_ohm",
        of: |wheel| &mut wheel.motor.resistance_ohm,
        range: (0.01, 100.0),
        typical: 1.0,
    },
    Knob { name: "coulomb_n_m", of: |wheel| &mut wheel.motor.coulomb, range: (0.0, 1.0), typical: 1e-4 },
    Knob { name: "viscous_n_m_s", of: |wheel| &mut wheel.motor.viscous, range: (0.0, 1.0), typical: 1e-7 },
    Knob {
        name: "rolling_resistance",
        of: |wheel| &mut wheel.rolling_resistance,
        range: (0.0, 0.5),
        typical: 0.02,
    },
    Knob {
        name: "rotor_inertia_kg_m2",
        of: |wheel| &mut wheel.motor.rotor_inertia,
        range: (1e-9, 1.0),
        typical: 1e-6,
    },
    Knob { name: "gear_efficiency", of: |wheel| &mut wheel.gear.efficiency, range: (0.1, 1.0), typical: 0.7 },
];

impl Follower {
    /// Fits the plant to runs without effects: Gauss–Newton on the filtered power, parameters per
    /// wheel type.
    ///
    /// # Errors
    /// As [`Follower::follow`].
    pub fn calibrate(&mut self, robot: &Chassis, runs: &[RawRun]) -> Result<()> {
        let filter = PowerFilter::new(robot, runs)?;
        let scales = KNOBS.map(|knob| {
            let nominal = *(knob.of)(&mut self.machine.wheels[0].clone());
            if nominal > 0.0 { nominal } else { knob.typical }
        });
        let mut best = self.try_on(robot, runs, &filter)?;
        for _ in 0..FIT_STEPS {
            let now = self.knobs();
            let mut slopes = Vec::new();
            for (place, (knob, scale)) in KNOBS.iter().zip(scales).enumerate() {
                let mut nudged = self.clone();
                // Into the range, whichever end the parameter may be at.
                let step = if now[place] + NUDGE * scale <= knob.range.1 { NUDGE } else { -NUDGE };
                nudged.set(place, now[place] + step * scale);
                let there = filter.residual(&nudged.power(robot, runs, self.delay_s)?)?;
                slopes.push(DVector::from_iterator(
                    best.residual.len(),
                    best.residual.iter().zip(&there).map(|(now, there)| (now - there) / step),
                ));
            }
            let Some(step) = self.step(&best.residual, &slopes, &now, &scales) else { break };
            let mut moved = None;
            for share in [1.0, 0.4, 0.1] {
                let mut tried = self.clone();
                for (place, by) in step.iter().enumerate() {
                    tried.set(place, now[place] + share * by * scales[place]);
                }
                let fit = tried.try_on(robot, runs, &filter)?;
                if fit.loss < best.loss {
                    moved = Some((tried, fit));
                    break;
                }
            }
            let Some((tried, fit)) = moved else { break };
            let gained = 1.0 - fit.loss / best.loss;
            (*self, best) = (tried, fit);
            if gained < LEAST_GAIN {
                break;
            }
        }
        Ok(())
    }

    /// The Gauss–Newton step in units of the scales. It holds to the set's values where the runs do
    /// not determine a parameter.
    fn step(
        &self,
        residual: &[f64],
        slopes: &[DVector<f64>],
        now: &[f64; KNOBS.len()],
        scales: &[f64; KNOBS.len()],
    ) -> Option<DVector<f64>> {
        let rows = residual.len() as f64;
        let variance = squares(residual) / rows;
        let size = KNOBS.len();
        let residual = DVector::from_column_slice(residual);
        let mut matrix = DMatrix::from_fn(size, size, |i, j| slopes[i].dot(&slopes[j]));
        let mut right = DVector::from_fn(size, |i, _| slopes[i].dot(&residual));
        let pull = variance / (TRUST * TRUST);
        for i in 0..size {
            matrix[(i, i)] += pull;
            right[i] -= pull * (now[i] / scales[i] - 1.0);
        }
        Some(matrix.cholesky()?.solve(&right))
    }

    /// Residual at the best delay, which the follower takes over.
    fn try_on(&mut self, robot: &Chassis, runs: &[RawRun], filter: &PowerFilter) -> Result<Fit> {
        let followed = self.follow_all(robot, runs)?;
        let period = runs.first().map_or(0.0, |run| run.period_s);
        let at = |delay: f64| -> Result<Fit> {
            let power: Vec<Vec<f64>> =
                runs.iter().zip(&followed).map(|(run, followed)| followed.power(run, delay)).collect();
            let residual = filter.residual(&power)?;
            Ok(Fit { loss: squares(&residual), residual })
        };
        let mut best = (self.delay_s, at(self.delay_s)?);
        // Downhill in ever finer steps.
        let mut step = 0.5 * period;
        while step >= DELAY_STEP_ROWS * period {
            for delay in [best.0 - step, best.0 + step] {
                if delay.abs() <= MOST_DELAY_ROWS * period {
                    let fit = at(delay)?;
                    if fit.loss < best.1.loss {
                        best = (delay, fit);
                    }
                }
            }
            step *= 0.5;
        }
        self.delay_s = best.0;
        Ok(best.1)
    }

    fn follow_all(&self, robot: &Chassis, runs: &[RawRun]) -> Result<Vec<Followed>> {
        in_parallel(runs, |_, run| self.follow(robot, run, &[]))
    }

    fn power(&self, robot: &Chassis, runs: &[RawRun], delay: f64) -> Result<Vec<Vec<f64>>> {
        let followed = self.follow_all(robot, runs)?;
        Ok(runs.iter().zip(&followed).map(|(run, followed)| followed.power(run, delay)).collect())
    }

    fn knobs(&self) -> [f64; KNOBS.len()] {
        let mut wheel = self.machine.wheels[0];
        KNOBS.map(|knob| *(knob.of)(&mut wheel))
    }

    fn set(&mut self, place: usize, value: f64) {
        let Knob { of, range: (low, high), .. } = KNOBS[place];
        for wheel in &mut self.machine.wheels {
            *of(wheel) = value.clamp(low, high);
        }
    }

    /// The fitted parameters, for people and scripts.
    pub fn parameters(&self) -> Map<String, Value> {
        let values = KNOBS.iter().zip(self.knobs()).map(|(knob, value)| (knob.name.to_owned(), json!(value)));
        values.chain([("lag_s".to_owned(), json!(self.delay_s))]).collect()
    }
}

struct Fit {
    loss: f64,
    residual: Vec<f64>,
}
