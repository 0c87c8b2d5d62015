//! Models on a floor that adapts: each gets the mass and the power of the last minutes.
//!
//! Ours adapts rolling resistance and scrub ([`model_core::adapt`]). A baseline has no such
//! parameters: it gets two numbers with the same prior and memory, a share of its power and an
//! offset while the robot moves. Both are known as of the second before.

use std::path::Path;

use answers::estimate::{Policy, PolicyKind, Recorded, replay_adapting};
use logs::SampleReader;
use logs::robot::Robot;
use logs::robot::chassis::Together;
use model::coefficients::FittedModel;
use model_core::adapt::Ground;
use nalgebra::{Matrix2, Vector2};
use support::context::Context;
use support::error::{Error, Result};

use super::entry::Pair;
use super::mass::same;
use crate::baselines::Point;

/// A baseline's prior, from its training.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prior {
    /// Precisions of the two numbers: share, and W while the robot moves.
    precision: Matrix2<f64>,
    /// Variance of the error of a second's mean power, W².
    variance: f64,
}

impl Prior {
    /// From a baseline's predictions of its training points; `None` without any error.
    pub(super) fn of(training: &[Point], predicted: &[f64]) -> Option<Self> {
        let seconds = seconds(training, predicted);
        let count = seconds.len().max(1) as f64;
        let variance = seconds.iter().map(|second| second.error.powi(2)).sum::<f64>() / count;
        let usual_w = seconds.iter().map(|second| second.along[0].abs()).sum::<f64>() / count;
        let share = Ground::<f64>::usual().share;
        let precision = Matrix2::from_diagonal(&Vector2::new(share, share * usual_w).map(|x| x.powi(-2)));
        (variance > 0.0 && usual_w > 0.0).then_some(Self { precision, variance })
    }

    /// The same points once the two numbers adapt, W.
    pub(super) fn adapted(&self, points: &[Point], predicted: &[f64]) -> Vec<f64> {
        let memory = Ground::<f64>::usual().memory;
        let mut seconds = seconds(points, predicted).into_iter().peekable();
        let (mut now, mut information, mut score) = (None, Matrix2::zeros(), Vector2::zeros());
        let mut numbers = Vector2::zeros();
        let adapt = |(point, predicted): (&Point, &f64)| {
            let place = (point.run, point.time.floor() as i64);
            while let Some(second) = seconds.next_if(|second| second.place < place) {
                let passed = match now.replace(second.place) {
                    Some((run, time)) if run == second.place.0 => (second.place.1 - time) as f64,
                    _ => f64::INFINITY,
                };
                let share = (-passed / memory).exp();
                information = information * share + second.along * second.along.transpose() / self.variance;
                score = score * share + second.along * second.error / self.variance;
                let covariance = (self.precision + information).try_inverse();
                numbers = covariance.map_or(numbers, |covariance| covariance * score);
            }
            // Another run may be on another floor.
            if now.is_some_and(|(run, _)| run != point.run) {
                numbers = Vector2::zeros();
            }
            predicted + numbers.dot(&along(point, *predicted))
        };
        points.iter().zip(predicted).map(adapt).collect()
    }
}

/// The change of power per unit of each number.
fn along(point: &Point, predicted: f64) -> Vector2<f64> {
    Vector2::new(predicted, f64::from(u8::from(point.wheels.is_moving())))
}

/// Means over a second.
struct Second {
    /// Run and second.
    place: (u32, i64),
    along: Vector2<f64>,
    /// Measured less predicted power, W.
    error: f64,
}

/// Points without a prediction are left out.
fn seconds(points: &[Point], predicted: &[f64]) -> Vec<Second> {
    let known: Vec<(&Point, f64)> =
        points.iter().zip(predicted.iter().copied()).filter(|(_, predicted)| predicted.is_finite()).collect();
    let place = |point: &Point| (point.run, point.time.floor() as i64);
    let mean = |second: &[(&Point, f64)]| {
        let count = second.len() as f64;
        Second {
            place: place(second[0].0),
            along: second.iter().map(|(point, power)| along(point, *power)).sum::<Vector2<f64>>() / count,
            error: second.iter().map(|(point, power)| point.power - power).sum::<f64>() / count,
        }
    };
    known.chunk_by(|a, b| place(a.0) == place(b.0)).map(mean).collect()
}

/// Measured and predicted power of one log by our model on a floor that adapts.
///
/// # Errors
/// A log that cannot be read, whose mass changes, or which the model does not fit.
pub(super) fn ours(
    context: &Context,
    robot: &Robot,
    coefficients: &FittedModel,
    file: &Path,
    mass_kg: f64,
    window_s: f64,
) -> Result<Vec<Pair>> {
    let recorded = Recorded { file, mass_kg: Some(only_mass(context, robot, file, mass_kg)?) };
    let policy = Policy { window_s, kind: PolicyKind::Moving, changes_s: Vec::new(), detect: false };
    let mut pairs = Vec::new();
    replay_adapting(context, robot, coefficients, &recorded, &policy, &mut |instant| {
        pairs.extend(instant.predicted_w.map(|predicted| (instant.measured_w, predicted)));
    })?;
    Ok(pairs)
}

/// The one mass of a log, kg; `mass_kg` for a log without one.
fn only_mass(context: &Context, robot: &Robot, file: &Path, mass_kg: f64) -> Result<f64> {
    let mut reader = SampleReader::open(context, file, robot)?;
    let mut only = None;
    while let Some(raw) = reader.next_row()? {
        let mass = raw.mass.unwrap_or(mass_kg);
        if !same(*only.get_or_insert(mass), mass) {
            return Err(Error::failed("its mass changes; expected one in each log where the floor adapts")
                .in_file(file));
        }
    }
    Ok(only.unwrap_or(mass_kg))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baselines::testing::drive;

    /// A floor on which 30 % more is drawn, and 0.4 W while the robot moves, is learned in two
    /// minutes; another run begins anew.
    #[test]
    fn a_floor_is_learned_from_the_power_before() {
        let model = |point: &Point| 2.0 + point.speed.vx.abs() * 20.0;
        let training = drive(4_000, |point| model(point) + (7.0 * point.time).sin() * 0.3);
        let predicted: Vec<f64> = training.iter().map(model).collect();
        let prior = Prior::of(&training, &predicted).unwrap();
        let mut points = drive(4_800, |point| 1.3 * model(point) + 0.4);
        points[2_400..].iter_mut().for_each(|point| point.run += 1);
        let predicted: Vec<f64> = points.iter().map(model).collect();
        let adapted = prior.adapted(&points, &predicted);
        let error = |place: usize| (adapted[place] / points[place].power - 1.0).abs();
        assert_eq!((adapted[0], adapted[2_400]), (predicted[0], predicted[2_400]));
        assert!(error(0) > 0.2 && (2_000..2_400).all(|place| error(place) < 0.03), "{}", error(2_399));
        assert!(error(2_400) > 0.2 && (4_400..4_800).all(|place| error(place) < 0.03));
    }

    /// A second's own power changes none of its predictions.
    #[test]
    fn a_second_is_predicted_without_its_own_power() {
        let points = drive(400, |point| 5.0 + point.time.sin());
        let predicted = vec![5.0; 400];
        let prior = Prior::of(&points, &predicted).unwrap();
        let before = prior.adapted(&points, &predicted);
        let mut others = points.clone();
        others[200..].iter_mut().for_each(|point| point.power += 3.0);
        let after = prior.adapted(&others, &predicted);
        assert_eq!(before[..220], after[..220]);
        assert_ne!(before[220], after[220]);
    }
}
