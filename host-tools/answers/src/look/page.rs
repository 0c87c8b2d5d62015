//! The page of a look: what the summary says, and power over time, speed and turn.

use maud::html;
use report::html::WHOLE;
use report::zoom::{Zoomed, document, figure};
use report::{CellSeries, Cells, Line, Stroke, TimeSeries, palette};
use support::error::Result;

use super::report::Report;

/// One self-contained page.
///
/// # Errors
/// A figure that cannot be drawn.
pub fn page(report: &Report) -> Result<String> {
    let mut figures = Vec::new();
    let power = report.tally.power.points();
    if power.iter().any(|(_, power)| power.is_finite()) {
        let line =
            Line { name: "power".to_owned(), points: power, colour: palette(0), stroke: Stroke::Solid };
        let series =
            TimeSeries { y_label: "power (W)".to_owned(), lines: vec![line], ..TimeSeries::default() };
        let zoomed = Zoomed::of_line(&series);
        figures.push(figure(
            series,
            zoomed.as_ref(),
            WHOLE,
            "Power over time",
            "Power over the log, averaged within each point's time.",
        )?);
    }
    for (title, label, cells) in report.charts() {
        if cells.len() < 2 {
            continue;
        }
        let series = CellSeries {
            name: "mean, and its standard deviation around it".to_owned(),
            colour: palette(0),
            cells: cells.iter().map(|cell| (cell.from, cell.to, cell.mean_w, cell.std_w)).collect(),
        };
        let cells = Cells {
            title: title.to_owned(),
            x_label: label.to_owned(),
            y_label: "power (W)".to_owned(),
            y_range: None,
            series: vec![series],
        };
        let zoomed = Zoomed::of_cells(&cells);
        figures.push(figure(
            cells,
            zoomed.as_ref(),
            WHOLE,
            title,
            &format!("{title}: mean and standard deviation of each cell."),
        )?);
    }
    // What follows from the log before what is in it.
    let is_verdict = |(title, _): &(&str, Vec<String>)| !matches!(*title, "In the log" | "Read here");
    let (verdict, contents): (Vec<_>, Vec<_>) = report.lists().into_iter().partition(is_verdict);
    let body = html! {
        h1 { (report.answer()) }
        p { (report.log()) ":" (report.title()) }
        ul { @for line in report.lines() { li { (line.trim()) } } }
        @for figure in &figures { (figure) }
        @for (title, lines) in verdict.into_iter().chain(contents) {
            h2 { (title) }
            ul { @for line in lines { li { (line) } } }
        }
    };
    Ok(document("gmr look", body))
}
