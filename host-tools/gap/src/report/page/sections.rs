//! The sections of the page, from the verdict down to the request.

use std::path::Path;

use maud::{Markup, html};
use report::html::tile;
use serde_json::Value;
use support::error::Result;

use super::course::Course;
use super::figures;
use super::given::{Inputs, Simulated};
use crate::report::Report;
use crate::report::advice;
use crate::report::localise::{Cell, Map};
use crate::report::summary;
use crate::words;
use residuals::thresholds::localise::{LEAST_ROWS, LEAST_RUNS};
use residuals::types::Verdict;

/// Runs that are drawn over time.
const DRAWN: usize = 8;

pub(super) fn verdict(report: &Report, inputs: &Inputs) -> Markup {
    let confirmed = &report.confirmed;
    let stands = report.verdict.stands();
    let kind = match report.verdict {
        Verdict::None => "none",
        Verdict::Named => "named",
        Verdict::Ambiguous => "ambiguous",
        Verdict::Unexplained => "unexplained",
    };
    html! {
        header class=(kind) {
            p class="kind" { "gmr gap · " (inputs.robot) " · " (count(inputs.logs.len(), "log")) }
            h1 id="verdict" data-verdict=(kind) { (summary::headline(report)) }
            @for named in &report.effects { p { (summary::effect(named)) "." } }
            p { (summary::gap(report)) }
            div class="tiles" {
                (tile(&words::watts(confirmed.before_w), "gap before (RMS)", ""))
                @if stands { (tile(&words::watts(confirmed.after_w), "gap after", "")) }
                (tile(&words::watts(confirmed.floor_w), &summary::floor_label(report), ""))
                @if stands {
                    @match confirmed.closed {
                        Some(closed) => (tile(&words::percent(closed), "of the gap closed", "closed")),
                        None => (tile("–", "share closed: not testable", "")),
                    }
                }
                (tile(&confirmed.runs.len().to_string(), if confirmed.runs.len() == 1 { "locked run" } else { "locked runs" }, ""))
            }
            p class="soft" {
                "The gap is the root mean square of measured less predicted power over runs that took no part in finding the effect ("
                (words::some_of(confirmed.runs.iter().map(|run| words::file_name(run))))
                "). The noise floor is the part that no effect removes: " (confirmed.floor_how) "."
            }
        }
    }
}

fn count(number: usize, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}

pub(super) fn effects(report: &Report) -> Markup {
    html! {
        @if !report.effects.is_empty() {
            h2 { "What is missing" }
            div class="wide" { table {
                tr { th { "effect" } th { "meaning" } th class="number" { "size" } th class="number" { "coefficient" } th { "detail" } }
                @for named in &report.effects {
                    @let candidate = &named.candidate;
                    @for (place, (value, error)) in named.coefficients.iter().zip(&named.std_errs).enumerate() {
                        tr {
                            td { code { (candidate.id) } }
                            td { (words::meaning(candidate)) }
                            td class="number" { @if place == 0 { (words::physical(named).unwrap_or_default()) } }
                            td class="number" { (words::quantity(*value, *error, &candidate.unit)) }
                            td { (candidate.detail.words()) }
                        }
                    }
                }
            } }
            p class="soft" { "± is one standard error. The size is the world's; a coefficient is the model's, with the drive's losses folded in: of a slope it is the sine times the base's inertia gain. What has no unit is a share." }
        }
    }
}

pub(super) fn probabilities(report: &Report) -> Result<Markup> {
    let labels = report.relabelled.map(summary::relabelled);
    Ok(html! {
        @if let Some(figure) = figures::probabilities(report)? { (figure) }
        @if let Some(labels) = labels { p { (labels) } }
        @for note in &report.notes { p class="soft" { (note) "." } }
    })
}

pub(super) fn next(report: &Report) -> Markup {
    let steps = advice::next_steps(report);
    let heading = match report.verdict {
        Verdict::Ambiguous => "What would tell the rivals apart",
        _ => "What to do next",
    };
    html! {
        div class="call" {
            h3 { (heading) }
            ul { @for step in &steps { li { (step) } } }
        }
    }
}

pub(super) fn gap(report: &Report) -> Result<Markup> {
    Ok(html! {
        h2 { "The gap, run by run" }
        @if report.residuals.1.is_some() {
            p class="soft" { "Paired by run, the mean square shrinks: " (summary::gain(report)) "." }
        }
        (figures::gaps(report)?)
    })
}

pub(super) fn maps(cells: &[Cell], map: &Map) -> Result<Markup> {
    let worst: Vec<&Cell> = cells.iter().filter(|cell| cell.stands_out()).collect();
    Ok(html! {
        h2 { "Where model and measurement disagree" }
        p class="soft" {
            "Mean of measured less predicted power over the means of the runs, open and locked, with its 95 % band. The run is the unit: a cell of fewer than "
            (LEAST_RUNS) " runs with " (LEAST_ROWS) " rows each is joined to its neighbour or left out. All plots have one scale."
        }
        @if worst.is_empty() { p { "No cell's band leaves out zero." } }
        div class="grid" {
            @for figure in figures::map(map)? { (figure) }
            @for figure in figures::cells(cells)? { (figure) }
        }
        (cell_table(cells))
    })
}

fn cell_table(cells: &[Cell]) -> Markup {
    html! {
        details {
            summary { "All cells as a table" }
            table {
                tr { th { "where" } th class="number" { "before (W, 95 %)" } th class="number" { "after (W, 95 %)" } th class="number" { "runs" } }
                @for cell in cells {
                    tr {
                        td { (cell.words) }
                        td class="number" { (mean_with_band(cell.mean_residual_w, cell.band_w)) }
                        td class="number" {
                            @if let (Some(mean), Some(band)) = (cell.mean_after_w, cell.band_after_w) {
                                (mean_with_band(mean, band))
                            }
                        }
                        td class="number" { (cell.runs) }
                    }
                }
            }
        }
    }
}

/// A mean and half of its 95 % interval; what rounds to nothing has no sign.
fn mean_with_band(mean_w: f64, band_w: f64) -> String {
    let said = format!("{mean_w:+.3}");
    format!("{} ± {band_w:.3}", if said == "-0.000" || said == "+0.000" { "0.000" } else { &said })
}

pub(super) fn courses(courses: &[Course]) -> Result<Markup> {
    let mut locked: Vec<&Course> = courses.iter().filter(|course| course.locked).collect();
    locked.sort_by(|a, b| b.gaps().0.total_cmp(&a.gaps().0));
    let all = locked.len();
    locked.truncate(DRAWN);
    Ok(html! {
        h2 { "Power over time, locked runs" }
        @if all > DRAWN { p class="soft" { "The " (DRAWN) " runs with the greatest gap of " (all) "." } }
        @for course in locked { (figures::course(course)?) }
    })
}

pub(super) fn simulated(simulated: &Simulated) -> Result<Markup> {
    Ok(html! {
        h2 { "The simulation's gap" }
        @for text in &simulated.text { p { (text) } }
        div class="grid" { @for figure in figures::cells(&simulated.cells)? { (figure) } }
        @for course in simulated.courses.iter().filter(|course| course.locked).take(DRAWN) { (figures::course(course)?) }
    })
}

pub(super) fn scores(report: &Report) -> Result<Markup> {
    Ok(html! {
        h2 { "What each candidate explains" }
        @for (number, round) in (1..).zip(&report.rounds) {
            @if let Some(figure) = figures::scores(number, round)? { (figure) }
            details {
                summary { "Round " (number) ", all candidates" }
                div class="wide" { table {
                    tr { th { "effect" } th { "status" } th class="number" { "gain in χ²" } th class="number" { "coefficients" } th { "detail" } }
                    @for scored in &round.candidates {
                        tr {
                            td { code { (scored.id) } }
                            td { (scored.status.text()) }
                            td class="number" { (format!("{:.1}", scored.gain)) }
                            td class="number" { (words::some_of(scored.coefficients.iter().map(|c| format!("{c:.3e}")))) }
                            td { (scored.detail.words()) }
                        }
                    }
                } }
            }
        }
    })
}

pub(super) fn base(report: &Report, inputs: &Inputs) -> Markup {
    let Value::Object(moves) = report.base_moves() else { return Markup::default() };
    let number = |value: &Value, key: &str| value.get(key).and_then(Value::as_f64).unwrap_or(f64::NAN);
    html! {
        h2 { "How the base coefficients moved" }
        table {
            tr { th { "parameter" } th class="number" { "before" } th class="number" { "after" } th class="number" { "change" } }
            @for (name, values) in &moves {
                @let (before, after) = (number(values, "before"), number(values, "after"));
                tr {
                    td { code { (name) } }
                    td class="number" { (format!("{before:.4e}")) }
                    td class="number" { (format!("{after:.4e}")) }
                    td class="number" { @if before != 0.0 { (format!("{:+.1} %", 100.0 * (after / before - 1.0))) } }
                }
            }
        }
        @if !inputs.clean.is_empty() { p class="soft" {
            "With clean runs at hand the base stays where its fit left it; what it gets wrong on them is taken out along smooth functions instead."
        } }
    }
}

pub(super) fn not_testable(report: &Report) -> Markup {
    html! {
        h2 { "Not testable with these runs" }
        @if report.not_testable.is_empty() { p { "Every effect of the dictionary could be tested." } }
        @else {
            table {
                tr { th { "effect" } th { "why" } }
                @for missing in &report.not_testable { tr { td { code { (missing.id) } } td { (missing.reason) } } }
            }
        }
    }
}

pub(super) fn inputs(inputs: &Inputs, locked: &[String]) -> Markup {
    let path = |path: &Path| path.display().to_string();
    html! {
        h2 { "What was asked" }
        table {
            tr { th { "gmr" } td { (env!("CARGO_PKG_VERSION")) } }
            tr { th { "robot" } td { (inputs.robot) } }
            tr { th { "coefficients" } td {
                @match &inputs.coefficients {
                    Some(file) => code { (path(file)) },
                    None => "none: base and effects fitted together",
                }
            } }
            @for (name, value) in &inputs.options { tr { th { (name) } td { (value) } } }
            tr { th { "runs" } td { @for log in &inputs.logs { div { code { (path(log)) } } } } }
            tr { th { "locked" } td { @for run in locked { div { code { (run) } } } } }
            tr { th { "clean runs" } td {
                @if inputs.clean.is_empty() { "none at hand" }
                @for log in &inputs.clean { div { code { (path(log)) } } }
            } }
        }
    }
}
