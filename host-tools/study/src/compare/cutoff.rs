//! The filter's cutoff, chosen by models of the literature: ours has no vote.
//!
//! A high cutoff lets noise through, a low one smears motion that a model could follow. Each
//! candidate filters the training logs, and one model of each of four families is fitted. The means
//! of its residual over a second count, which every cutoff passes alike, relative to the model's
//! best. The lowest cutoff whose geometric mean over the models is within a hundredth of the least
//! is chosen. A cutoff in the robot's file comes first.

use std::path::PathBuf;

use logs::SampleReader;
use logs::robot::Robot;
use rayon::prelude::*;
use support::context::Context;
use support::error::Result;

use super::points::{self, Wanted};
use crate::baselines::cards::{JARAMILLO, LINEAR, SADRPOUR_OFFLINE, TOUZOUT};
use crate::baselines::{Card, Point};

/// Candidates, Hz: half-octaves from where means over a second pass unchanged, as in a fit.
const CANDIDATES: [f64; 11] = [1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0, 22.0, 32.0];

/// Highest candidate as a share of the sample rate.
const HIGHEST_SHARE: f64 = 0.3;

/// Points that take part in a fit, about.
const MOST_POINTS: usize = 8_000;

/// An error within this share of the least is as good.
const AS_GOOD: f64 = 0.01;

/// The voters: one of each family with a quick fit for any wheels.
const VOTERS: [&Card; 4] = [&JARAMILLO, &TOUZOUT, &LINEAR, &SADRPOUR_OFFLINE];

/// The cutoff for these training logs, Hz. `training` keeps the points that may be used.
///
/// # Errors
/// A log that cannot be read, or a robot with impossible dimensions.
pub(super) fn choose(
    context: &Context,
    robot: &Robot,
    files: &[PathBuf],
    mass_kg: f64,
    training: impl Fn(Vec<Point>) -> Vec<Point> + Sync,
) -> Result<f64> {
    let mut slowest = 0.0_f64;
    for file in files {
        slowest = slowest.max(SampleReader::open(context, file, robot)?.period_s());
    }
    let highest = HIGHEST_SHARE / slowest;
    let candidates: Vec<f64> = CANDIDATES.into_iter().filter(|cutoff| *cutoff <= highest).collect();
    let wanted = Wanted::of(context, robot, files)?;
    let tried = candidates.par_iter().with_max_len(1).map(|cutoff_hz| {
        let core = robot.chassis(*cutoff_hz)?;
        let read = points::read(context, robot, &core, files, mass_kg, &wanted, 1)?;
        let points = training(read.into_iter().map(|(_, point)| point).collect());
        let stride = points.len().div_ceil(MOST_POINTS).max(1);
        let points: Vec<Point> = points.into_iter().step_by(stride).collect();
        Ok(VOTERS.map(|card| residual(robot, card, &points)))
    });
    let tried: Vec<[f64; 4]> = tried.collect::<Result<_>>()?;
    Ok(lowest_good_enough(&candidates, &tried).unwrap_or(highest.min(CANDIDATES[0])))
}

/// By candidate and voter; a voter that could not be fitted somewhere does not vote.
fn lowest_good_enough<const V: usize>(candidates: &[f64], tried: &[[f64; V]]) -> Option<f64> {
    let best = |voter: usize| tried.iter().map(|sizes| sizes[voter]).fold(f64::INFINITY, f64::min);
    let voters: Vec<usize> = (0..V).filter(|voter| tried.iter().all(|sizes| sizes[*voter] > 0.0)).collect();
    let mean = |sizes: &[f64; V]| {
        voters.iter().map(|voter| (sizes[*voter] / best(*voter)).ln()).sum::<f64>() / voters.len() as f64
    };
    let least = tried.iter().map(mean).fold(f64::INFINITY, f64::min);
    let good = |sizes: &&[f64; V]| mean(sizes) <= least + AS_GOOD;
    let place = tried.iter().position(|sizes| good(&sizes))?;
    candidates.get(place).copied()
}

/// Mean size of the residual's means over seconds, W; NaN where the model cannot be fitted.
fn residual(robot: &Robot, card: &Card, points: &[Point]) -> f64 {
    let mut model = card.make(robot);
    let predicted = match model.fit(points).and_then(|()| model.predict(points)) {
        Ok(predicted) => predicted,
        Err(_) => return f64::NAN,
    };
    let second = |index: &usize| (points[*index].run, points[*index].time.floor() as i64);
    let indices: Vec<usize> = (0..points.len()).collect();
    let seconds: Vec<f64> = indices
        .chunk_by(|a, b| second(a) == second(b))
        .map(|second| {
            let sum: f64 = second.iter().map(|index| points[*index].power - predicted[*index]).sum();
            (sum / second.len() as f64).abs()
        })
        .collect();
    seconds.iter().sum::<f64>() / seconds.len() as f64
}

#[cfg(test)]
mod tests {
    use super::lowest_good_enough;

    /// One voter is best at 2 Hz, the other at 4 Hz; relative to their own best 4 Hz costs the
    /// first 20 %, 2 Hz the second 10 %.
    #[test]
    fn every_voter_counts_alike() {
        let tried = [[1.5, 30.0], [1.0, 11.0], [1.2, 10.0]];
        assert_eq!(lowest_good_enough(&[1.0, 2.0, 4.0], &tried), Some(2.0));
        // A voter that failed once has no vote: the other decides alone.
        let tried = [[f64::NAN, 30.0], [1.0, 11.0], [1.2, 10.0]];
        assert_eq!(lowest_good_enough(&[1.0, 2.0, 4.0], &tried), Some(4.0));
        assert_eq!(lowest_good_enough::<2>(&[], &[]), None);
    }

    /// Within a hundredth the lower one is taken.
    #[test]
    fn the_lower_of_two_equals_is_taken() {
        assert_eq!(lowest_good_enough(&[1.0, 2.0], &[[1.005], [1.0]]), Some(1.0));
        assert_eq!(lowest_good_enough(&[1.0, 2.0], &[[1.02], [1.0]]), Some(2.0));
    }
}
