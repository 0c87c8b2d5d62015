//! Whether ours is ahead, and whether what was asked of it is reached.

use serde::Serialize;

use super::study::{Experiment, ModelRow, Spread};
use crate::compare::MassSource;

/// Ours against another, by one figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Standing {
    /// Ours is better, and the intervals do not meet.
    Ahead,
    /// The intervals meet, or there are none: so many seeds cannot tell them apart.
    Level,
    /// Ours is worse, and the intervals do not meet.
    Behind,
}

/// Which way a figure is better.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Better {
    /// Errors.
    Less,
    /// R².
    More,
}

impl Standing {
    /// Of ours against theirs. Meeting intervals are stricter than a test of the difference: both come from the same logs.
    pub fn of(ours: &Spread, theirs: &Spread, better: Better) -> Self {
        let (below, above) = (ours.high < theirs.low, ours.low > theirs.high);
        match (better, below, above) {
            (Better::Less, true, _) | (Better::More, _, true) => Self::Ahead,
            (Better::Less, _, true) | (Better::More, true, _) => Self::Behind,
            _ => Self::Level,
        }
    }

    /// By MAPE and by R²: ahead in both, behind in any, level otherwise.
    pub fn of_models(ours: &ModelRow, theirs: &ModelRow) -> Self {
        let both = [
            Self::of(&ours.mape_percent, &theirs.mape_percent, Better::Less),
            Self::of(&ours.r2, &theirs.r2, Better::More),
        ];
        if both.contains(&Self::Behind) {
            Self::Behind
        } else if both.contains(&Self::Level) {
            Self::Level
        } else {
            Self::Ahead
        }
    }

    /// For tables.
    pub fn words(self) -> &'static str {
        match self {
            Self::Ahead => "ours ahead",
            Self::Level => "not told apart",
            Self::Behind => "beats ours",
        }
    }
}

/// Baselines that do not get the true mass, by how ours stands against them.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Standings {
    /// How many ours is ahead of.
    pub ahead: usize,
    /// Not told apart from ours.
    pub level: Vec<String>,
    /// Ahead of ours in MAPE, R² or both.
    pub behind: Vec<String>,
    /// The same of models that get the true mass, which ours does not.
    pub behind_with_mass: Vec<String>,
}

impl Standings {
    /// Of the first row against the others; nothing without rows.
    pub fn of(models: &[ModelRow]) -> Self {
        let mut standings = Self::default();
        let Some((ours, others)) = models.split_first() else { return standings };
        for theirs in others {
            let standing = Standing::of_models(ours, theirs);
            match (theirs.mass == MassSource::Given, standing) {
                (false, Standing::Ahead) => standings.ahead += 1,
                (false, Standing::Level) => standings.level.push(theirs.name.clone()),
                (false, Standing::Behind) => standings.behind.push(theirs.name.clone()),
                (true, Standing::Behind) => standings.behind_with_mass.push(theirs.name.clone()),
                (true, _) => {}
            }
        }
        standings
    }
}

/// What is asked of ours in the experiment's regime.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Goal {
    /// Which figure.
    pub what: &'static str,
    /// At most, or at least, this much.
    pub limit: f64,
    /// `%` or nothing.
    pub unit: &'static str,
    /// It is a lower limit.
    pub at_least: bool,
    /// What came out; `None` where it was not measured.
    pub found: Option<Spread>,
}

impl Goal {
    /// Whether the mean over seeds meets it; `None` where it was not measured.
    pub fn is_reached(&self) -> Option<bool> {
        let mean = self.found?.mean;
        mean.is_finite().then_some(if self.at_least { mean >= self.limit } else { mean <= self.limit })
    }
}

/// The four goals.
pub fn goals(experiment: &Experiment) -> Vec<Goal> {
    let ours = experiment.models.first();
    let method = experiment.windows.first().map(|row| row.method.as_str());
    let worst = |window_s: f64| {
        let own = experiment.windows.iter().filter(|row| Some(row.method.as_str()) == method);
        own.filter(|row| row.window_s == window_s).map(|row| row.worst_mass_percent).next()
    };
    let goal = |what, limit, unit, at_least, found| Goal { what, limit, unit, at_least, found };
    vec![
        goal("MAPE, moving window of 25 s", 5.0, "%", false, ours.map(|row| row.mape_percent)),
        goal("R², moving window of 25 s", 0.93, "", true, ours.map(|row| row.r2)),
        goal("mass error, worst window of 12.5 s", 7.0, "%", false, worst(12.5)),
        goal("mass error, worst window of 50 s", 4.0, "%", false, worst(50.0)),
    ]
}

#[cfg(test)]
mod tests {
    use super::{Better, Goal, Standing};
    use crate::reproduce::study::Spread;

    fn spread(low: f64, high: f64) -> Spread {
        Spread { mean: (low + high) / 2.0, low, high, least: low, greatest: high, count: 20 }
    }

    #[test]
    fn only_intervals_that_do_not_meet_decide() {
        let (small, wide, great) = (spread(1.0, 2.0), spread(1.5, 4.0), spread(3.0, 4.0));
        assert_eq!(Standing::of(&small, &great, Better::Less), Standing::Ahead);
        assert_eq!(Standing::of(&small, &great, Better::More), Standing::Behind);
        assert_eq!(Standing::of(&great, &small, Better::Less), Standing::Behind);
        assert_eq!(Standing::of(&small, &wide, Better::Less), Standing::Level);
        let one_seed = Spread { low: f64::NAN, high: f64::NAN, ..small };
        assert_eq!(Standing::of(&one_seed, &great, Better::Less), Standing::Level);
    }

    #[test]
    fn a_goal_that_was_not_measured_is_not_reached_and_not_missed() {
        let goal = Goal { what: "R²", limit: 0.93, unit: "", at_least: true, found: None };
        assert_eq!(goal.is_reached(), None);
        assert_eq!(Goal { found: Some(spread(0.93, 0.95)), ..goal.clone() }.is_reached(), Some(true));
        assert_eq!(Goal { found: Some(spread(0.90, 0.92)), ..goal.clone() }.is_reached(), Some(false));
        assert_eq!(Goal { found: Some(spread(f64::NAN, 1.0)), ..goal }.is_reached(), None);
    }
}
