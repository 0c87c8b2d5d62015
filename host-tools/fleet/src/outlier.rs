//! Which robot's coefficients stand out from the other robots'.
//!
//! Robots differ, and how much is taken from the fleet: the median over robots is what they have in
//! common, the median of the distances from it their scatter. A robot stands out where it is beyond
//! chance over all robots and coefficients (Bonferroni). Runs from a change on ([`super::drift`])
//! are left out: a robot that changed is no outlier; a robot that always differed is.

use std::collections::BTreeSet;

use fit::physical::IMBALANCE;
use fit::run_gram::{PARAMETERS, RunGram};
use model_core::torque::TorqueModel;
use nalgebra::DVector;
use numerics::robust::{NORMAL_95, median, scale};
use numerics::scaled_inverse::DETERMINED;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::base::{Direction, Robot, by_robot, directions, shared_step};
use super::drift::{APART, Drift, FALSE_NAMES};

/// Fewest robots from which their scatter is known.
const LEAST_ROBOTS: usize = 10;

/// The median of distances knows a scatter as well as the standard deviation of this share of the
/// values (Rousseeuw and Croux 1993).
pub(super) const MAD_EFFICIENCY: f64 = 0.37;

/// A robot that is not like the others.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outlier {
    /// Which robot.
    pub robot: String,
    /// Which coefficient.
    pub coefficient: String,
    /// By so much beyond the fleet's median, in `unit`.
    pub difference: f64,
    /// Half of its 95 % interval, the scatter of robots included.
    pub plus_minus: f64,
    /// Of difference and interval.
    pub unit: String,
    /// Difference in percent of the coefficient that the fleet is held against; none where that is
    /// 0.
    pub percent: Option<f64>,
    /// Half of its 95 % interval.
    pub percent_plus_minus: Option<f64>,
    /// Other coefficients that explain it nearly as well: then it is none of them by name.
    pub or_coefficients: Vec<String>,
}

impl Outlier {
    /// One sentence.
    pub fn sentence(&self) -> String {
        let size = match (self.percent, self.percent_plus_minus) {
            (Some(percent), Some(plus_minus)) => format!("{percent:+.1} ± {plus_minus:.1} %"),
            _ => format!("{:+.3e} ± {:.1e} {}", self.difference, self.plus_minus, self.unit),
        };
        let mut text = format!("{}: {} is {size} off the other robots'", self.robot, self.coefficient);
        if !self.or_coefficients.is_empty() {
            text += &format!("; it may as well be {}", self.or_coefficients.join(", "));
        }
        text
    }
}

/// What was asked, and what came of it.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Outliers {
    /// Robots beyond chance, by name.
    #[serde(rename = "found")]
    pub robots: Vec<Outlier>,
    /// Robots, times coefficients, that were asked.
    pub asked: usize,
    /// What a difference must be in standard deviations of robots to stand.
    pub threshold: Option<f64>,
    /// Chance that a fleet of like robots has any name.
    pub level: f64,
    /// Why nothing is said.
    pub silent: Option<String>,
}

/// A difference, asked.
struct Asked {
    robot: usize,
    direction: usize,
    difference: f64,
    information: f64,
    /// Σ (score left)² / Σ information of the runs, for the runs that are to spare; none of a robot
    /// with one run.
    scatter: Option<f64>,
}

/// Robots as they were before what changed on them.
pub(super) fn unchanged<'a>(runs: &[&'a RunGram], drift: &Drift) -> Vec<Robot<'a>> {
    let since = |robot: &str| {
        drift.changes.iter().find(|change| change.robot == robot).map(|change| change.since.as_str())
    };
    let robots = by_robot(runs).into_iter().map(|(name, mut runs)| {
        if let Some(day) = since(name) {
            runs.retain(|run| run.day < day);
        }
        Robot::new(name, runs)
    });
    robots.filter(|robot| !robot.runs.is_empty()).collect()
}

/// What most robots differ from the reference by: the median of each parameter.
pub(super) fn in_common(robots: &[Robot<'_>]) -> DVector<f64> {
    let bases: Vec<DVector<f64>> = robots.iter().map(Robot::base).collect();
    DVector::from_fn(PARAMETERS, |place, _| {
        median(&mut bases.iter().map(|base| base[place]).collect::<Vec<f64>>()).unwrap_or(0.0)
    })
}

/// Holds every robot against the others. Runs are those that count, near `reference`.
pub(super) fn outliers(runs: &[&RunGram], reference: &TorqueModel<f64>, drift: &Drift) -> Outliers {
    let robots = unchanged(runs, drift);
    let mut outliers = Outliers { level: FALSE_NAMES, ..Outliers::default() };
    if robots.len() < LEAST_ROBOTS {
        outliers.silent =
            Some(format!("{} robots; {LEAST_ROBOTS} tell how much robots differ", robots.len()));
        return outliers;
    }
    let common = in_common(&robots);
    let has_sides = robots.iter().any(|robot| robot.total[(IMBALANCE, IMBALANCE)] > 0.0);
    let directions = directions(reference, has_sides);
    let mut asked = Vec::new();
    for (place, robot) in robots.iter().enumerate() {
        for (direction, along) in directions.iter().enumerate() {
            asked.extend(ask(place, robot, &common, direction, &along.along));
        }
    }
    outliers.asked = asked.len();
    let spreads: Vec<Spread> = (0..directions.len())
        .map(|direction| Spread::of(asked.iter().filter(|one| one.direction == direction)))
        .collect();
    let freedom = MAD_EFFICIENCY * (robots.len() - 1) as f64;
    let Ok(student) = StudentsT::new(0.0, 1.0, freedom) else { return outliers };
    let threshold = -student.inverse_cdf(FALSE_NAMES / (2.0 * asked.len().max(1) as f64));
    outliers.threshold = Some(threshold);
    for (place, robot) in robots.iter().enumerate() {
        let of_robot: Vec<&Asked> = asked.iter().filter(|one| one.robot == place).collect();
        outliers.robots.extend(named(robot, &of_robot, &directions, &spreads, threshold));
    }
    outliers
}

fn ask(
    place: usize,
    robot: &Robot<'_>,
    common: &DVector<f64>,
    direction: usize,
    along: &DVector<f64>,
) -> Option<Asked> {
    let each: Vec<(f64, f64)> = robot
        .runs
        .iter()
        .map(|run| (along.dot(&(&run.normal * along)), along.dot(&(&run.score - &run.normal * common))))
        .collect();
    let most = robot.total.diagonal().component_mul(&along.component_mul(along)).max();
    let (difference, information, squares) = shared_step(&each, (DETERMINED * most).max(0.0))?;
    let count = each.len() as f64;
    let scatter = (each.len() > 1).then(|| squares / information * count / (count - 1.0));
    Some(Asked { robot: place, direction, difference, information, scatter })
}

/// How a coefficient scatters: its median, its scatter over robots, and that of runs.
struct Spread {
    middle: f64,
    robots: f64,
    runs: f64,
}

impl Spread {
    fn of<'a>(asked: impl Iterator<Item = &'a Asked>) -> Self {
        let asked: Vec<&Asked> = asked.collect();
        let differences: Vec<f64> = asked.iter().map(|one| one.difference).collect();
        let mut scatters: Vec<f64> = asked.iter().filter_map(|one| one.scatter).collect();
        Self {
            middle: median(&mut differences.clone()).unwrap_or(0.0),
            robots: scale(&differences).unwrap_or(0.0),
            runs: median(&mut scatters).unwrap_or(0.0),
        }
    }

    /// Standard deviation of a difference: of robots, or of this robot's runs where that is more.
    fn of_one(&self, one: &Asked) -> f64 {
        let runs = self.runs.max(one.scatter.unwrap_or(0.0)) / one.information;
        self.robots.max(runs.sqrt())
    }
}

/// The coefficient that explains most, where one is beyond chance.
fn named(
    robot: &Robot<'_>,
    asked: &[&Asked],
    directions: &[Direction],
    spreads: &[Spread],
    threshold: f64,
) -> Option<Outlier> {
    let off = |one: &Asked| one.difference - spreads[one.direction].middle;
    let deviation = |one: &Asked| spreads[one.direction].of_one(one);
    // What a difference takes off the squares, W²: on one scale for all coefficients.
    let gain = |one: &Asked| off(one).powi(2) * one.information;
    let best = asked.iter().filter(|one| gain(one).is_finite()).max_by(|a, b| gain(a).total_cmp(&gain(b)))?;
    if off(best).abs() < threshold * deviation(best) {
        return None;
    }
    let apart = APART * deviation(best).powi(2) * best.information;
    let near = asked.iter().filter(|one| one.direction != best.direction && gain(best) - gain(one) < apart);
    let others: BTreeSet<usize> = near.map(|one| one.direction).collect();
    let direction = &directions[best.direction];
    let plus_minus = NORMAL_95 * deviation(best);
    let percent = |amount: f64| (direction.value > 0.0).then(|| 100.0 * amount / direction.value);
    Some(Outlier {
        robot: robot.name.to_owned(),
        coefficient: direction.name.clone(),
        difference: off(best),
        plus_minus,
        unit: direction.unit.to_owned(),
        percent: percent(off(best)),
        percent_plus_minus: percent(plus_minus),
        or_coefficients: others.into_iter().map(|other| directions[other].name.clone()).collect(),
    })
}

#[cfg(test)]
mod tests {
    use fit::run_gram::RunGram;

    use super::*;
    use crate::disagree::disagreements;
    use crate::tests::{REFERENCE, fleet, no_change};

    /// Robots 1 % apart in all coefficients; one of them 20 % off in viscous friction, which is far
    /// beyond.
    #[test]
    fn the_robot_that_is_unlike_the_others_is_named_and_no_other() {
        let outliers_of = |robot: Option<usize>| {
            let runs = fleet(|at, _| if Some(at) == robot { 0.2 } else { 0.0 }, |_, _| 1.0);
            outliers(&runs.iter().collect::<Vec<&RunGram>>(), &REFERENCE, &no_change())
        };
        let none = outliers_of(None);
        assert!(none.robots.is_empty() && none.threshold.is_some(), "{none:?}");
        let one = outliers_of(Some(7));
        assert_eq!(one.robots.len(), 1, "{one:?}");
        let outlier = &one.robots[0];
        assert_eq!((outlier.robot.as_str(), outlier.coefficient.as_str()), ("07", "viscous"));
        let (percent, plus_minus) = (outlier.percent.unwrap(), outlier.percent_plus_minus.unwrap());
        assert!((percent - 20.0).abs() < plus_minus, "{outlier:?}");
    }

    /// Few robots do not show how much robots differ.
    #[test]
    fn a_few_robots_are_no_fleet() {
        let runs = fleet(|at, _| if at == 1 { 0.2 } else { 0.0 }, |_, _| 1.0);
        let few: Vec<&RunGram> = runs.iter().filter(|run| run.keys["robot"].as_str() < "09").collect();
        let outliers = outliers(&few, &REFERENCE, &no_change());
        assert!(outliers.robots.is_empty() && outliers.silent.is_some(), "{outliers:?}");
    }

    /// Of one run three times as much is left as of the others, in a direction that no coefficient
    /// has.
    #[test]
    fn the_run_that_disagrees_is_named_and_no_other() {
        let disagreements_of = |odd: bool| {
            let runs = fleet(|_, _| 0.0, |robot, day| if odd && (robot, day) == (3, 2) { 3.0 } else { 1.0 });
            disagreements(&runs.iter().collect::<Vec<&RunGram>>(), &no_change())
        };
        let none = disagreements_of(false);
        assert!(none.runs.is_empty() && none.threshold.is_some(), "{none:?}");
        let one = disagreements_of(true);
        assert_eq!(one.runs.len(), 1, "{one:?}");
        assert_eq!(one.runs[0].run, "03/2");
        assert!((one.runs[0].rmse_w / one.runs[0].usual_w / 3.0 - 1.0).abs() < 0.2, "{one:?}");
    }
}
