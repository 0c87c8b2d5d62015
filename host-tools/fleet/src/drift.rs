//! Which coefficient of which robot has changed, and since which day.
//!
//! A robot's runs are held against coefficients that are known ([`fit::run_gram::Local`]). A robot
//! may differ from them in all coefficients, and always has: that is its own base. The question is
//! a step in one of them from a day on:
//!
//! ```text
//! Jᵀe of run r  =  N_r δ  +  [r from day d on] N_r v Δ  +  noise
//! ```
//!
//! δ is the robot's own, v a coefficient, Δ its step. How much scores scatter from run to run is
//! taken from the whole fleet, by the median over its robots, for the same v and d: that scatter,
//! not the scatter of rows, is what a step has to stand out of. A step is named where it is beyond
//! chance over all robots, coefficients and days that were asked (Bonferroni), and where no other
//! coefficient explains it nearly as well.

use std::collections::BTreeSet;

use fit::physical::IMBALANCE;
use fit::run_gram::{PARAMETERS, RunGram};
use model_core::torque::TorqueModel;
use nalgebra::DVector;
use numerics::robust::{NORMAL_95, median};
use numerics::scaled_inverse::DETERMINED;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::base::{Direction, Robot, Run, by_robot, directions, shared_step};

/// Chance that a fleet in which nothing changes has any name.
pub(super) const FALSE_NAMES: f64 = 0.01;

/// Difference in χ² that separates two explanations: odds of 100 to 1, 2 ln 100.
pub(super) const APART: f64 = 9.21;

/// Fewest runs beyond two a robot, over the fleet, from which the scatter of runs is known:
/// Student's t with ten degrees of freedom is 1.14 of the normal's at 95 %.
const LEAST_SPARE: usize = 10;

/// A step in one coefficient.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change {
    /// Which robot.
    pub robot: String,
    /// Which coefficient.
    pub coefficient: String,
    /// From this day on.
    pub since: String,
    /// Other days that explain it nearly as well.
    pub or_since: Vec<String>,
    /// By so much, in `unit`.
    pub step: f64,
    /// Half of its 95 % interval.
    pub plus_minus: f64,
    /// Of step and interval.
    pub unit: String,
    /// Step in percent of the coefficient that the fleet is held against; none where that is 0.
    pub percent: Option<f64>,
    /// Half of its 95 % interval.
    pub percent_plus_minus: Option<f64>,
    /// Other coefficients that explain it nearly as well: then it is none of them by name.
    pub or_coefficients: Vec<String>,
}

impl Change {
    /// One sentence.
    pub fn sentence(&self) -> String {
        let size = match (self.percent, self.percent_plus_minus) {
            (Some(percent), Some(plus_minus)) => format!("{percent:+.1} ± {plus_minus:.1} %"),
            _ => format!("{:+.3e} ± {:.1e} {}", self.step, self.plus_minus, self.unit),
        };
        let mut text = format!("{}: {} since {}, {size}", self.robot, self.coefficient, self.since);
        if !self.or_since.is_empty() {
            text += &format!("; or since {}", self.or_since.join(", "));
        }
        if !self.or_coefficients.is_empty() {
            text += &format!("; it may as well be {}", self.or_coefficients.join(", "));
        }
        text
    }
}

/// What was asked, and what came of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Drift {
    /// Steps beyond chance, by robot.
    pub changes: Vec<Change>,
    /// Robots, times coefficients, times days that were asked.
    pub asked: usize,
    /// What a step must be in standard errors to stand.
    pub threshold: Option<f64>,
    /// Robots of which nothing can be said, and why.
    pub silent: Vec<(String, String)>,
}

/// A step of a robot, asked.
struct Asked {
    direction: usize,
    day: usize,
    step: f64,
    information: f64,
    /// Σ (score left)² / Σ information of the runs, for the runs that are to spare.
    scatter: f64,
}

/// Looks for steps in all coefficients of all robots, from every day but the first. Runs are those
/// that count, near `reference`.
pub(super) fn changes(runs: &[&RunGram], reference: &TorqueModel<f64>) -> Drift {
    let mut drift = Drift { changes: Vec::new(), asked: 0, threshold: None, silent: Vec::new() };
    let mut robots = Vec::new();
    for (name, runs) in by_robot(runs) {
        let robot = Robot::new(name, runs);
        match why_silent(&robot) {
            None => robots.push(robot),
            Some(why) => drift.silent.push((name.to_owned(), why)),
        }
    }
    let spare: usize = robots.iter().map(|robot| robot.runs.len() - 2).sum();
    if spare < LEAST_SPARE {
        let why = format!(
            "the fleet has {spare} runs beyond two a robot; {LEAST_SPARE} tell how much runs differ by chance"
        );
        drift.silent.extend(robots.iter().map(|robot| (robot.name.to_owned(), why.clone())));
        return drift;
    }
    let has_sides = robots.iter().any(|robot| robot.total[(IMBALANCE, IMBALANCE)] > 0.0);
    let directions = directions(reference, has_sides);
    let asked: Vec<Vec<Asked>> = robots.iter().map(|robot| robot.ask(&directions)).collect();
    drift.asked = asked.iter().map(Vec::len).sum();
    // What scatter a coefficient has, over the fleet: robots that changed are the few.
    let scatters: Vec<f64> = (0..directions.len())
        .map(|direction| {
            let of = asked.iter().flatten().filter(|one| one.direction == direction);
            median(&mut of.map(|one| one.scatter).collect::<Vec<f64>>()).unwrap_or(0.0)
        })
        .collect();
    let Ok(student) = StudentsT::new(0.0, 1.0, spare as f64) else { return drift };
    let threshold = -student.inverse_cdf(FALSE_NAMES / (2.0 * drift.asked.max(1) as f64));
    drift.threshold = Some(threshold);
    for (robot, asked) in robots.iter().zip(&asked) {
        drift.changes.extend(named(robot, asked, &directions, &scatters, threshold));
    }
    drift
}

/// Why nothing can be said of a robot.
fn why_silent(robot: &Robot<'_>) -> Option<String> {
    if robot.days.len() < 2 {
        return Some("one day only: nothing to compare it with".to_owned());
    }
    let runs = robot.runs.len();
    (runs < 3).then(|| format!("{runs} runs only: no scatter to hold a step against"))
}

impl Robot<'_> {
    /// Every coefficient from every day but the first.
    fn ask(&self, directions: &[Direction]) -> Vec<Asked> {
        let base = self.base();
        let mut all = Vec::new();
        for (place, direction) in directions.iter().enumerate() {
            for day in 1..self.days.len() {
                all.extend(self.ask_one(&base, place, direction, day));
            }
        }
        all
    }

    fn ask_one(&self, base: &DVector<f64>, place: usize, direction: &Direction, day: usize) -> Option<Asked> {
        let since = self.days[day];
        let after = |run: &Run<'_>| run.day >= since;
        let moment = self.runs.iter().filter(|run| after(run));
        let moment = moment.fold(DVector::zeros(PARAMETERS), |sum, run| sum + &run.normal * &direction.along);
        // What of the step the robot's own base could be.
        let absorbed = &self.inverse * moment;
        let of_run = |run: &Run<'_>| {
            let along = if after(run) { &direction.along - &absorbed } else { -&absorbed };
            let information = along.dot(&(&run.normal * &along));
            let score = along.dot(&(&run.score - &run.normal * base));
            (information, score)
        };
        let each: Vec<(f64, f64)> = self.runs.iter().map(of_run).collect();
        let unabsorbed = direction.along.dot(&(&self.total * &direction.along));
        let (step, information, squares) = shared_step(&each, DETERMINED * unabsorbed)?;
        let spare = (self.runs.len() - 2) as f64;
        let scatter = squares / information * self.runs.len() as f64 / spare;
        Some(Asked { direction: place, day, step, information, scatter })
    }
}

/// The step that explains most, where it is beyond chance.
fn named(
    robot: &Robot<'_>,
    asked: &[Asked],
    directions: &[Direction],
    scatters: &[f64],
    threshold: f64,
) -> Option<Change> {
    // What a step takes off the squares, W²: one scale for all coefficients, unlike their own
    // scatters.
    let gain = |one: &Asked| one.step * one.step * one.information;
    let best = asked.iter().filter(|one| gain(one).is_finite()).max_by(|a, b| gain(a).total_cmp(&gain(b)))?;
    let most = gain(best);
    // A robot whose own runs scatter more than the fleet's is held against its own.
    let scatter = scatters[best.direction].max(best.scatter);
    if most < threshold * threshold * scatter {
        return None;
    }
    let near = || asked.iter().filter(|one| most - gain(one) < APART * scatter);
    let others: BTreeSet<usize> =
        near().filter(|one| one.direction != best.direction).map(|one| one.direction).collect();
    let days: BTreeSet<usize> = near()
        .filter(|one| one.direction == best.direction && one.day != best.day)
        .map(|one| one.day)
        .collect();
    let direction = &directions[best.direction];
    let plus_minus = NORMAL_95 * (scatter / best.information).sqrt();
    let percent = |amount: f64| (direction.value > 0.0).then(|| 100.0 * amount / direction.value);
    Some(Change {
        robot: robot.name.to_owned(),
        coefficient: direction.name.clone(),
        since: robot.days[best.day].to_owned(),
        or_since: days.into_iter().map(|day| robot.days[day].to_owned()).collect(),
        step: best.step,
        plus_minus,
        unit: direction.unit.to_owned(),
        percent: percent(best.step),
        percent_plus_minus: percent(plus_minus),
        or_coefficients: others.into_iter().map(|other| directions[other].name.clone()).collect(),
    })
}
