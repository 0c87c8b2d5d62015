//! Whether ours is ahead, and whether what was asked of it is reached.

use serde::Serialize;
use statrs::distribution::{Binomial, DiscreteCDF};

use super::study::{Experiment, ModelRow, Spread};
use crate::compare::MassSource;

/// Ours against another model, on the same logs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Standing {
    /// Ours is better by MAPE and by R² in more seeds than chance would have.
    Ahead,
    /// So many seeds cannot tell them apart.
    Level,
    /// Ours is worse by MAPE or by R² in more seeds than chance would have.
    Behind,
}

/// Chance of as many seeds or more, where both were equally good, below which chance is not believed (two-sided: 5 %).
const BELIEVED: f64 = 0.025;

impl Standing {
    /// The sign test: seeds are independent, and within one both models see the same log. It asks for no distribution, so that one
    /// seed in which a network went astray does not hide the others.
    pub fn of(row: &ModelRow) -> Self {
        let seeds = row.ours_ahead + row.ours_behind;
        if is_more_than_chance(row.ours_ahead, seeds) {
            Self::Ahead
        } else if is_more_than_chance(row.ours_behind, seeds) {
            Self::Behind
        } else {
            Self::Level
        }
    }

    /// Whether so many seeds can tell models apart at all, all of them on one side.
    pub fn can_be_told(seeds: u64) -> bool {
        is_more_than_chance(seeds, seeds)
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

/// Whether a fair coin falls on one side so often in so many throws with a probability below [`BELIEVED`].
fn is_more_than_chance(often: u64, throws: u64) -> bool {
    let Ok(coin) = Binomial::new(0.5, throws) else { return false };
    often > 0 && coin.sf(often - 1) < BELIEVED
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
        let Some((_, others)) = models.split_first() else { return standings };
        for theirs in others {
            let standing = Standing::of(theirs);
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
    use super::{Goal, Standing, is_more_than_chance};
    use crate::reproduce::study::Spread;
    use crate::reproduce::testing;

    fn spread(low: f64, high: f64) -> Spread {
        Spread { mean: (low + high) / 2.0, low, high, least: low, greatest: high, count: 20 }
    }

    /// Of 20 throws of a fair coin 15 or more fall on one side with a probability of 21700/2²⁰ = 2.07 %, 14 or more with 5.77 %.
    /// Six of six: 1.6 %; five of five: 3.1 %.
    #[test]
    fn chance_is_believed_up_to_a_fortieth() {
        let decided = [(15, 20), (14, 20), (6, 6), (5, 5), (0, 0)];
        assert_eq!(
            decided.map(|(often, throws)| is_more_than_chance(often, throws)),
            [true, false, true, false, false]
        );
    }

    #[test]
    fn the_seeds_decide() {
        let standing = |ours_ahead, ours_behind| {
            let row = testing::study(2).experiment.models.remove(1);
            Standing::of(&crate::reproduce::study::ModelRow { ours_ahead, ours_behind, ..row })
        };
        assert_eq!(standing(20, 0), Standing::Ahead);
        assert_eq!(standing(2, 18), Standing::Behind);
        assert_eq!(standing(12, 8), Standing::Level);
        assert_eq!(standing(2, 0), Standing::Level, "two seeds decide nothing");
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
