//! The tables, once for text and page: fixed digits, no times and no dates, so that the same seeds give the same bytes.

mod experiment;
mod render;
mod simulation;
mod trade;

use std::fmt;

use super::study::{Settings, Spread, Study};

/// One table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    /// Its short name: an anchor in the page.
    pub name: &'static str,
    /// What it holds.
    pub title: String,
    /// Names of the columns; those that begin with `#` hold numbers, and the page and the text set them right.
    pub head: Vec<&'static str>,
    /// Cells of each row.
    pub rows: Vec<Row>,
    /// What has to be known to read it.
    pub note: String,
}

/// One row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Row {
    /// One a column.
    pub cells: Vec<String>,
    /// How it is marked.
    pub mark: Mark,
}

/// What stands out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// Nothing.
    None,
    /// Ours.
    Ours,
    /// Better than ours, or a goal missed.
    Against,
}

impl Table {
    /// Every table, in the order of the paper.
    pub fn all(study: &Study) -> Vec<Self> {
        vec![
            experiment::goals(&study.experiment),
            simulation::table(&study.simulation),
            experiment::knobs(&study.experiment),
            experiment::nearness(&study.experiment),
            experiment::windows(&study.experiment),
            experiment::models(&study.experiment),
            experiment::left_out(&study.experiment),
            trade::recalibration(&study.recalibration),
            trade::price(&study.price),
            trade::print(&study.print),
        ]
    }

    /// Names of the columns without their marks, and whether they hold numbers.
    pub fn columns(&self) -> impl Iterator<Item = (&'static str, bool)> {
        self.head.iter().map(|head| match head.strip_prefix('#') {
            Some(name) => (name, true),
            None => (*head, false),
        })
    }
}

/// All tables as text.
pub fn text(study: &Study) -> String {
    let tables: Vec<String> = Table::all(study).iter().map(ToString::to_string).collect();
    format!("{}. Figures are {INTERVALS}.\n\n{}", seeds(&study.settings), tables.join("\n"))
}

/// How to read a figure with an interval.
pub(super) const INTERVALS: &str = "means over seeds with the 95 % intervals of the means [low, high]; an end that few seeds would put \
                                    beyond what a figure can be (an error below 0, R² above 1) is shown at that limit";

/// Which seeds.
pub(super) fn seeds(settings: &Settings) -> String {
    let first = settings.first_seed;
    match settings.seeds {
        1 => format!("Seed {first}"),
        count => format!("Seeds {first} to {}", first + count.saturating_sub(1)),
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        render::render(self, f)
    }
}

/// A row without a mark.
fn plain(cells: Vec<String>) -> Row {
    Row { cells, mark: Mark::None }
}

/// `mean [low, high]` with so many digits; a dash where nothing is known.
pub(super) fn spread(spread: &Spread, digits: usize) -> String {
    if spread.low.is_finite() && spread.high.is_finite() {
        let [mean, low, high] = [spread.mean, spread.low, spread.high].map(|value| number(value, digits));
        return format!("{mean} [{low}, {high}]");
    }
    number(spread.mean, digits)
}

/// As [`spread`], of what is not below 0: errors, times, rates.
fn error(error: &Spread, digits: usize) -> String {
    spread(&Spread { low: error.low.clamp(0.0, f64::INFINITY), ..*error }, digits)
}

/// As [`error`], of a share in %.
fn share(share: &Spread, digits: usize) -> String {
    error(&Spread { high: share.high.clamp(f64::NEG_INFINITY, 100.0), ..*share }, digits)
}

/// As [`spread`], of R²: not above 1.
fn r2(r2: &Spread, digits: usize) -> String {
    spread(&Spread { high: r2.high.clamp(f64::NEG_INFINITY, 1.0), ..*r2 }, digits)
}

/// Of an error in its unit, or of R², which has none.
fn figure(figure: &Spread, unit: &str, digits: usize) -> String {
    if unit.is_empty() { r2(figure, digits) } else { error(figure, digits) }
}

/// A number with so many digits; a dash where it is none.
pub(super) fn number(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let text = format!("{value:.digits$}");
    // Rounded to nought from below.
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.')) => rest.to_owned(),
        _ => text,
    }
}

/// A number with its unit.
pub(super) fn with_unit(text: String, unit: &str) -> String {
    if unit.is_empty() { text } else { format!("{text} {unit}") }
}

#[cfg(test)]
mod tests {
    use super::{error, number, r2, share, spread};
    use crate::reproduce::study::Spread;

    /// Two values: ± 12.7062 · half their distance. 1 and 2: −4.85 … 7.85; 60 and 100: −174 … 334; 0.9 and 1.0: 0.315 … 1.585.
    #[test]
    fn an_interval_is_shown_as_far_as_its_figure_can_be() {
        assert_eq!(error(&Spread::over(&[1.0, 2.0]), 2), "1.50 [0.00, 7.85]");
        assert_eq!(share(&Spread::over(&[60.0, 100.0]), 0), "80 [0, 100]");
        assert_eq!(r2(&Spread::over(&[0.9, 1.0]), 3), "0.950 [0.315, 1.000]");
        assert_eq!(r2(&Spread::over(&[-1.0, -2.0]), 2), "-1.50 [-7.85, 1.00]");
        assert_eq!(error(&Spread::over(&[1.0]), 1), "1.0", "one seed has no interval");
        assert_eq!(r2(&Spread::over(&[1.0]), 1), "1.0", "one seed has no interval");
    }

    #[test]
    fn numbers_have_fixed_digits_and_no_negative_nought() {
        assert_eq!(number(-0.001, 2), "0.00");
        assert_eq!(number(-0.005_1, 2), "-0.01");
        assert_eq!(number(f64::NAN, 2), "–");
        assert_eq!(spread(&Spread::over(&[1.0]), 1), "1.0");
        // Mean 1.5, s = 0.7071, t₀.₉₇₅(1) = 12.7062: ± 12.7062 · 0.5.
        assert_eq!(spread(&Spread::over(&[1.0, 2.0]), 2), "1.50 [-4.85, 7.85]");
    }
}
