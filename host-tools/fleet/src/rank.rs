//! Robots by what a metre costs them.

use std::collections::{BTreeMap, BTreeSet};

use fit::run_gram::RunGram;
use serde::Serialize;

use super::keys::{DAY, ROBOT, key};

/// A robot's share of the fleet's work.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Standing {
    /// Which.
    pub robot: String,
    /// J/m; none where it did not move.
    pub energy_per_metre_j_m: Option<f64>,
    /// Way, m.
    pub distance_m: f64,
    /// Energy, J.
    pub energy_j: f64,
    /// Mean total mass over time, kg.
    pub mean_mass_kg: f64,
    /// Runs that count.
    pub runs: usize,
    /// Days with such a run.
    pub days: usize,
    /// Power when driving straight without payload, W, by its own coefficients; none where its runs
    /// do not determine them.
    pub straight_w: Option<f64>,
}

/// All robots, the one to which a metre costs most first.
pub(super) fn rank(runs: &[&RunGram]) -> Vec<Standing> {
    let mut robots: BTreeMap<&str, Vec<&RunGram>> = BTreeMap::new();
    for run in runs {
        robots.entry(key(run, ROBOT)).or_default().push(run);
    }
    let mut standings: Vec<Standing> =
        robots.into_iter().map(|(robot, runs)| standing(robot, &runs)).collect();
    let cost = |standing: &Standing| standing.energy_per_metre_j_m.unwrap_or(f64::NEG_INFINITY);
    standings.sort_by(|a, b| cost(b).total_cmp(&cost(a)));
    standings
}

fn standing(robot: &str, runs: &[&RunGram]) -> Standing {
    let (energy_j, distance_m) =
        runs.iter().fold((0.0, 0.0), |(e, d), run| (e + run.summary.energy_j, d + run.summary.distance_m));
    let masses = || runs.iter().flat_map(|run| &run.summary.masses);
    let seconds: f64 = masses().map(|(_, seconds)| seconds).sum();
    let days: BTreeSet<&str> = runs.iter().map(|run| key(run, DAY)).collect();
    Standing {
        robot: robot.to_owned(),
        energy_per_metre_j_m: (distance_m > 0.0).then(|| energy_j / distance_m),
        distance_m,
        energy_j,
        mean_mass_kg: masses().map(|(mass, time)| mass * time).sum::<f64>() / seconds,
        runs: runs.len(),
        days: days.len(),
        straight_w: None,
    }
}
