//! The fleet on one self-contained page.

use std::path::Path;

use maud::{Markup, html};
use report::html::{WHOLE, document, figure, tile};
use report::{Bars, Panel, palette};
use support::error::Result;
use support::output::write_content;

use super::abstain::Judged;
use super::disagree::Disagreements;
use super::drift::Drift;
use super::outlier::Outliers;
use super::rank::Standing;

/// Robots that are drawn; all of them stand in the table.
const DRAWN: usize = 20;

/// What is on the page.
#[derive(Debug, Clone, Copy)]
pub(super) struct Content<'a> {
    /// In one sentence.
    pub finding: &'a str,
    /// The robots, the dearest first.
    pub standings: &'a [Standing],
    /// What changed.
    pub drift: &'a Drift,
    /// Who stands out.
    pub outliers: &'a Outliers,
    /// Runs that disagree.
    pub disagreements: &'a Disagreements,
    /// Every run.
    pub judged: &'a [Judged],
}

/// Writes the page, whole or not at all.
///
/// # Errors
/// It cannot be drawn or written.
pub(super) fn save(file: &Path, content: &Content<'_>) -> Result<()> {
    let Content { finding, standings, drift, outliers, disagreements, judged } = *content;
    let used = judged.iter().filter(|run| run.is_used).count();
    let body = html! {
        h1 { (sentence(finding)) }
        div class="tiles" {
            (tile(&standings.len().to_string(), "robots", ""))
            (tile(&used.to_string(), "runs that count", ""))
            (tile(&(judged.len() - used).to_string(), "runs left out", ""))
            (tile(&drift.changes.len().to_string(), "changes found", ""))
        }
        (changes(drift))
        (standing_out(outliers))
        (disagreeing(disagreements))
        (ranking(standings)?)
        (runs(judged))
    };
    let page = document(&format!("gmr fleet: {finding}"), body);
    write_content(file, page)
}

/// With a capital letter.
fn sentence(finding: &str) -> String {
    let mut letters = finding.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

fn changes(drift: &Drift) -> Markup {
    html! {
        h2 { "What changed" }
        @if drift.changes.is_empty() { p { "Nothing that stands out of how runs differ by chance." } }
        ul { @for change in &drift.changes { li { (change.sentence()) } } }
        @if let Some(threshold) = drift.threshold {
            p {
                "Asked of every robot, coefficient and day: " (drift.asked) " questions, so a step has to be " (format!("{threshold:.1}"))
                " standard errors to stand. Intervals are 95 %."
            }
        }
        @for (robot, why) in &drift.silent { p { (robot) ": nothing can be said: " (why) } }
    }
}

fn standing_out(outliers: &Outliers) -> Markup {
    html! {
        h2 { "Robots unlike the others" }
        @if let Some(why) = &outliers.silent { p { "Nothing can be said: " (why) "." } }
        @else if outliers.robots.is_empty() { p { "None that stands out of how robots differ." } }
        ul { @for outlier in &outliers.robots { li { (outlier.sentence()) } } }
        @if let Some(threshold) = outliers.threshold {
            p {
                "Every robot and coefficient, " (outliers.asked) " questions, before what changed on it: " (format!("{threshold:.1}"))
                " standard deviations of robots are needed, so that a fleet of like robots has a name here once in "
                (format!("{:.0}", 1.0 / outliers.level)) " times. Intervals are 95 %, and hold the scatter of robots."
            }
        }
    }
}

fn disagreeing(disagreements: &Disagreements) -> Markup {
    html! {
        h2 { "Runs that disagree with their robot" }
        @if let Some(why) = &disagreements.silent { p { "Nothing can be said: " (why) "." } }
        @else if disagreements.runs.is_empty() { p { "None more than runs do." } }
        ul { @for run in &disagreements.runs { li { (run.sentence()) } } }
        @if disagreements.threshold.is_some() {
            p {
                "Power that the robot's own coefficients leave, against all " (disagreements.asked)
                " runs. Which effect it is, sums do not tell: gmr gap on these logs does. What is short within a run, or the same on all runs, "
                "is not seen here."
            }
        }
    }
}

fn ranking(standings: &[Standing]) -> Result<Markup> {
    let cost = |standing: &Standing| standing.energy_per_metre_j_m.unwrap_or(0.0);
    let bars = Bars {
        title: "Energy per metre".to_owned(),
        x_label: "J/m".to_owned(),
        series: vec![("energy per metre".to_owned(), palette(0))],
        rows: standings.iter().take(DRAWN).map(|one| (one.robot.clone(), vec![(0, cost(one))])).collect(),
        ..Bars::default()
    };
    let drawn = standings.len().min(DRAWN);
    let height = WHOLE.1.max(60 + 26 * drawn as u32);
    let about = format!("The {drawn} robots to which a metre costs most.");
    Ok(html! {
        h2 { "Energy per metre" }
        (figure(Panel::from(bars), (WHOLE.0, height), "Energy per metre", &about)?)
        table {
            thead { tr { th { "robot" } th { "J/m" } th { "km" } th { "kJ" } th { "mean mass, kg" } th { "straight, empty, W" } th { "runs" } th { "days" } } }
            tbody {
                @for one in standings {
                    tr {
                        td { (one.robot) }
                        td { (one.energy_per_metre_j_m.map_or("–".to_owned(), |cost| format!("{cost:.3}"))) }
                        td { (format!("{:.3}", one.distance_m / 1e3)) }
                        td { (format!("{:.3}", one.energy_j / 1e3)) }
                        td { (format!("{:.2}", one.mean_mass_kg)) }
                        td { (one.straight_w.map_or("–".to_owned(), |watts| format!("{watts:.3}"))) }
                        td { (one.runs) }
                        td { (one.days) }
                    }
                }
            }
        }
    })
}

fn runs(judged: &[Judged]) -> Markup {
    let said = || judged.iter().filter(|run| !run.notes.is_empty());
    html! {
        h2 { "Runs with something to know" }
        @if said().next().is_none() { p { "None." } }
        table {
            tbody {
                @for run in said() {
                    tr {
                        td { (run.run) }
                        td { (if run.is_used { "counts" } else { "left out" }) }
                        td { (run.notes.join("; ")) }
                    }
                }
            }
        }
    }
}
