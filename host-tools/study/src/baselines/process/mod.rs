//! Quann 2020: Gaussian-process regression of the power over the robot's motion.
//!
//! The power is the longitudinal dynamics of [`super::longitudinal`], fitted by least squares. A
//! Gaussian process models the residual over v, ω, v̇ and the road grade: squared-exponential
//! kernel, a length for each input, and noise. The source has place and terrain among the inputs;
//! logs have neither. Lengths and noise maximise the log marginal likelihood of a part of the
//! training; the process is exact, on at most 1000 points of it.

mod kernel;
mod search;

use support::error::{Error, Result};

use self::kernel::{Hyper, INPUTS, Process};
use super::baseline::{Baseline, Parameter, named};
use super::longitudinal::{SYMBOLS, TERMS, terms};
use super::point::Point;
use super::regression::{least_squares, rows, unfitted, weigh};
use super::training::evenly;

const NAME: &str = "quann";

/// Training points of the process, thinned evenly: time grows with their cube, and filtered
/// neighbours repeat each other.
pub const MOST_POINTS: usize = 1000;

/// Of them, those that lengths and noise are searched on: at each trial their cube again.
const SEARCHED_POINTS: usize = 200;

/// Longitudinal dynamics and a Gaussian process about them.
#[derive(Debug, Clone, Default)]
pub struct GaussianProcess {
    fitted: Option<Fitted>,
}

#[derive(Debug, Clone)]
struct Fitted {
    mean: [f64; TERMS],
    scaling: Scaling,
    /// Of the mean's residuals; `None` if they are only rounding.
    process: Option<Process>,
}

impl Baseline for GaussianProcess {
    fn fit(&mut self, training: &[Point]) -> Result<()> {
        self.fitted = None;
        let failed = |what: &str| Error::failed(format!("{NAME}: {what} has no finite solution"));
        let rows = rows(NAME, training, terms)?;
        if let Some(index) =
            training.iter().position(|point| !quantities(point).iter().all(|x| x.is_finite()))
        {
            return Err(Error::failed(format!(
                "{NAME}: training point {index} moves by {:?} (v, ω, v̇, grade); expected finite numbers",
                quantities(&training[index])
            )));
        }
        let mean: [f64; TERMS] = least_squares(&rows)
            .and_then(|mean| mean.try_into().ok())
            .ok_or_else(|| failed("the regression of the mean"))?;
        let scaling = Scaling::new(training);
        let samples: Vec<_> = evenly(training.len(), MOST_POINTS)
            .map(|index| (scaling.apply(&training[index]), rows[index].1 - weigh(&rows[index].0, &mean)))
            .collect();
        let square = |values: &mut dyn Iterator<Item = f64>| values.map(|value| value * value).sum::<f64>();
        let unexplained = square(&mut samples.iter().map(|(_, residual)| *residual)) / samples.len() as f64;
        let power = square(&mut rows.iter().map(|(_, power)| *power)) / rows.len() as f64;
        // A millionth of the power: rounding of a mean that explains all.
        let process = if unexplained > 1e-12 * power {
            let searched: Vec<_> =
                evenly(samples.len(), SEARCHED_POINTS).map(|index| samples[index]).collect();
            let hyper = search::most_likely(&searched, scaling.changing());
            Some(Process::new(&samples, hyper).ok_or_else(|| failed("the covariance of the points"))?)
        } else {
            None
        };
        self.fitted = Some(Fitted { mean, scaling, process });
        Ok(())
    }

    /// Its mean; far from all training points that of the longitudinal dynamics.
    fn predict(&self, points: &[Point]) -> Result<Vec<f64>> {
        let Fitted { mean, scaling, process } = self.fitted.as_ref().ok_or_else(|| unfitted(NAME))?;
        let predict = |point: &Point| {
            let inputs = scaling.apply(point);
            // The kernel would forget all samples for an infinite input, and answer with the mean.
            if !inputs.iter().all(|input| input.is_finite()) {
                return f64::NAN;
            }
            weigh(&terms(point), mean) + process.as_ref().map_or(0.0, |process| process.mean(&inputs))
        };
        Ok(points.iter().map(predict).collect())
    }

    /// Of the mean, then lengths of the inputs that change, and the spread of process and noise.
    fn parameters(&self) -> Vec<Parameter> {
        let Some(Fitted { mean, scaling, process }) = &self.fitted else { return Vec::new() };
        let mut parameters = named(SYMBOLS, mean);
        if let Some(process) = process {
            let Hyper { lengths, .. } = process.hyper();
            for (place, (name, unit)) in LENGTHS.into_iter().enumerate() {
                if scaling.changing()[place] {
                    parameters.push(Parameter { name, value: lengths[place] * scaling.spread[place], unit });
                }
            }
            let (signal, noise) = process.spreads();
            parameters.push(Parameter { name: "signal", value: signal, unit: "W" });
            parameters.push(Parameter { name: "noise", value: noise, unit: "W" });
        }
        parameters
    }
}

const LENGTHS: [(&str, &str); INPUTS] =
    [("length of v", "m/s"), ("length of ω", "rad/s"), ("length of v̇", "m/s²"), ("length of γ", "rad")];

/// v, ω, v̇, road grade.
fn quantities(point: &Point) -> [f64; INPUTS] {
    [point.speed.vx, point.speed.omega, point.acceleration.vx, point.grade()]
}

/// Inputs in standard deviations, so that one search fits robots of any size.
#[derive(Debug, Clone, Copy)]
struct Scaling {
    spread: [f64; INPUTS],
}

impl Scaling {
    fn new(points: &[Point]) -> Self {
        let spread = std::array::from_fn(|place| {
            let values = points.iter().map(|point| quantities(point)[place]);
            let mean = values.clone().sum::<f64>() / points.len() as f64;
            (values.map(|value| (value - mean).powi(2)).sum::<f64>() / points.len() as f64).sqrt()
        });
        Self { spread }
    }

    /// By more than a millionth of an SI unit.
    fn changing(&self) -> [bool; INPUTS] {
        self.spread.map(|spread| spread > 1e-6)
    }

    /// 0 where the training does not change, but for what is not finite.
    fn apply(&self, point: &Point) -> [f64; INPUTS] {
        let (quantities, changing) = (quantities(point), self.changing());
        std::array::from_fn(|place| {
            if changing[place] { quantities[place] / self.spread[place] } else { quantities[place] * 0.0 }
        })
    }
}

#[cfg(test)]
mod tests;
