//! Whether ours is ahead, and whether its goals are reached.

use serde::Serialize;
use statrs::distribution::{Binomial, DiscreteCDF};

use super::section7::ModelRow;
use super::spread::Spread;
use super::table::{Cell, Column, Format, Mark, Row, Table, column, number, with_unit};
use super::windows::{WORST_MASS, WindowRow};
use crate::baselines;
use crate::compare::MassSource;

/// Ours against another model, on the same logs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Standing {
    /// Ours is better by MAPE and by R² in more seeds than chance would have.
    Ahead,
    /// So many seeds cannot distinguish them.
    Level,
    /// Ours is worse by MAPE or by R² in more seeds than chance would have.
    Behind,
}

/// Probability of as many seeds or more for equally good models, below which chance is ruled out
/// (two-sided: 5 %).
const BELIEVED: f64 = 0.025;

impl Standing {
    /// The sign test: seeds are independent, and within one both models see the same log. It needs
    /// no distribution: one seed in which a network failed does not hide the others.
    pub(super) fn of(row: &ModelRow) -> Self {
        let seeds = row.ours_ahead + row.ours_behind;
        if is_more_than_chance(row.ours_ahead, seeds) {
            Self::Ahead
        } else if is_more_than_chance(row.ours_behind, seeds) {
            Self::Behind
        } else {
            Self::Level
        }
    }

    /// Whether so many seeds can distinguish models at all, if all agree.
    pub(super) fn can_be_told(seeds: u64) -> bool {
        is_more_than_chance(seeds, seeds)
    }

    fn words(self) -> &'static str {
        match self {
            Self::Ahead => "ours ahead",
            Self::Level => "not told apart",
            Self::Behind => "beats ours",
        }
    }
}

/// Whether a fair coin falls on one side so often in so many throws with a probability below
/// [`BELIEVED`].
fn is_more_than_chance(often: u64, throws: u64) -> bool {
    let Ok(coin) = Binomial::new(0.5, throws) else { return false };
    often > 0 && coin.sf(often - 1) < BELIEVED
}

/// Baselines without the true mass, by their standing against ours.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub(super) struct Standings {
    /// How many ours is ahead of.
    pub(super) ahead: usize,
    /// Not distinguished from ours.
    pub(super) level: Vec<String>,
    /// Ahead of ours in MAPE, R² or both.
    pub(super) behind: Vec<String>,
    /// The same of models that get the true mass, which ours does not.
    pub(super) behind_with_mass: Vec<String>,
}

impl Standings {
    /// Of the first row against the others; nothing without rows.
    pub(super) fn of(models: &[ModelRow]) -> Self {
        let mut standings = Self::default();
        for theirs in models.iter().skip(1) {
            let name = theirs.name.clone();
            match (theirs.mass == MassSource::Given, Standing::of(theirs)) {
                (false, Standing::Ahead) => standings.ahead += 1,
                (false, Standing::Level) => standings.level.push(name),
                (false, Standing::Behind) => standings.behind.push(name),
                (true, Standing::Behind) => standings.behind_with_mass.push(name),
                (true, _) => {}
            }
        }
        standings
    }
}

const MODELS: [Column; 15] = [
    column("name", "model", Format::Words),
    column("source", "", Format::Words),
    column("mass", "mass", Format::Words),
    column("mape_percent", "MAPE %", Format::Error(2)),
    column("r2", "R²", Format::R2(3)),
    column("rmse_w", "RMSE W", Format::Error(3)),
    column("mass_error_percent", "mass error %", Format::Error(2)),
    column("horizon", "horizon", Format::Words),
    column("", "published", Format::AsShown),
    column("", "standing", Format::Words),
    column("", "R² by weights", Format::Words),
    column("ours_ahead", "", Format::AsShown),
    column("ours_behind", "", Format::AsShown),
    column("published", "", Format::AsShown),
    column("weights_r2", "", Format::AsShown),
];

/// Power of the test logs by every model.
pub(super) fn models(models: &[ModelRow], persistence: &[Spread; 2]) -> Table {
    let row = |(place, row): (usize, &ModelRow)| {
        let standing = Standing::of(row);
        let mark = match standing {
            _ if place == 0 => Mark::Ours,
            Standing::Behind => Mark::Against,
            Standing::Ahead | Standing::Level => Mark::None,
        };
        let of = row.ours_ahead + row.ours_behind;
        let words = if place == 0 {
            String::new()
        } else {
            format!("{} ({} of {of})", standing.words(), row.ours_ahead)
        };
        let published = row.published.map_or(String::new(), |(mape, r2)| format!("{mape:.2} / {r2:.2}"));
        let [mape, r2, rmse, mass_error] = row.quality.map(Cell::from);
        let weights =
            row.weights_r2.map_or(String::new(), |(least, greatest)| format!("{least:.2} to {greatest:.2}"));
        let count = |count: u64| Cell::shown(count, "");
        Row::new(
            mark,
            [
                row.name.clone().into(),
                row.source.into(),
                row.mass.words().into(),
                mape,
                r2,
                rmse,
                mass_error,
                row.horizon.words().into(),
                published.into(),
                words.into(),
                weights.into(),
                count(row.ours_ahead),
                count(row.ours_behind),
                Cell::shown(serde_json::json!(row.published), ""),
                Cell::shown(serde_json::json!(row.weights_r2), ""),
            ],
        )
    };
    Table {
        name: "models",
        title: "Section 7.2: power of the test logs, moving window of 25 s, and earlier methods",
        columns: &MODELS,
        rows: models.iter().enumerate().map(row).collect(),
        note: format!(
            "{} of the {} cards of Table 1 run here, of {} families; mass: given = the true mass is an input, estimated = found from speed and \
             power, unused = the model has none; mass found: the same model without the mass, which the search that ours makes finds over the last \
             25 s; mass error: mean over the samples; horizon: what a model uses of the power measured on the test drive, up to the sample or the \
             second before, or none (plan); persistence (the power of that long ago) has R² {} and {}; published: MAPE % / R²; standing: by the sign test at 5 %, in \
             brackets the seeds in which ours is better by both MAPE and R²; ours restarts its window when it notices a change of payload, the \
             others have no such detector; a network is the median of three seeds of its weights, R² by weights: of the worst and the best, \
             mean over drives; the test turns faster than the training does, where networks extrapolate",
            models.iter().filter(|row| baselines::ALL.iter().any(|card| card.name == row.name)).count(),
            baselines::ALL.len(),
            baselines::families(),
            persistence[0].text(Format::R2(3)),
            persistence[1].text(Format::R2(3)),
        ),
    }
}

/// A goal for ours in the experiment's regime.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Goal {
    /// Which figure.
    pub(super) what: &'static str,
    /// At most, or at least, this much.
    pub(super) limit: f64,
    /// `%` or nothing.
    pub(super) unit: &'static str,
    /// It is a lower limit.
    pub(super) at_least: bool,
    /// The result; `None` if not measured.
    pub(super) measured: Option<Spread>,
}

impl Goal {
    /// Whether the mean over seeds meets it; `None` where it was not measured.
    pub(super) fn is_reached(&self) -> Option<bool> {
        let mean = self.measured?.mean;
        mean.is_finite().then_some(if self.at_least { mean >= self.limit } else { mean <= self.limit })
    }

    /// The verdict.
    pub(super) fn words(&self) -> &'static str {
        match self.is_reached() {
            Some(true) => "reached",
            Some(false) => "missed",
            None => "not measured",
        }
    }
}

/// The four goals.
pub(super) fn goals(windows: &[WindowRow], models: &[ModelRow]) -> Vec<Goal> {
    let ours = models.first().map(|row| row.quality);
    let method = windows.first().map(|row| row.method);
    let worst = |window_s: f64| {
        let ours = windows.iter().filter(|row| Some(row.method) == method);
        ours.filter(|row| row.window_s == window_s).map(|row| row.figures[0]).next()
    };
    let goal = |what, limit, unit, at_least, measured| Goal { what, limit, unit, at_least, measured };
    vec![
        goal("MAPE, moving window of 25 s", 5.0, "%", false, ours.map(|quality| quality[0])),
        goal("R², moving window of 25 s", 0.93, "", true, ours.map(|quality| quality[1])),
        goal("mass error, worst window of 12.5 s", 7.0, "%", false, worst(12.5)),
        goal("mass error, worst window of 50 s", 4.0, "%", false, worst(50.0)),
    ]
}

const GOALS: [Column; 6] = [
    column("what", "figure", Format::Words),
    column("limit", "goal", Format::AsShown),
    column("unit", "", Format::Words),
    column("at_least", "", Format::AsShown),
    column("found", "ours", Format::AsShown),
    column("reached", "verdict", Format::Words),
];

/// The goals and their verdicts.
pub(super) fn goals_table(goals: &[Goal]) -> Table {
    let row = |goal: &Goal| {
        let limit = format!("{} {}", if goal.at_least { "≥" } else { "≤" }, number(goal.limit, 2));
        let measured = goal
            .measured
            .map_or(with_unit("–".to_owned(), goal.unit), |measured| measured.figure(goal.unit, 3));
        let mark = if goal.is_reached() == Some(false) { Mark::Against } else { Mark::None };
        Row::new(
            mark,
            [
                goal.what.into(),
                Cell::shown(goal.limit, with_unit(limit, goal.unit)),
                goal.unit.into(),
                Cell::shown(goal.at_least, ""),
                Cell::shown(serde_json::json!(goal.measured), measured),
                Cell::shown(serde_json::json!(goal.is_reached()), goal.words()),
            ],
        )
    };
    Table {
        name: "goals",
        title: "What is asked of ours in the experiment's regime",
        columns: &GOALS,
        rows: goals.iter().map(row).collect(),
        note: format!("by the mean over seeds; mass error, worst window: {WORST_MASS}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::Horizon;

    fn spread(low: f64, high: f64) -> Spread {
        Spread { mean: (low + high) / 2.0, low, high, least: low, greatest: high, count: 20 }
    }

    /// Of 20 throws of a fair coin 15 or more fall on one side with a probability of 21700/2²⁰ =
    /// 2.07 %, 14 or more with 5.77 %. Six of six: 1.6 %; five of five: 3.1 %.
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
            let quality = [spread(1.0, 2.0); 4];
            Standing::of(&ModelRow {
                name: "other".to_owned(),
                source: "somebody",
                mass: MassSource::Unused,
                horizon: Horizon::Plan,
                quality,
                ours_ahead,
                ours_behind,
                published: None,
                weights_r2: None,
            })
        };
        assert_eq!(standing(20, 0), Standing::Ahead);
        assert_eq!(standing(2, 18), Standing::Behind);
        assert_eq!(standing(12, 8), Standing::Level);
        assert_eq!(standing(2, 0), Standing::Level, "two seeds decide nothing");
    }

    #[test]
    fn a_goal_that_was_not_measured_is_not_reached_and_not_missed() {
        let goal = Goal { what: "R²", limit: 0.93, unit: "", at_least: true, measured: None };
        assert_eq!(goal.is_reached(), None);
        assert_eq!(Goal { measured: Some(spread(0.93, 0.95)), ..goal.clone() }.is_reached(), Some(true));
        assert_eq!(Goal { measured: Some(spread(0.90, 0.92)), ..goal.clone() }.is_reached(), Some(false));
        assert_eq!(Goal { measured: Some(spread(f64::NAN, 1.0)), ..goal }.is_reached(), None);
    }
}
