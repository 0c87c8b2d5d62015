//! The fleet on one self-contained page.

use std::path::Path;

use maud::{Markup, html};

use super::abstain::Judged;
use super::drift::Drift;
use super::rank::Standing;
use crate::error::Result;
use crate::output::write_content;
use crate::report::html::{WHOLE, document, figure, tile};
use crate::report::{Bars, Panel, palette};

/// Robots that are drawn; all of them stand in the table.
const DRAWN: usize = 20;

/// Writes the page, whole or not at all.
///
/// # Errors
/// It cannot be drawn or written.
pub fn save(file: &Path, standings: &[Standing], drift: &Drift, judged: &[Judged]) -> Result<()> {
    let used = judged.iter().filter(|run| run.is_used).count();
    let body = html! {
        h1 { "Fleet" }
        div class="tiles" {
            (tile(&standings.len().to_string(), "robots", ""))
            (tile(&used.to_string(), "runs that count", ""))
            (tile(&(judged.len() - used).to_string(), "runs left out", ""))
            (tile(&drift.changes.len().to_string(), "changes found", ""))
        }
        (changes(drift))
        (ranking(standings)?)
        (runs(judged))
    };
    let page = document("gmr fleet", body);
    write_content(file, page)
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
            thead { tr { th { "robot" } th { "J/m" } th { "km" } th { "kJ" } th { "mean mass, kg" } th { "runs" } th { "days" } } }
            tbody {
                @for one in standings {
                    tr {
                        td { (one.robot) }
                        td { (one.energy_per_metre_j_m.map_or("–".to_owned(), |cost| format!("{cost:.3}"))) }
                        td { (format!("{:.3}", one.distance_m / 1e3)) }
                        td { (format!("{:.3}", one.energy_j / 1e3)) }
                        td { (format!("{:.2}", one.mean_mass_kg)) }
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
