//! The plots of the page.

use std::collections::HashSet;

use maud::Markup;
use report::html::{HALF, WHOLE, figure};
use report::{Bars, CellSeries, Cells, Colour, Heat, HeatSquare, Line, Stroke, TimeSeries, palette};
use support::error::Result;

use super::course::Course;
use crate::report::Report;
use crate::report::localise::{Cell, Map, Square};
use crate::report::summary;
use crate::words;
use residuals::types::{Round, Status};

/// Before: what the model lacks shows in orange. After: blue.
fn colours() -> [Colour; 2] {
    [palette(1), palette(0)]
}

/// RMS of measured less predicted power of each locked run, before and after, against the floor.
pub(super) fn gaps(report: &Report) -> Result<Markup> {
    let confirmed = &report.confirmed;
    let after = report.residuals.1.is_some();
    let [orange, blue] = colours();
    let mut series = vec![("before".to_owned(), orange)];
    if after {
        series.push(("after".to_owned(), blue));
    }
    let rows: Vec<_> = confirmed
        .runs
        .iter()
        .zip(&confirmed.by_run)
        .map(|(name, (before_w2, after_w2))| {
            let mut bars = vec![(0, before_w2.sqrt())];
            if after {
                bars.push((1, after_w2.sqrt()));
            }
            (words::file_name(name), bars)
        })
        .collect();
    let height = 150 + 46 * rows.len() as u32;
    let bars = Bars {
        title: "Gap on the locked runs".to_owned(),
        x_label: "RMS of measured less predicted power (W)".to_owned(),
        series,
        rows,
        line: Some(("noise floor".to_owned(), confirmed.floor_w)),
        most: None,
    };
    let about = format!(
        "Each locked run's gap; what lies beyond the noise floor ({}) could be explained.",
        summary::floor(report)
    );
    figure(bars, (WHOLE.0, height), "Gap on the locked runs", &about)
}

/// Label of an axis in a plot.
fn axis_label(axis: &str) -> String {
    match axis {
        "speed" => "forward speed while moving (m/s)",
        "acceleration" => "acceleration along the way (m/s²); braking is negative",
        "turn-rate" => "turn rate (rad/s); left is positive",
        "mass" => "total mass (kg)",
        "time" => "time since start (s)",
        "side" => "right turns | straight | left turns (rad/s)",
        "heading" => "heading from the start's (rad)",
        "speed-turning-left" => "speed in left turns (m/s)",
        "speed-turning-right" => "speed in right turns (m/s)",
        other => other,
    }
    .to_owned()
}

/// Mean residual by each axis, all to one scale.
pub(super) fn cells(cells: &[Cell]) -> Result<Vec<Markup>> {
    let mut axes: Vec<&str> = Vec::new();
    for cell in cells.iter().filter(|cell| cell.from < cell.to) {
        if !axes.contains(&cell.axis.as_str()) {
            axes.push(&cell.axis);
        }
    }
    let ends = |cell: &Cell| {
        [cell.mean_residual_w - cell.band_w, cell.mean_residual_w + cell.band_w, cell.mean_residual_w]
    };
    // A band of three runs may be wider than everything else: the scale follows the means, and may
    // cut bands.
    let most = cells.iter().map(|cell| cell.mean_residual_w.abs()).fold(0.0, f64::max);
    let (low, high) = cells
        .iter()
        .flat_map(ends)
        .fold((-0.2 * most, 0.2 * most), |(low, high), x| (low.min(x), high.max(x)));
    let range = (low.max(-2.0 * most), high.min(2.0 * most));
    let range = (range.0 < range.1).then_some((1.05 * range.0, 1.05 * range.1));
    let [orange, blue] = colours();
    axes.iter()
        .map(|axis| {
            let cells: Vec<&Cell> = cells.iter().filter(|cell| cell.axis == *axis).collect();
            let before = cells.iter().map(|cell| (cell.from, cell.to, cell.mean_residual_w, cell.band_w));
            let mut series =
                vec![CellSeries { name: "before".to_owned(), colour: orange, cells: before.collect() }];
            let after = cells
                .iter()
                .filter_map(|cell| Some((cell.from, cell.to, cell.mean_after_w?, cell.band_after_w?)));
            let after: Vec<_> = after.collect();
            if !after.is_empty() {
                series.push(CellSeries { name: "after".to_owned(), colour: blue, cells: after });
            }
            let worst =
                cells.iter().max_by(|a, b| a.mean_residual_w.abs().total_cmp(&b.mean_residual_w.abs()));
            let about =
                worst.map_or(String::new(), |cell| format!("Greatest mean: {}.", summary::cell_words(cell)));
            let title = format!("Residual by {}", axis.replace('-', " "));
            let panel = Cells {
                title: title.clone(),
                x_label: axis_label(axis),
                y_label: "mean residual (W)".to_owned(),
                y_range: range,
                series,
            };
            figure(panel, HALF, &title, &about)
        })
        .collect()
}

/// The residual over speed and turn rate, before and after to one scale.
pub(super) fn map(map: &Map) -> Result<Vec<Markup>> {
    let most = map.squares.iter().map(|square| square.before_w.abs()).fold(0.0, f64::max);
    let heat = |title: &str, value: &dyn Fn(&Square) -> Option<f64>| {
        let squares = map
            .squares
            .iter()
            .filter_map(|square| Some(HeatSquare { x: square.x, y: square.y, value: value(square)? }));
        let panel = Heat {
            title: title.to_owned(),
            labels: ["forward speed (m/s)".to_owned(), map.y_label.to_owned()],
            most,
            squares: squares.collect(),
        };
        let about = "Mean residual in W over the means of the runs: blue where less was measured than predicted, orange where more; squares of fewer than three runs are left out.";
        figure(panel, (HALF.0, 420), title, about)
    };
    if map.squares.is_empty() {
        return Ok(Vec::new());
    }
    let mut both = vec![heat("Residual map, before", &|square| Some(square.before_w))?];
    if map.squares.iter().any(|square| square.after_w.is_some()) {
        both.push(heat("Residual map, after", &|square| square.after_w)?);
    }
    Ok(both)
}

/// Power over time of one run.
pub(super) fn course(course: &Course) -> Result<Markup> {
    let name = words::file_name(&course.name);
    let points = |values: &[f64]| course.time_s.iter().copied().zip(values.iter().copied()).collect();
    let line = |name: &str, values: &[f64], colour, stroke| Line {
        name: name.to_owned(),
        points: points(values),
        colour,
        stroke,
    };
    let [orange, blue] = colours();
    let mut lines = vec![
        line("measured", &course.measured_w, palette(6), Stroke::Solid),
        line("predicted before", &course.before_w, orange, Stroke::Solid),
    ];
    if let Some(after) = &course.after_w {
        lines.push(line("predicted after", after, blue, Stroke::Dashed));
    }
    let (before, after) = course.gaps();
    let about = match after {
        Some(after) => format!("Gap {} before, {} after.", words::watts(before), words::watts(after)),
        None => format!("Gap {}.", words::watts(before)),
    };
    let panel =
        TimeSeries { title: name.clone(), y_label: "power (W)".to_owned(), lines, ..TimeSeries::default() };
    figure(panel, WHOLE, &format!("Power over time, {name}"), &about)
}

/// Probability of each listed effect, where it is known.
pub(super) fn probabilities(report: &Report) -> Result<Option<Markup>> {
    let all = &report.rivals;
    let rows: Vec<_> =
        all.iter().map(|(id, probability)| (first_letters(id), vec![(0, 100.0 * probability)])).collect();
    let Some((likeliest, probability)) = all.first() else { return Ok(None) };
    let about =
        format!("{} is the likeliest, with {}.", first_letters(likeliest), words::probability(*probability));
    let height = 140 + 26 * rows.len() as u32;
    let title = "How probable each cause is";
    let bars = Bars {
        title: title.to_owned(),
        x_label: "probability (%)".to_owned(),
        series: vec![("probability".to_owned(), palette(0))],
        rows,
        line: None,
        most: Some(100.0),
    };
    figure(bars, (WHOLE.0, height), title, &about).map(Some)
}

/// Candidates of a round that are drawn: all of the dictionary, and some users' own.
const DRAWN: usize = 32;

/// What candidates may be.
const KINDS: [(Status, &str); 6] = [
    (Status::Winner, "winner"),
    (Status::Tie, "tie"),
    (Status::Worse, "worse"),
    (Status::Implausible, "implausible"),
    (Status::Unidentifiable, "unidentifiable here"),
    (Status::NotNeeded, "not needed"),
];

/// What the candidates of a round explain.
pub(super) fn scores(number: usize, round: &Round) -> Result<Option<Markup>> {
    let mut drawn: Vec<_> = round.candidates.iter().filter(|scored| scored.gain.is_finite()).collect();
    drawn.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    // The best of an effect's shapes stands for it.
    let mut seen = HashSet::new();
    drawn.retain(|scored| seen.insert(&scored.id));
    drawn.truncate(DRAWN);
    if drawn.is_empty() {
        return Ok(None);
    }
    let kind = |status: Status| KINDS.iter().position(|(kind, _)| *kind == status).unwrap_or(KINDS.len() - 1);
    let shades = [palette(2), palette(4), palette(5), palette(3), palette(6), palette(5)];
    let used: Vec<usize> =
        (0..KINDS.len()).filter(|place| drawn.iter().any(|scored| kind(scored.status) == *place)).collect();
    let rows = drawn.iter().map(|scored| {
        let detail = scored.detail.words();
        let name = if detail.is_empty() { scored.id.clone() } else { format!("{}: {detail}", scored.id) };
        let series = used.iter().position(|place| *place == kind(scored.status)).unwrap_or(0);
        // A candidate that explains nothing has a name and no bar.
        (first_letters(&name), vec![(series, scored.gain.max(0.0).sqrt())])
    });
    let rows: Vec<_> = rows.collect();
    let height = 140 + 26 * rows.len() as u32;
    let title = format!("Round {number}: what each candidate explains");
    let panel = Bars {
        title: title.clone(),
        x_label: "square root of the gain in χ²: about standard errors".to_owned(),
        series: used.iter().map(|&place| (KINDS[place].1.to_owned(), shades[place])).collect(),
        rows,
        line: Some(("structure allowed".to_owned(), round.allowed)),
        most: None,
    };
    let about = format!(
        "Structure {:.1}, allowed {:.1}: {}. {} effects in {} shapes, the best of each.",
        round.structure,
        round.allowed,
        round.outcome,
        drawn.len(),
        round.candidates.len()
    );
    figure(panel, (WHOLE.0, height), &title, &about).map(Some)
}

/// Letters of a candidate's name that fit beside its bar.
const LETTERS: usize = 40;

fn first_letters(name: &str) -> String {
    if name.chars().count() <= LETTERS {
        return name.to_owned();
    }
    name.chars().take(LETTERS - 1).chain(std::iter::once('…')).collect()
}
