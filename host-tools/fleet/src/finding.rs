//! What a fleet's page and its first line say: who stands out, and by what.

use std::collections::BTreeSet;

use numerics::robust::median;

use super::disagree::Disagreements;
use super::drift::Drift;
use super::outlier::Outliers;
use super::rank::Standing;

/// What is less off the median than this rounds to 0 %: the coefficient's name says more.
const LEAST_PERCENT: f64 = 0.5;

/// One sentence without its point.
pub(super) fn finding(
    standings: &[Standing],
    drift: &Drift,
    outliers: &Outliers,
    disagreements: &Disagreements,
) -> String {
    let changed = |robot: &str| drift.changes.iter().find(|change| change.robot == robot);
    let names: BTreeSet<&str> = (drift.changes.iter().map(|one| &*one.robot))
        .chain(outliers.robots.iter().map(|one| &*one.robot))
        .collect();
    let mut draws: Vec<f64> = standings.iter().filter_map(|one| one.straight_w).collect();
    let middle = median(&mut draws).unwrap_or(0.0);
    let excess = |robot: &str| {
        let watts = standings.iter().find(|one| one.robot == robot)?.straight_w?;
        (middle > 0.0).then(|| 100.0 * (watts / middle - 1.0))
    };
    let size = |robot: &str| excess(robot).unwrap_or(0.0);
    let Some(robot) = names.iter().max_by(|a, b| size(a).abs().total_cmp(&size(b).abs())) else {
        return without_names(standings.len(), drift, outliers, disagreements);
    };
    let percent = size(robot);
    let mut said = if percent.abs() >= LEAST_PERCENT {
        let more = if percent > 0.0 { "more" } else { "less" };
        format!("robot {robot} draws {:.0} % {more} than the fleet's median", percent.abs().max(1.0))
    } else {
        let outlier = outliers.robots.iter().find(|one| one.robot == *robot);
        let what = changed(robot).map(|one| &one.coefficient).or(outlier.map(|one| &one.coefficient));
        format!("robot {robot} is unlike the others in {}", what.map_or("", String::as_str))
    };
    if let Some(change) = changed(robot) {
        said += &format!("; it changed on {}", change.since);
    }
    match names.len() - 1 {
        0 => {}
        1 => said += "; one more stands out",
        more => said += &format!("; {more} more stand out"),
    }
    said
}

fn without_names(robots: usize, drift: &Drift, outliers: &Outliers, disagreements: &Disagreements) -> String {
    let robots = if robots == 1 { "one robot".to_owned() } else { format!("{robots} robots") };
    match (disagreements.runs.len(), drift.threshold.or(outliers.threshold)) {
        (0, None) => format!("{robots}, too few runs to tell who stands out"),
        (0, Some(_)) => format!("of {robots} none stands out"),
        (1, _) => format!("of {robots} none stands out, but one run disagrees with its robot"),
        (runs, _) => format!("of {robots} none stands out, but {runs} runs disagree with their robots"),
    }
}
