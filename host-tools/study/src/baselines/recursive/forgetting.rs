//! The mass by recursive least squares with several forgetting factors (Vahidi, Stefanopoulou and
//! Peng 2005), and a robust form of it.
//!
//! The source estimates a vehicle's mass and a road's grade while it drives. The two change at
//! different paces: with one forgetting factor for both, the mass would drift or the grade lag.
//! Here the second parameter is the resistance of the ground:
//!
//! ```text
//! P = b + f |v| cos φ + M (v̇ + g sin φ) v,   M = c m
//! ```
//!
//! b and c are learned from the training, whose masses are known; f and M are tracked while
//! driving, each with its own memory. The update is the source's: the gain considers both, each
//! variance only its own parameter. The robust form bounds a residual at 1.345 times its usual size
//! (Huber 1964). The memories are chosen here: a payload stays for minutes, ground changes within
//! seconds.

use support::error::{Error, Result};

use crate::baselines::baseline::{Baseline, Parameter, named};
use crate::baselines::longitudinal::terms;
use crate::baselines::point::Point;
use crate::baselines::regression::{least_squares, rows, unfitted, weigh};

/// Memories of f and M, s.
const MEMORIES_S: [f64; 2] = [10.0, 60.0];

/// Huber's bound, in standard deviations: 95 % as efficient as least squares on normal residuals.
const BOUND: f64 = 1.345;

/// Largest variance, in variances of the noise: the limit of forgetting.
const DIFFUSE: f64 = 1e6;

/// Standard deviation over mean size of a normal value: √(π ∕ 2).
const STD_OF_MEAN_SIZE: f64 = 1.253_314_137_315_5;

/// Longitudinal dynamics with a mass that is estimated while driving.
#[derive(Debug, Clone, Copy)]
pub struct Forgetting {
    name: &'static str,
    robust: bool,
    fitted: Option<Fitted>,
}

/// What the training tells.
#[derive(Debug, Clone, Copy)]
struct Fitted {
    /// b, W.
    rest_w: f64,
    /// c: effective mass at the battery for each kilogram.
    per_kg: f64,
    start: State,
}

/// f in N and M in kg, with their variances, and the usual size of a residual, W.
#[derive(Debug, Clone, Copy)]
struct State {
    estimate: [f64; 2],
    variance: [f64; 2],
    spread_w: f64,
}

impl Forgetting {
    /// Not fitted.
    pub fn new(name: &'static str, robust: bool) -> Self {
        Self { name, robust, fitted: None }
    }

    /// Predicted power, W, and mass, kg, of every point, from the powers before it in its run.
    fn drive(&self, points: &[Point]) -> Result<Vec<(f64, f64)>> {
        let Fitted { rest_w, per_kg, start } = self.fitted.ok_or_else(|| unfitted(self.name))?;
        let mut estimates = Vec::with_capacity(points.len());
        for run in points.chunk_by(|a, b| a.run == b.run) {
            let (mut state, mut last) = (start, run[0].time);
            for point in run {
                let [one, rolling, inertial] = terms(point);
                let [f, effective] = state.estimate;
                let predicted = weigh(&[one, rolling, inertial], &[rest_w, f, effective]);
                estimates.push((predicted, effective / per_kg));
                if predicted.is_finite() && point.power.is_finite() {
                    state.learn([rolling, inertial], point.power - predicted, point.time - last, self.robust);
                    last = point.time;
                }
            }
        }
        Ok(estimates)
    }
}

impl State {
    /// From one residual, so long after the last.
    fn learn(&mut self, terms: [f64; 2], residual: f64, elapsed_s: f64, robust: bool) {
        let kept = MEMORIES_S.map(|memory| (-elapsed_s.max(0.0) / memory).exp());
        let bounded =
            if robust { residual.clamp(-BOUND * self.spread_w, BOUND * self.spread_w) } else { residual };
        let mean_size = kept[0] * self.spread_w + (1.0 - kept[0]) * bounded.abs() * STD_OF_MEAN_SIZE;
        self.spread_w = mean_size.max(f64::MIN_POSITIVE);
        let spread = |place: usize| self.variance[place] * terms[place] / kept[place];
        let gains = [spread(0), spread(1)];
        let whole = 1.0 + gains[0] * terms[0] + gains[1] * terms[1];
        for place in 0..2 {
            self.estimate[place] += gains[place] / whole * bounded;
            let learned = kept[place] + self.variance[place] * terms[place] * terms[place];
            self.variance[place] = (self.variance[place] / learned).min(DIFFUSE);
        }
    }
}

impl Baseline for Forgetting {
    /// b, c and the start of a drive: the mean payload of the training, with the information of one
    /// memory.
    fn fit(&mut self, training: &[Point]) -> Result<()> {
        self.fitted = None;
        let all = |point: &Point| {
            let [one, rolling, inertial] = terms(point);
            [one, rolling, point.mass * rolling, point.mass * inertial]
        };
        let rows = rows(self.name, training, all)?;
        let failed = || Error::failed(format!("{}: the regression has no finite solution", self.name));
        let coefficients = least_squares(&rows).ok_or_else(failed)?;
        let [rest_w, rolling, rolling_per_kg, per_kg] = coefficients[..] else { return Err(failed()) };
        if per_kg.is_nan() || per_kg <= 0.0 {
            return Err(Error::failed(format!(
                "{}: inertia takes {per_kg:.3} of a kilogram's power; expected training that speeds up and brakes at several masses",
                self.name
            )));
        }
        let count = rows.len() as f64;
        let mean = |value: &dyn Fn(&Point) -> f64| training.iter().map(value).sum::<f64>() / count;
        let mass = mean(&|point| point.mass);
        let residual = |(terms, power): &([f64; 4], f64)| (power - weigh(terms, &coefficients)).abs();
        let spread_w = STD_OF_MEAN_SIZE * rows.iter().map(residual).sum::<f64>() / count;
        let steps = training.windows(2).filter(|pair| pair[0].run == pair[1].run);
        let period_s = steps.map(|pair| pair[1].time - pair[0].time).find(|step| *step > 0.0).unwrap_or(1.0);
        let information =
            |place: usize| mean(&|point| terms(point)[place + 1].powi(2)) * MEMORIES_S[place] / period_s;
        self.fitted = Some(Fitted {
            rest_w,
            per_kg,
            start: State {
                estimate: [rolling + rolling_per_kg * mass, per_kg * mass],
                variance: [0, 1].map(|place| 1.0 / information(place).max(1.0 / DIFFUSE)),
                spread_w: spread_w.max(f64::MIN_POSITIVE),
            },
        });
        Ok(())
    }

    fn predict(&self, points: &[Point]) -> Result<Vec<f64>> {
        Ok(self.drive(points)?.into_iter().map(|(power, _)| power).collect())
    }

    fn masses(&self, points: &[Point]) -> Result<Option<Vec<f64>>> {
        Ok(Some(self.drive(points)?.into_iter().map(|(_, mass)| mass).collect()))
    }

    fn parameters(&self) -> Vec<Parameter> {
        let values = self.fitted.map(|fitted| [fitted.rest_w, fitted.per_kg]);
        named([("b", "W"), ("c", "1")], values.as_ref().map_or(&[], |values| values.as_slice()))
    }
}

#[cfg(test)]
mod tests {
    use super::{Forgetting, MEMORIES_S};
    use crate::baselines::testing::{PERIOD_S, drive};
    use crate::baselines::{Baseline, Point, longitudinal};

    /// 0.5 W at rest, 1 N on the ground and 1.2 kg at the battery for each kilogram.
    fn power(point: &Point, ground_n: f64) -> f64 {
        let [_, rolling, inertial] = longitudinal::terms(point);
        0.5 + ground_n * rolling + 1.2 * point.mass * inertial
    }

    /// A sensor's noise, up to 0.1 W: without any, every residual would be far beyond the usual.
    fn scatter(point: &Point) -> f64 {
        0.1 * (7919.0 * point.time).sin()
    }

    fn fitted(robust: bool) -> Forgetting {
        let mut model = Forgetting::new("vahidi", robust);
        model.fit(&drive(4000, |point| power(point, 1.0) + scatter(point))).unwrap();
        model
    }

    /// At one mass for five memories of it, on a ground that changes from 1 N to 2 N half-way.
    fn loaded(mass: f64, spikes: f64) -> Vec<Point> {
        let count = (5.0 * MEMORIES_S[1] / PERIOD_S) as usize;
        let mut points = drive(count, |_| 0.0);
        for (index, point) in points.iter_mut().enumerate() {
            point.mass = mass;
            let ground = if index < count / 2 { 1.0 } else { 2.0 };
            let spike = if index % 37 == 0 { spikes } else { 0.0 };
            point.power = power(point, ground) + scatter(point) + spike;
        }
        points
    }

    /// After five memories exp(−5) = 0.7 % of the way from 2 kg remains. As little remains of the
    /// ground's step, which the mass sees for as long as f lags.
    #[test]
    fn the_mass_is_found_whatever_the_ground_does() {
        let points = loaded(2.8, 0.0);
        let masses = fitted(false).masses(&points).unwrap().unwrap();
        let last = masses[masses.len() - 1];
        assert!((last / 2.8 - 1.0).abs() < 0.03, "{last}");
        let powers = fitted(false).predict(&points).unwrap();
        let error = (powers[powers.len() - 1] - points[points.len() - 1].power).abs();
        assert!(error < 0.12, "its scatter, and a little: {error}");
    }

    /// One sample in 37 with 10 W too much: bounded, a spike is worth no more than 1.345 usual
    /// residuals.
    #[test]
    fn the_robust_form_bears_spikes() {
        let points = loaded(2.8, 10.0);
        let error = |robust: bool| {
            let masses = fitted(robust).masses(&points).unwrap().unwrap();
            let late = &masses[masses.len() / 4 * 3..];
            late.iter().map(|mass| (mass / 2.8 - 1.0).abs()).sum::<f64>() / late.len() as f64
        };
        assert!(error(true) < 0.5 * error(false), "{} {}", error(true), error(false));
    }

    #[test]
    fn refuses_a_training_without_inertia() {
        let points =
            drive(1000, |point| 0.5 + longitudinal::terms(point)[1] - 0.1 * longitudinal::terms(point)[2]);
        let error = Forgetting::new("vahidi", false).fit(&points).unwrap_err().to_string();
        assert!(error.starts_with("vahidi: inertia takes -"), "{error}");
        assert!(Forgetting::new("vahidi", false).predict(&points).is_err());
    }
}
